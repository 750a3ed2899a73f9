"""Trajectories that are a path and a profile: where to go, and how far along it to be at any time."""

from __future__ import annotations

from abc import abstractmethod
from math import hypot

import numpy as np
import pinocchio as pin

from ..arm.tasks import Task, TaskValue, task_of_value
from ..checks import LARGEST, finite_number, finite_vector, require_finite
from ..exceptions import ShapeError
from ..redundancy import Array
from .profiles import UNIFORM, Profile, Progress
from .target import Target, target_of_rows
from .trajectory import Trajectory

_FLOAT = np.dtype(np.float64)


class PathTrajectory(Trajectory):
    """A path from the start, followed as a profile says.

    A subclass sets `duration`, gives the path and, unless it is followed at constant speed, passes on a profile.
    """

    _profile: Profile = UNIFORM

    @abstractmethod
    def path(self, progress: Progress, task: Task) -> Array:
        """Return where the path is, and its velocity and acceleration.

        Args:
            progress: How much of the path has been followed, s from 0 to 1, and its derivatives ṡ, 1/s, and s̈, 1/s².
            task: The task; it has `task_dim` coordinates.

        Returns:
            A new array of three rows, shape (3, m): the displacement from the start, m and rad, whose rotation entries
            are a rotation vector in the world frame; the velocity, whose rotation entries are the angular velocity in
            the world frame (which is the derivative of the rotation vector only if the axis stays the same); and the
            derivative of the velocity.

        Raises:
            ParameterError: If the task lacks a coordinate that the path needs.
        """

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times inside the motion at which the acceleration jumps, s, increasing."""
        return tuple(self.duration * u for u in self._profile.breakpoints)

    def target(self, t: float, start: TaskValue, task: Task | None = None) -> Target:
        """Return the target at a time; see `Trajectory.target`."""
        if task is None:
            task = task_of_value(start if isinstance(start, pin.SE3) else finite_vector("start", start))
        dim, has_rotation, duration = task.dim, task.has_rotation, self.duration
        # An array of the right form is checked with the target, of which it is a part.
        if has_rotation or type(start) is not np.ndarray or start.dtype is not _FLOAT or start.shape != (dim,):
            start = task.checked("start", start)
        if self.task_dim not in (None, dim):
            raise ShapeError(f"the trajectory has {self.task_dim} task coordinates, the task {task.axes} has {dim}")
        s, ds, dds = self._profile(finite_number("t", t) / duration)
        rows = self.path((s, ds / duration, dds / duration / duration), task)
        pose = None
        if has_rotation:
            pose = task.displaced(start, rows[0])
        else:
            x = rows[0]
            x += start
        if not hypot(*rows.ravel().tolist()) <= LARGEST:
            if not has_rotation:
                require_finite("start", start)
            require_finite(f"the target at t = {t:g} s", rows)
        return target_of_rows(rows, pose)
