"""The self-motion of one redundant degree of freedom: the curve of all postures of one task value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm import Arm
from ..arm.postures import beyond_limits, jacobian, project, require_one_redundant_degree, task_error, wrap_angles
from ..arm.tasks import TaskValue
from ..checks import positive
from ..exceptions import ParameterError, RankLossError
from ..redundancy import Array, minor_measure, minors, null_vector, pseudoinverse
from .crossings import (
    AspectInterval,
    BorderCrossing,
    LimitCrossing,
    aspect_intervals,
    border_crossings,
    limit_crossings,
)

RANK_TOLERANCE = 1e-6
"""Ratio of the smallest to the largest singular value of J at which the self-motion ends for loss of rank."""

_TOLERANCE = 1e-10
"""Relative and absolute tolerance of the solver that predicts the curve, rad."""

_LONGEST_STEP = 0.2
"""Longest step of the solver, rad: it must not pass over the start of a closed curve."""

_FEEDBACK = 5.0
"""Rate at which the predicted curve is led back to the task value, 1/rad."""

_LARGEST_CORRECTION = 1e-5
"""How far a predicted posture may be off the curve, rad."""


@dataclass(frozen=True, eq=False)
class SelfMotion:
    """The curve of postures with one task value, by arc length in joint space, in the direction of `null_vector`.

    Attributes:
        arm: The arm.
        x: The task value.
        s: Arc lengths of the samples, shape (k,), rad; zero at the given posture, negative before it on an open curve.
        positions: Joint positions, shape (k, nv), rad; angles run on beyond a turn.
        closed: Whether the curve comes back to where it began, angles counted modulo a turn.
        ends: How the curve ends at the first and at the last sample: `"closed"`, `"rank loss"` (the curve branches
            there) or `"length"` (the longest length asked for).
        crossings: Where minors change sign, by arc length.
        aspects: The stretches between them.
        limit_crossings: Where joints meet their limits, by arc length.
    """

    arm: Arm
    x: TaskValue
    s: Array
    positions: Array
    closed: bool
    ends: tuple[str, str]
    crossings: tuple[BorderCrossing, ...]
    aspects: tuple[AspectInterval, ...]
    limit_crossings: tuple[LimitCrossing, ...]
    _curve: Callable[[float], Array]

    @property
    def length(self) -> float:
        """Length of the curve in joint space, rad."""
        return float(self.s[-1] - self.s[0])

    @cached_property
    def q(self) -> Array:
        """Joint configurations of the samples, shape (k, nq), rad."""
        return np.array([self.arm.configuration(each) for each in self.positions])

    @cached_property
    def jacobians(self) -> Array:
        """Jacobians of the task coordinates, shape (k, m, nv)."""
        return np.array([self.arm.jacobian(q) for q in self.q])

    @cached_property
    def minors(self) -> Array:
        """Minors in the order of `arm.minor_columns`, shape (k, p)."""
        return minors(self.jacobians, self.arm.minor_columns)

    @cached_property
    def minor_measure(self) -> Array:
        """H of Eq. (18), shape (k,), in the unit of the minors."""
        return minor_measure(self.jacobians, self.arm.minor_columns)

    @cached_property
    def task_error(self) -> Array:
        """Distance of each sample from the task value, shape (k,), m and rad."""
        return np.array([np.linalg.norm(task_error(self.arm, each, self.x)) for each in self.positions])

    @cached_property
    def within_limits(self) -> NDArray[np.bool_]:
        """Whether all joints are inside their limits, angles counted modulo a turn, shape (k,)."""
        within: NDArray[np.bool_] = np.all(beyond_limits(self.arm, self.positions) <= 0.0, axis=1)
        return within

    @property
    def signatures(self) -> set[tuple[int, ...]]:
        """The signatures of the aspects that the curve passes."""
        return {interval.signature for interval in self.aspects}

    def to_dict(self) -> dict[str, Any]:
        """Return what the curve comes to as plain numbers, strings and lists, for JSON."""
        return {
            "closed": self.closed,
            "ends": list(self.ends),
            "length": self.length,
            "aspects": [interval._asdict() for interval in self.aspects],
            "sign_changes": [crossing._asdict() for crossing in self.crossings],
            "limits": [crossing._asdict() for crossing in self.limit_crossings],
            "largest_task_error": float(self.task_error.max()),
        }

    def at(self, s: float) -> Array:
        """Return the joint positions at an arc length, shape (nv,), rad; a closed curve goes round and round."""
        return self._curve(s)


def self_motion(
    arm: Arm, q: ArrayLike, *, x: TaskValue | None = None, spacing: float = 0.02, longest: float = 100.0
) -> SelfMotion:
    """Follow the self-motion through a posture of one redundant degree of freedom.

    The curve solves dθ/ds = z(θ), z the unit null vector: SciPy's DOP853 predicts it, J⁺ leads it back to the task
    value, and every sample is corrected by Newton's method to a task error below 1e-12. Its direction is that of
    `redundancy.null_vector`, which is continuous across borders of aspects. Joint limits do not end it: they are
    reported.

    Args:
        arm: The arm, with one redundant degree of freedom.
        q: Joint configuration at s = 0, shape (nq,), rad, inside the joint limits.
        x: Task value; None for that of q. For another one, q is first corrected to it.
        spacing: Arc length between samples, at most, rad.
        longest: Length at which an open curve is given up in each direction, rad.

    Raises:
        ParameterError: If there is not exactly one redundant degree of freedom, q is beyond a joint limit, `spacing` or
            `longest` is not above zero, or the task value is not kept by motions with J θ̇ = 0, as for a task of one or
            two rotations of a spatial arm.
        RankLossError: If J has lost rank at q.
        ShapeError: If q or x has the wrong shape.
        NonFiniteError: If q or x is not finite.
    """
    spacing, longest = positive("spacing", spacing, "rad"), positive("longest", longest, "rad")
    require_one_redundant_degree(arm)
    q = arm.joints.checked_configuration(q)
    arm.require_within_limits(q)
    x = arm.task_position(q) if x is None else arm.coordinates.checked("x", x)
    start = project(arm, arm.positions(q), x)
    if start is None:
        raise ParameterError("q cannot be corrected to the task value: give a posture nearer to it")
    if _rank_ratio(arm, start) < RANK_TOLERANCE:
        raise RankLossError(
            f"the Jacobian has lost rank at q = {q.tolist()}: the self-motion branches there and has no direction; "
            "start from another posture"
        )
    forward = _trace(arm, x, start, 1.0, longest)
    closed = forward.ended == "closed"
    backward = None if closed else _trace(arm, x, start, -1.0, longest)
    first, last = (-backward.length if backward else 0.0), forward.length

    def curve(s: float) -> Array:
        around = s % last if closed else min(max(s, first), last)
        predicted = forward.curve(around) if around >= 0.0 or backward is None else backward.curve(-around)
        corrected = project(arm, predicted, x, iterations=8)
        if corrected is None or np.linalg.norm(corrected - predicted) > _LARGEST_CORRECTION:
            raise ParameterError(
                f"motions with J θ̇ = 0 do not keep the value of the task {arm.task} on {arm.name!r}: "
                "take all three rotations into the task, or none"
            )
        return corrected + (forward.curve(last) - start) * ((s - around) / last if closed else 0.0)

    s = np.linspace(first, last, max(2, int(np.ceil((last - first) / spacing)) + 1))
    positions = np.array([curve(each) for each in s[:-1]] + [forward.curve(last) if closed else curve(s[-1])])
    if closed:
        positions[-1] = start + _whole_turns(arm, positions[-1] - start)
    crossings = border_crossings(arm, curve, s, positions, closed)
    return SelfMotion(
        arm=arm,
        x=x,
        s=s,
        positions=positions,
        closed=closed,
        ends=("closed", "closed") if backward is None else (backward.ended, forward.ended),
        crossings=crossings,
        aspects=aspect_intervals(arm, curve, s, crossings, closed),
        limit_crossings=limit_crossings(arm, curve, s, positions),
        _curve=curve,
    )


class _Trace(NamedTuple):
    length: float
    ended: str
    curve: Callable[[float], Array]


def _trace(arm: Arm, x: TaskValue, start: Array, direction: float, longest: float) -> _Trace:
    """Predict the curve in one direction until it closes, loses rank or is long enough."""
    from scipy.integrate import DOP853, OdeSolution
    from scipy.optimize import brentq

    def tangent(_: float, positions: Array) -> Array:
        J = jacobian(arm, positions)
        return direction * null_vector(J) + _FEEDBACK * pseudoinverse(J) @ task_error(arm, positions, x)

    along = direction * null_vector(jacobian(arm, start))

    def progress(positions: Array) -> float:
        """Return how far a posture is along the tangent at the start; angles enter by their sine, modulo a turn."""
        displacement = positions - start
        return float(along @ np.where(arm.prismatic, displacement, np.sin(displacement)))

    solver = DOP853(tangent, 0.0, start, longest, rtol=_TOLERANCE, atol=_TOLERANCE, max_step=_LONGEST_STEP)
    knots, pieces, ended, length = [0.0], [], "length", longest
    while solver.status == "running":
        before = solver.y
        solver.step()
        if solver.status == "failed" or solver.t == knots[-1]:
            ended, length = "rank loss", knots[-1]
            break
        piece = solver.dense_output()
        knots.append(solver.t)
        pieces.append(piece)
        if progress(before) < 0.0 <= progress(solver.y):
            s = brentq(lambda s, piece=piece: progress(piece(s)), solver.t_old, solver.t, xtol=1e-14)
            if np.linalg.norm(wrap_angles(arm, piece(s) - start)) < _LARGEST_CORRECTION:
                ended, length = "closed", s
                break
        if _rank_ratio(arm, solver.y) < RANK_TOLERANCE:
            ended, length = "rank loss", solver.t
            break
    if not pieces:
        return _Trace(0.0, "rank loss", lambda s: start)
    solution: Any = OdeSolution(knots, pieces)
    return _Trace(float(length), ended, solution)


def _whole_turns(arm: Arm, displacement: Array) -> Array:
    return displacement - wrap_angles(arm, displacement)


def _rank_ratio(arm: Arm, positions: Array) -> float:
    singular_values = np.linalg.svd(jacobian(arm, positions), compute_uv=False)
    return float(singular_values[-1] / singular_values[0])
