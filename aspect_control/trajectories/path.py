"""Trajectories that are a path and a profile: where to go, and how far along it to be at any time."""

from __future__ import annotations

from abc import abstractmethod

import pinocchio as pin

from ..checks import finite_number, finite_vector
from ..exceptions import ShapeError
from ..redundancy import Array
from ..tasks import Task, TaskValue, task_of_value
from .profiles import UNIFORM, Profile
from .target import Target
from .trajectory import Trajectory


class PathTrajectory(Trajectory):
    """A path from the start, followed as a profile says.

    A subclass sets `duration`, gives the path and, unless it is followed at constant speed, passes on a profile.
    """

    _profile: Profile = UNIFORM

    @abstractmethod
    def path(self, s: float, task: Task) -> tuple[Array, Array, Array]:
        """Return the path, and its velocity and acceleration with respect to s.

        Args:
            s: How much of the path has been followed, from 0 to 1.
            task: The task; it has `task_dim` coordinates.

        Returns:
            Three arrays of shape (m,): the displacement from the start, m and rad, whose rotation entries are a
            rotation vector in the world frame; the velocity, whose rotation entries are the angular velocity in the
            world frame (which is the derivative of the rotation vector only if the axis stays the same); and the
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
        start = task.checked("start", start)
        if self.task_dim not in (None, task.dim):
            raise ShapeError(
                f"the trajectory has {self.task_dim} task coordinates, the task {task.axes} has {task.dim}"
            )
        s, ds, dds = self._profile(finite_number("t", t) / self.duration)
        ds, dds = ds / self.duration, dds / self.duration / self.duration
        displacement, velocity, acceleration = self.path(s, task)
        return Target(task.displaced(start, displacement), ds * velocity, ds**2 * acceleration + dds * velocity)
