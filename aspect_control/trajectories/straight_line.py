"""The straight line in task space."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm.tasks import Task
from ..checks import finite_vector, positive
from ..redundancy import Array
from .path import PathTrajectory
from .profiles import Progress, find_profile


class StraightLine(PathTrajectory):
    """A straight line in task space, from rest to rest; orientations turn about one axis of the world frame.

    With the profile `"bang-bang"` the acceleration is constant over the first half and its opposite over the second:
    the paper's trajectory A is `StraightLine([1.5, 1.0], duration=2.0)`, with ±[1.5, 1.0] m/s².
    """

    name = "straight-line"

    def __init__(self, displacement: ArrayLike, duration: float, profile: str = "bang-bang") -> None:
        """Set the line.

        Args:
            displacement: From the start to the end, one entry a task coordinate, shape (m,), m and rad; the rotation
                entries are a rotation vector in the world frame, of any length. Kept as a read-only copy.
            duration: Time that the motion takes, s.
            profile: How the distance grows with time; a name of `PROFILES`.

        Raises:
            ShapeError: If `displacement` is no vector.
            NonFiniteError: If it is not finite.
            ParameterError: If `duration` is not above zero.
            UnknownNameError: If there is no such profile.
        """
        self.displacement = finite_vector("displacement", displacement)
        self.duration = positive("duration", duration, "s")
        self._profile = find_profile(profile)
        self.profile = profile

    @property
    def task_dim(self) -> int:
        """Number of task coordinates m."""
        return len(self.displacement)

    def path(self, progress: Progress, task: Task) -> Array:
        """Return the line; see `PathTrajectory.path`."""
        rows: Array = np.array(progress)[:, np.newaxis] * self.displacement
        return rows

    def __repr__(self) -> str:
        """Show the line as it was constructed."""
        return f"StraightLine({self.displacement.tolist()}, duration={self.duration}, profile={self.profile!r})"
