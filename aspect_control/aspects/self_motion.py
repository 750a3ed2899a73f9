"""The self-motion of an arm with one joint to spare: the curve of all postures of one task value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm import BORDER_TOLERANCE, Arm
from ..checks import positive
from ..exceptions import ParameterError, RankLossError
from ..redundancy import Array, minor_measure, minors, null_vector, pseudoinverse
from ..tasks import TaskValue
from .postures import beyond_limits, jacobian, project, require_one_to_spare, task_error, turned

RANK_TOLERANCE = 1e-6
"""Ratio of the smallest to the largest singular value of J at which the self-motion ends for loss of rank."""

_TOLERANCE = 1e-10
"""Relative and absolute tolerance of the solver that predicts the curve, rad."""

_LONGEST_STEP = 0.2
"""Longest step of the solver, rad: it must not pass over the start of a closed curve."""

_FEEDBACK = 5.0
"""Rate at which the predicted curve is led back to the task value, 1/rad."""

_COINCIDENCE = 1e-8
"""Arc length within which sign changes of several minors count as one border, rad."""

_LARGEST_CORRECTION = 1e-5
"""How far a predicted posture may be off the curve, rad."""


class BorderCrossing(NamedTuple):
    """A place where a minor changes sign.

    Attributes:
        s: Arc length, rad.
        minor: Which one, counted from 1 in the order of `arm.minor_columns`.
    """

    s: float
    minor: int


class LimitCrossing(NamedTuple):
    """A place where a joint meets one of its limits.

    Attributes:
        s: Arc length, rad.
        joint: Name of the joint.
        leaving: Whether the joint leaves its range in the direction of growing s.
    """

    s: float
    joint: str
    leaving: bool


class AspectInterval(NamedTuple):
    """A stretch of the curve inside one aspect.

    Attributes:
        start: Arc length at its beginning, rad.
        end: Arc length at its end, rad; on a closed curve the stretch that holds the seam ends beyond the last sample.
        signature: Sign of each minor, −1, 0 or 1, shape (p,).
    """

    start: float
    end: float
    signature: tuple[int, ...]


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
    """Follow the self-motion through a posture of an arm with one joint to spare.

    The curve solves dθ/ds = z(θ), z the unit null vector: SciPy's DOP853 predicts it, J⁺ leads it back to the task
    value, and every sample is corrected by Newton's method to a task error below 1e-12. Its direction is that of
    `redundancy.null_vector`, which is continuous across borders of aspects. Joint limits do not end it: they are
    reported.

    Args:
        arm: The arm, with one joint to spare.
        q: Joint configuration at s = 0, shape (nq,), rad, inside the joint limits.
        x: Task value; None for that of q. For another one, q is first corrected to it.
        spacing: Arc length between samples, at most, rad.
        longest: Length at which an open curve is given up in each direction, rad.

    Raises:
        ParameterError: If not exactly one joint is to spare, q is beyond a joint limit, `spacing` or `longest` is not
            above zero, or the task value is not kept by motions with J θ̇ = 0, as for a task of one or two rotations
            of a spatial arm.
        RankLossError: If J has lost rank at q.
        ShapeError: If q or x has the wrong shape.
        NonFiniteError: If q or x is not finite.
    """
    spacing, longest = positive("spacing", spacing, "rad"), positive("longest", longest, "rad")
    require_one_to_spare(arm)
    q = arm.checked_configuration(q)
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
    crossings = _border_crossings(arm, curve, s, positions, closed)
    return SelfMotion(
        arm=arm,
        x=x,
        s=s,
        positions=positions,
        closed=closed,
        ends=("closed", "closed") if backward is None else (backward.ended, forward.ended),
        crossings=crossings,
        aspects=_aspects(arm, curve, s, crossings, closed),
        limit_crossings=_limit_crossings(arm, curve, s, positions),
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
            if np.linalg.norm(turned(arm, piece(s) - start)) < _LARGEST_CORRECTION:
                ended, length = "closed", s
                break
        if _rank_ratio(arm, solver.y) < RANK_TOLERANCE:
            ended, length = "rank loss", solver.t
            break
    if not pieces:
        return _Trace(0.0, "rank loss", lambda s: start)
    solution: Any = OdeSolution(knots, pieces)
    return _Trace(float(length), ended, solution)


def _border_crossings(
    arm: Arm, curve: Callable[[float], Array], s: Array, positions: Array, closed: bool
) -> tuple[BorderCrossing, ...]:
    """Return where minors change sign; a minor that is zero throughout has none."""

    def minor(index: int) -> Callable[[float], float]:
        return lambda arc: float(minors(jacobian(arm, curve(arc)), arm.minor_columns[[index]])[0])

    values = minors(np.array([jacobian(arm, each) for each in positions]), arm.minor_columns)
    found = []
    for index, column in enumerate(values.T):
        signed = np.flatnonzero(np.abs(column) > BORDER_TOLERANCE * arm.minor_scales[index])
        arcs = [(s[a], s[b]) for a, b in pairwise(signed) if column[a] * column[b] < 0.0]
        if closed and len(signed) and column[signed[-1]] * column[signed[0]] < 0.0:
            # The seam lies on the border.
            arcs.append((s[signed[-1]], s[signed[0]] + s[-1]))
        arcs += _dips(minor(index), s, column)
        for low, high in arcs:
            crossing = _root(minor(index), low, high)
            # What lies on the seam to rounding lies at its beginning.
            beyond_seam = closed and crossing > s[-1] - _COINCIDENCE
            place = max(crossing - s[-1], 0.0) if beyond_seam else crossing
            found.append(BorderCrossing(float(place), index + 1))
    return tuple(sorted(found))


def _dips(function: Callable[[float], float], s: Array, values: Array) -> list[tuple[float, float]]:
    """Return brackets of two sign changes that lie between the same samples, where a minor dips through zero."""
    from scipy.optimize import minimize_scalar

    brackets = []
    sizes, sign = np.abs(values), np.sign(values)
    inner = np.arange(1, len(s) - 1)
    lowest = (sizes[inner] <= sizes[inner - 1]) & (sizes[inner] < sizes[inner + 1])
    # A parabola through three samples of one sign can only reach zero if it falls by more than it has left.
    deep = sizes[inner] < (sizes[inner - 1] - sizes[inner]) + (sizes[inner + 1] - sizes[inner])
    same = (sign[inner] == sign[inner - 1]) & (sign[inner] == sign[inner + 1]) & (sign[inner] != 0.0)
    for i in inner[lowest & deep & same]:
        low, high = s[i - 1], s[i + 1]
        bottom = minimize_scalar(lambda arc, i=i: sign[i] * function(arc), bounds=(low, high), method="bounded").x
        if sign[i] * function(bottom) < 0.0:
            brackets += [(low, bottom), (bottom, high)]
    return brackets


def _aspects(
    arm: Arm, curve: Callable[[float], Array], s: Array, crossings: tuple[BorderCrossing, ...], closed: bool
) -> tuple[AspectInterval, ...]:
    places = _distinct([each.s for each in crossings])
    edges = [s[0], *places, s[-1]]
    if closed and places:
        edges = [*places, places[0] + s[-1]]
    intervals: list[AspectInterval] = []
    for start, end in pairwise(edges):
        values = minors(jacobian(arm, curve((start + end) / 2.0)), arm.minor_columns)
        signs = np.where(np.abs(values) <= BORDER_TOLERANCE * arm.minor_scales, 0.0, np.sign(values))
        intervals.append(AspectInterval(float(start), float(end), tuple(signs.astype(int).tolist())))
    return tuple(intervals)


def _limit_crossings(
    arm: Arm, curve: Callable[[float], Array], s: Array, positions: Array
) -> tuple[LimitCrossing, ...]:
    def beyond(joint: int) -> Callable[[float], float]:
        return lambda arc: float(beyond_limits(arm, curve(arc))[joint])

    excess = beyond_limits(arm, positions)
    found = []
    for sample, joint in zip(*np.nonzero(np.diff(excess > 0.0, axis=0)), strict=True):
        arc = _root(beyond(joint), s[sample], s[sample + 1])
        found.append(LimitCrossing(arc, arm.joint_names[joint], bool(excess[sample + 1, joint] > 0.0)))
    return tuple(sorted(found))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=1e-13))


def _distinct(places: list[float]) -> list[float]:
    """Return sorted places without those where several minors vanish at once, but for the first."""
    return [place for i, place in enumerate(places) if i == 0 or place - places[i - 1] > _COINCIDENCE]


def _whole_turns(arm: Arm, displacement: Array) -> Array:
    return displacement - turned(arm, displacement)


def _rank_ratio(arm: Arm, positions: Array) -> float:
    singular_values = np.linalg.svd(jacobian(arm, positions), compute_uv=False)
    return float(singular_values[-1] / singular_values[0])
