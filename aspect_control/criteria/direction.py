"""The direction in the task that a criterion is about."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import finite_vector
from ..exceptions import ParameterError
from ..redundancy import Array


def task_direction(arm: Arm, direction: ArrayLike) -> tuple[Array, Array]:
    """Return a direction in task coordinates as it was given, and with length 1, both of shape (m,).

    Args:
        arm: The arm.
        direction: Components along the task coordinates, shape (m,), of any length but zero.

    Raises:
        ShapeError: If there is not one component a task coordinate.
        NonFiniteError: If one is not finite.
        ParameterError: If all are zero.
    """
    given = finite_vector("direction", direction, arm.task_dim)
    longest = np.abs(given).max()
    if longest == 0.0:
        raise ParameterError(f"direction must not be zero, got {given.tolist()} for the task {arm.task}")
    # Divided by its longest component first, so that squares neither overflow nor vanish.
    scaled = given / longest
    return given, scaled / np.linalg.norm(scaled)
