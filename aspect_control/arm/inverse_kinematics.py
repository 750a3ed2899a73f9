"""The posture that brings the task frame nearest to a task value: inverse kinematics by damped least squares."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..redundancy import Array
from .arm import Arm
from .postures import sampling_range, task_error
from .tasks import TaskValue

REACHED = 1e-6
"""Task error, m and rad, up to which a task value counts as reached."""

Box: TypeAlias = tuple[Array, Array]
"""Smallest and largest joint positions, shapes (nv,), rad; infinite for none."""

_STEPS = 30
"""Most steps from one start."""

_LONGEST_STEP = 1.0
"""Farthest that a joint moves in one step, rad: beyond, the Jacobian says little."""

_SHORTEST_STEP = 1e-9
"""A step that moves no joint farther, rad, is the last."""

_STATIONARY = 0.01
"""Part of the squared task error that a step must be expected to remove, or it is the last."""

_DAMPING = 0.3
"""Damping as a part of the squared task error."""


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
    those of Newton's method close to it. Joints stop at the ends of the box, and take no part in a step that pushes
    them farther. The method of T. Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt
    method", IEEE Transactions on Robotics 27 (2011).

    Args:
        arm: The arm.
        x: Task value.
        positions: Joint positions to begin with, inside the box, shape (nv,), rad.
        box: Where the joints may be.
    """
    lower, upper = box
    unit = np.eye(arm.task_dim)
    nearest = Nearest(positions, np.zeros(arm.task_dim), np.inf)
    for _ in range(_STEPS):
        q = arm.configuration(positions)
        error = arm.coordinates.error(x, arm.task_position(q))
        squared = float(error @ error)
        if squared < nearest.distance**2:
            nearest = Nearest(positions, error, squared**0.5)
            if nearest.reached:
                break
        J, damping = arm.jacobian(q), (_DAMPING * squared + REACHED**2) * unit
        step = J.T @ np.linalg.solve(J @ J.T + damping, error)
        pushed = _pushed(positions, step, box)
        if pushed.any():
            J = J * ~pushed
            step = J.T @ np.linalg.solve(J @ J.T + damping, error)
        if float(error @ (J @ step)) < _STATIONARY * squared:
            break
        longest = float(np.abs(step).max())
        moved = np.clip(positions + step * min(1.0, _LONGEST_STEP / max(longest, _SHORTEST_STEP)), lower, upper)
        if np.abs(moved - positions).max() <= _SHORTEST_STEP:
            break
        positions = moved
    return nearest


def nearest_posture(arm: Arm, x: TaskValue, box: Box, rng: Any, starts: int) -> Nearest:
    """Return the first posture found with a task value, or the nearest to it of several random starts.

    Args:
        arm: The arm.
        x: Task value.
        box: Where the joints may be.
        rng: A `numpy.random.Generator`, for the starts.
        starts: How many of them, at least one.
    """
    low, high = sampling_range(arm, box)
    nearest = damped_least_squares(arm, x, rng.uniform(low, high), box)
    for _ in range(starts - 1):
        if nearest.reached:
            break
        nearest = min(nearest, damped_least_squares(arm, x, rng.uniform(low, high), box), key=lambda each: each.distance)
    return nearest


def joint_in_the_way(arm: Arm, x: TaskValue, positions: Array, box: Box) -> str | None:
    """Return the name of the joint that would move on towards a task value if it were not at an end of the box.

    Args:
        arm: The arm.
        x: Task value.
        positions: Joint positions θ, shape (nv,), rad: the nearest to the task value that the box allows.
        box: Where the joints may be.

    Returns:
        The joint with the largest descent of the squared task error; None if no joint is at such an end.
    """
    pull = arm.jacobian(arm.configuration(positions)).T @ task_error(arm, positions, x)
    pushed = np.where(_pushed(positions, pull, box), np.abs(pull), 0.0)
    return arm.joint_names[int(pushed.argmax())] if pushed.any() else None


def _pushed(positions: Array, step: Array, box: Box) -> Any:
    """Return which joints are at an end of the box that a step leads out of, shape (nv,)."""
    lower, upper = box
    return ((positions <= lower) & (step < 0.0)) | ((positions >= upper) & (step > 0.0))
