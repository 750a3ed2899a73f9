"""Postures of one task value: angles modulo a turn, joint limits, and the way back to the task value."""

from __future__ import annotations

import numpy as np

from ..exceptions import ParameterError
from ..redundancy import Array, pseudoinverse
from .arm import Arm
from .tasks import TaskValue

TASK_TOLERANCE = 1e-12
"""Task error at which a posture counts as one of the task value, m and rad."""

_LONGEST_STEP = 0.7
"""Longest step of the corrector, rad: beyond, the Jacobian says little."""


def require_one_redundant_degree(arm: Arm) -> None:
    """Make sure that the self-motion of an arm is a curve.

    Raises:
        ParameterError: If there is not exactly one redundant degree of freedom.
    """
    if arm.redundancy != 1:
        raise ParameterError(
            f"the self-motion is a curve with one redundant degree of freedom; the task {arm.task} leaves "
            f"{arm.redundancy} redundant degrees of freedom of {arm.nv} joints: sample it with sample_self_motion, "
            "lock joints or take another task"
        )


def task_error(arm: Arm, positions: Array, x: TaskValue) -> Array:
    """Return x − x(θ), shape (m,), m and rad.

    Args:
        arm: The arm.
        positions: Joint positions θ, shape (nv,), rad.
        x: Task value.
    """
    return arm.coordinates.error(x, arm.task_position(arm.configuration(positions)))


def jacobian(arm: Arm, positions: Array) -> Array:
    """Return J at joint positions, shape (m, nv).

    Args:
        arm: The arm.
        positions: Joint positions θ, shape (nv,), rad.
    """
    return arm.jacobian(arm.configuration(positions))


def project(arm: Arm, positions: Array, x: TaskValue, iterations: int = 40) -> Array | None:
    """Return the joint positions that Newton's method with J⁺ leads to, or None if it does not converge.

    Every step is the shortest joint displacement that would remove the task error, so that the result is close to the
    nearest posture with that task value.

    Args:
        arm: The arm.
        positions: Joint positions to begin with, shape (nv,), rad.
        x: Task value.
        iterations: The most steps taken.

    Returns:
        Joint positions, shape (nv,), rad, with a task error of at most `TASK_TOLERANCE`.
    """
    for _ in range(iterations):
        error = task_error(arm, positions, x)
        if np.linalg.norm(error) <= TASK_TOLERANCE:
            return positions
        step = pseudoinverse(jacobian(arm, positions)) @ error
        positions = positions + step * min(1.0, _LONGEST_STEP / max(float(np.linalg.norm(step)), 1e-300))
    return None


def wrap_angles(arm: Arm, displacement: Array) -> Array:
    """Return a displacement of the joints with angles modulo a turn, in [−π, π].

    Args:
        arm: The arm.
        displacement: Differences of joint positions, shape (..., nv), rad; those of prismatic joints stay as they are.
    """
    turns = np.where(arm.prismatic, 0.0, np.round(displacement / (2.0 * np.pi)))
    result: Array = displacement - 2.0 * np.pi * turns
    return result


def beyond_limits(arm: Arm, positions: Array) -> Array:
    """Return how far each joint is beyond its limits, shape (..., nv), rad; below zero inside, −∞ without limits.

    Angles count modulo a turn: a joint that turns by more than a turn is never beyond its limits.

    Args:
        arm: The arm.
        positions: Joint positions, shape (..., nv), rad.
    """
    lower, upper = arm.position_limits
    middle, half = _range(arm)
    angles = np.abs(wrap_angles(arm, positions - middle)) - half
    return np.where(arm.prismatic, np.maximum(lower - positions, positions - upper), angles)


def wrap_into_limits(arm: Arm, positions: Array) -> Array:
    """Return the same postures with every angle turned to where it is nearest to the middle of its range.

    Args:
        arm: The arm.
        positions: Joint positions, shape (..., nv), rad.
    """
    middle, _ = _range(arm)
    result: Array = middle + wrap_angles(arm, positions - middle)
    return result


def sampling_range(arm: Arm, box: tuple[Array, Array] | None = None) -> tuple[Array, Array]:
    """Return the range in which random joint positions are drawn, shapes (nv,), rad.

    The box; a turn for an angle without, the arm's reach (or 1 m) to both sides for a prismatic joint without.

    Args:
        arm: The arm.
        box: Smallest and largest joint positions, shapes (nv,), rad, infinite for none; None for the joint limits.
    """
    lower, upper = arm.position_limits if box is None else box
    free = arm.reach if np.isfinite(arm.reach) else 1.0
    widest = np.where(arm.prismatic, free, np.pi)
    return np.where(np.isfinite(lower), lower, -widest), np.where(np.isfinite(upper), upper, widest)


def _range(arm: Arm) -> tuple[Array, Array]:
    """Return the middle and half the width of each joint's range; 0 and infinity where nothing limits it."""
    lower, upper = arm.position_limits
    limited = np.isfinite(lower) & np.isfinite(upper)
    middle = np.where(limited, (np.where(limited, lower, 0.0) + np.where(limited, upper, 0.0)) / 2.0, 0.0)
    half = np.where(limited, np.where(limited, upper, 0.0) - middle, np.inf)
    return middle, np.where(arm.prismatic | (half < np.pi), half, np.inf)
