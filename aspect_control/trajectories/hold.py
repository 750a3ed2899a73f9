"""Standing still."""

from __future__ import annotations

import numpy as np

from ..arm.tasks import Task
from ..checks import positive
from ..redundancy import Array
from .path import PathTrajectory
from .profiles import Progress


class Hold(PathTrajectory):
    """The task stands still where it starts."""

    name = "hold"

    def __init__(self, duration: float) -> None:
        """Set the time.

        Args:
            duration: Time that the task stands still, s.

        Raises:
            ParameterError: If it is not above zero.
        """
        self.duration = positive("duration", duration, "s")

    @property
    def task_dim(self) -> None:
        """None: any task can stand still."""
        return None

    def path(self, progress: Progress, task: Task) -> Array:
        """Return the start; see `PathTrajectory.path`."""
        return np.zeros((3, task.dim))

    def __repr__(self) -> str:
        """Show the trajectory as it was constructed."""
        return f"Hold(duration={self.duration})"
