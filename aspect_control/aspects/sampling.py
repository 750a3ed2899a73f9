"""Sampling the postures that one task value can be reached by, for any number of redundant degrees of freedom."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.inverse_kinematics import damped_least_squares
from ..arm.postures import jacobian, project, sampling_range, task_error, wrap_into_limits
from ..arm.tasks import TaskValue
from ..checks import finite_vector, positive, whole_number
from ..exceptions import NotRedundantError, UnreachableError
from ..redundancy import Array, aspect_signature, minor_measure, minors, null_space_basis

MAX_COUNT = 1_000_000
"""The most postures that are looked for at once."""

_ATTEMPTS = 30
"""Attempts for each posture asked for, before what was found is what there is."""

_HOPELESS = 150
"""Attempts without any success after which the task value counts as out of reach."""

_NEAREST_STARTS = 12
"""Random postures from which the nearest to a task value out of reach is looked for."""

_TANGENT_STEP = 1.0
"""Longest step along the self-motion from one posture to a next, rad."""

_LIMIT_MARGIN = 1e-9
"""How far inside its limits a posture of the sample is kept, rad: no rounding puts it outside."""


@dataclass(frozen=True, eq=False)
class SelfMotionSample:
    """Postures with one task value inside the joint limits.

    Attributes:
        arm: The arm.
        x: The task value.
        positions: Joint positions, shape (k, nv), rad.
        attempts: How many postures were tried to find them.
    """

    arm: Arm
    x: TaskValue
    positions: Array
    attempts: int

    @cached_property
    def q(self) -> Array:
        """Joint configurations, shape (k, nq), rad."""
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
        """Distance of each posture from the task value, shape (k,), m and rad."""
        return np.array([np.linalg.norm(task_error(self.arm, each, self.x)) for each in self.positions])

    @cached_property
    def signatures(self) -> Counter[tuple[int, ...]]:
        """How many of the postures have each signature, by signature."""
        signs = aspect_signature(self.jacobians, self.arm.minor_columns)
        return Counter(tuple(row) for row in signs.tolist())


def sample_self_motion(
    arm: Arm, x: TaskValue, *, count: int = 200, seed: int = 0, near: ArrayLike | None = None, within: float = np.inf
) -> SelfMotionSample:
    """Sample the postures with one task value inside the joint limits.

    Half of them are random postures corrected to the task value by Newton's method with J⁺; the others are steps along
    the self-motion from postures that were found, corrected in the same way. Every task error is below 1e-12. The first
    posture is `near`, if it is given and can be corrected to the task value.

    Args:
        arm: The arm.
        x: Task value: shape (m,), m, or a `pin.SE3` for a task with rotations.
        count: How many postures; fewer are returned if they are hard to find.
        seed: Seed of the random numbers: the same seed gives the same sample.
        near: Joint positions to begin with, shape (nv,), rad; None for random ones.
        within: How far from `near` each joint may be, rad.

    Raises:
        NotRedundantError: If the task has more coordinates than the arm has joints.
        UnreachableError: If no posture is found; the message says how near the task frame came.
        ParameterError: If `count` or `seed` is no whole number in its range, or `within` is not above zero.
        ShapeError: If x or `near` has the wrong shape.
        NonFiniteError: If x or `near` is not finite.
    """
    if arm.redundancy < 0:
        raise NotRedundantError(f"the task {arm.task} has more coordinates than {arm.name!r} has joints, {arm.nv}")
    x = arm.coordinates.checked("x", x)
    count, seed = whole_number("count", count, 1, MAX_COUNT), whole_number("seed", seed, 0)
    lower, upper = search_box(arm, near, within)
    low, high = sampling_range(arm, (lower, upper))
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    centre = None if near is None else project(arm, finite_vector("near", near, arm.nv), x)
    if centre is not None and (lower <= centre).all() and (centre <= upper).all():
        found.append(centre)
    attempts = 0
    while len(found) < count and attempts < (_ATTEMPTS * count if found else _HOPELESS):
        attempts += 1
        if len(found) % 2 and len(found) > 1:
            origin = found[rng.integers(len(found))]
            basis = null_space_basis(jacobian(arm, origin))
            guess = origin + basis @ rng.uniform(-1.0, 1.0, basis.shape[1]) * min(_TANGENT_STEP, within)
        else:
            guess = rng.uniform(low, high)
        posture = project(arm, guess, x)
        if posture is not None:
            inside = posture if np.isfinite(within) else wrap_into_limits(arm, posture)
            if (lower <= inside).all() and (inside <= upper).all():
                found.append(inside)
    if not found:
        raise UnreachableError(_out_of_reach(arm, x, low, high, rng))
    return SelfMotionSample(arm, x, np.array(found), attempts)


def search_box(arm: Arm, near: ArrayLike | None, within: float) -> tuple[Array, Array]:
    """Return the smallest and the largest joint positions to look among, shapes (nv,), rad; infinite for no limit.

    Args:
        arm: The arm.
        near: Joint positions about which to look, shape (nv,), rad; None if `within` is infinite.
        within: How far from `near` each joint may be, rad; infinite for any distance.

    Raises:
        ParameterError: If `within` is not above zero.
        ShapeError: If `near` has the wrong shape.
        NonFiniteError: If `near` is not finite.
    """
    lower, upper = arm.position_limits
    if within != np.inf:
        reach = positive("within", within, "rad")
        centre = finite_vector("near", near if near is not None else [], arm.nv)
        lower, upper = np.maximum(lower, centre - reach), np.minimum(upper, centre + reach)
    return lower + _LIMIT_MARGIN, upper - _LIMIT_MARGIN


def _out_of_reach(arm: Arm, x: TaskValue, lower: Array, upper: Array, rng: Any) -> str:
    """Say how near the task frame comes to a task value that was not reached."""
    starts = (rng.uniform(lower, upper) for _ in range(_NEAREST_STARTS))
    found = [damped_least_squares(arm, x, start, (lower, upper)) for start in starts]
    error = min(found, key=lambda each: each.distance).error
    rows = arm.coordinates.position_rows, arm.coordinates.rotation_rows
    distances = [
        f"{np.linalg.norm(error[row]):.3g} {unit}" for row, unit in zip(rows, ("m", "rad"), strict=True) if row
    ]
    bound = f"; the joints add up to a reach of {arm.reach:.4g} m" if np.isfinite(arm.reach) else ""
    return (
        f"the task value {np.round(arm.coordinates.encode(x), 6).tolist()} is out of reach of {arm.name!r} inside its "
        f"joint limits: the nearest posture found leaves {' and '.join(distances)}{bound}"
    )
