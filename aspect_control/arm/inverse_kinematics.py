"""The posture that brings the task frame nearest to a task value: inverse kinematics by damped least squares."""

from __future__ import annotations

from collections.abc import Iterable
from math import dist
from typing import Any, NamedTuple, TypeAlias

import eigenpy
import numpy as np

from ..redundancy import Array
from .arm import Arm
from .postures import sampling_range
from .tasks import TaskValue

REACHED = 1e-6
"""Task error, m and rad, up to which a task value counts as reached."""

STARTS = 40
"""Random postures that are tried before a task value counts as out of reach."""

STARTS_AT_LIMITS = 200
"""The same for a task value that only joint limits keep out of reach."""

Box: TypeAlias = tuple[Array, Array]
"""Smallest and largest joint positions, shapes (nv,), rad; infinite for none."""

_STEPS = 30
"""Most steps from one start."""

_LONGEST_STEP = 1.0
"""Farthest that a joint moves in one step, rad: beyond, the Jacobian says little."""

_SHORTEST_STEP = 1e-9
"""A step that moves no joint farther, rad, is the last."""

_STATIONARY = 1e-5
"""Part of the squared task error that a step must be expected to remove, or it is the last."""

_DAMPING = 0.03
"""Damping as a part of the squared task error."""


_OTHERS = 5
"""Random postures from which the nearest one to a task value out of reach is looked for, too."""

_ROUNDS, _SETTLED = 20, 1e-4
"""How often damped least squares goes on from where it ended, as long as the distance falls by more than a part."""


class Nearest(NamedTuple):
    """A posture and how far it is from a task value.

    Attributes:
        positions: Joint positions θ, shape (nv,), rad.
        error: x − x(θ), shape (m,), m and rad.
        distance: Its norm.
    """

    positions: Array
    error: Array
    distance: float

    @property
    def reached(self) -> bool:
        """Whether the posture has the task value, within `REACHED`."""
        return self.distance <= REACHED


def damped_least_squares(arm: Arm, x: TaskValue, positions: Array, box: Box) -> Nearest:
    """Return the nearest posture to a task value on the way that damped least squares takes from one start.

    Δθ = Jᵀ(J Jᵀ + μI)⁻¹e with a damping μ in proportion to eᵀe, so that the steps are short far from the task value and
    those of Newton's method close to it; a step that leads away is taken back, and tried again with a larger μ. Joints
    stop at the ends of the box, and take no part in a step that pushes them farther. The Levenberg-Marquardt method
    with the damping of T. Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method",
    IEEE Transactions on Robotics 27 (2011).

    Args:
        arm: The arm.
        x: Task value.
        positions: Joint positions to begin with, inside the box, shape (nv,), rad.
        box: Where the joints may be.
    """
    lower, upper = box
    unit = np.eye(arm.task_dim)
    nearest = Nearest(positions, np.zeros(arm.task_dim), np.inf)
    part = _DAMPING
    for _ in range(_STEPS):
        q = arm.configuration(positions)
        error = arm.coordinates.error(x, arm.task_position(q))
        distance = float(error.dot(error)) ** 0.5
        if distance < nearest.distance:
            nearest = Nearest(positions, error, distance)
            if nearest.reached:
                break
            J, part = arm.jacobian(q), max(part / 4.0, _DAMPING)
        else:
            part *= 4.0
        positions, error, squared = nearest.positions, nearest.error, nearest.distance**2
        damping = (part * squared + REACHED**2) * unit
        free = J
        step = _damped_step(free, error, damping)
        moved = _moved(positions, step)
        if not (lower <= moved).all() or not (moved <= upper).all():
            free = J * ~_pushed(positions, step, box)
            step = _damped_step(free, error, damping)
            moved = np.clip(_moved(positions, step), lower, upper)
        if error.dot(free.dot(step)) < _STATIONARY * squared or np.abs(moved - positions).max() <= _SHORTEST_STEP:
            break
        positions = moved
    return nearest


def _damped_step(J: Array, error: Array, damping: Array) -> Array:
    step: Array = J.T.dot(eigenpy.LLT(J.dot(J.T) + damping).solve(error).ravel())
    return step


def _moved(positions: Array, step: Array) -> Array:
    """Return where a step leads, shortened so that no joint moves too far."""
    longest = float(np.abs(step).max())
    return positions + (step if longest <= _LONGEST_STEP else step * (_LONGEST_STEP / longest))


class PostureSearch:
    """A search for postures of an arm with given task values, from near ones and from random ones.

    The random ones come from a seed of the search's own: the same searches in the same order find the same postures.

    Attributes:
        arm: The arm.
        limited: Whether it looks inside the joint limits only; if not, prismatic joints too are free.
        box: Where the joints may be.
    """

    def __init__(self, arm: Arm, *, joint_limits: bool = True) -> None:
        """Set the arm, and whether its joint limits count."""
        self.arm, self.limited = arm, joint_limits
        self.box: Box = arm.position_limits if joint_limits else (np.full(arm.nv, -np.inf), np.full(arm.nv, np.inf))
        self._rng = np.random.default_rng(0)

    def near(self, x: TaskValue, *postures: Array) -> Nearest:
        """Return the nearest posture to a task value on the way from some that are close already, shapes (nv,), rad."""
        return _nearest(damped_least_squares(self.arm, x, each, self.box) for each in postures)

    def anywhere(self, x: TaskValue, posture: Array, starts: int = STARTS) -> Nearest:
        """Return the nearest posture on the way from one, or from random ones if that does not lead to the task value.

        Args:
            x: Task value.
            posture: Joint positions to begin with, inside the box, shape (nv,), rad.
            starts: How many random ones.
        """
        nearest = self.near(x, posture)
        if nearest.reached or self._is_too_far(x):
            return nearest
        low, high = sampling_range(self.arm, self.box)
        for _ in range(starts):
            nearest = _nearest([nearest, self.near(x, self._rng.uniform(low, high))])
            if nearest.reached:
                break
        return nearest

    def decide(self, x: TaskValue, posture: Array) -> tuple[Nearest, bool]:
        """Return the nearest posture found by all means, and whether joint limits alone keep it from the task value.

        Several joint limits together leave little room for a posture: it is looked for longer where there is one
        without limits.

        Args:
            x: Task value.
            posture: Joint positions to begin with, inside the box, shape (nv,), rad.
        """
        nearest = self.anywhere(x, posture)
        if nearest.reached or not self.limited:
            return nearest, False
        if not PostureSearch(self.arm, joint_limits=False).anywhere(x, nearest.positions).reached:
            return nearest, False
        nearest = self.anywhere(x, nearest.positions, STARTS_AT_LIMITS)
        return nearest, not nearest.reached

    def settle(self, x: TaskValue, nearest: Nearest) -> Nearest:
        """Return the posture that is nearest to a task value out of reach, on the way from one or a few others."""
        low, high = sampling_range(self.arm, self.box)
        others = [self.near(x, self._rng.uniform(low, high)) for _ in range(_OTHERS)]
        nearest = _nearest([nearest, *others])
        for _ in range(_ROUNDS):
            before, nearest = nearest, self.near(x, nearest.positions)
            if nearest.distance > (1.0 - _SETTLED) * before.distance:
                break
        return nearest

    def joint_in_the_way(self, nearest: Nearest) -> str | None:
        """Return the name of the joint that would move on towards the task value if it were not at its limit.

        The one with the largest descent of the squared task error; None if no joint is at a limit of the box.
        """
        pull = self.arm.jacobian(self.arm.configuration(nearest.positions)).T @ nearest.error
        pushed = np.where(_pushed(nearest.positions, pull, self.box), np.abs(pull), 0.0)
        return self.arm.joint_names[int(pushed.argmax())] if pushed.any() else None

    def _is_too_far(self, x: TaskValue) -> bool:
        """Return whether all links in a straight line are too short, so that no search is needed."""
        if not self.limited and self.arm.prismatic.any():
            return False
        task = self.arm.coordinates
        position = x.translation[task.position_axes] if task.has_rotation else x
        return dist(position.tolist(), self.arm.kinematics.first_joint_in_task) > self.arm.reach + 2.0 * REACHED


def _nearest(found: Iterable[Nearest]) -> Nearest:
    return min(found, key=lambda each: each.distance)


def _pushed(positions: Array, step: Array, box: Box) -> Any:
    """Return which joints are at an end of the box that a step leads out of, shape (nv,)."""
    lower, upper = box
    return ((positions <= lower) & (step < 0.0)) | ((positions >= upper) & (step > 0.0))
