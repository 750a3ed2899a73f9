"""What a loop is to do: follow a trajectory, or the newest of the targets that arrive."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.tasks import TaskValue
from ..exceptions import ParameterError, ShapeError, shown
from ..trajectories import Target, Trajectory
from .streamed_target import StreamedTarget


class Motion(ABC):
    """Targets for a loop."""

    @abstractmethod
    def start(self, x: TaskValue) -> None:
        """Begin at t = 0 where the task frame is; may be called more than once before the first target."""

    @abstractmethod
    def target(self, t: float) -> Target | None:
        """Return the target at a time, s, or None if the motion is over; the times increase."""

    @abstractmethod
    def __repr__(self) -> str:
        """Show what the run records as its trajectory."""


class Following(Motion):
    """A trajectory."""

    def __init__(self, arm: Arm, trajectory: Trajectory) -> None:
        """Set the trajectory, for the task of an arm.

        Raises:
            ParameterError: If it is none.
            ShapeError: If it has another number of task coordinates than the arm.
        """
        if not isinstance(trajectory, Trajectory):
            raise ParameterError(f"trajectory must be a Trajectory, got {shown(trajectory)}")
        if trajectory.task_dim not in (None, arm.task_dim):
            raise ShapeError(
                f"the trajectory has {trajectory.task_dim} task coordinates, the arm's task {arm.task} {arm.task_dim}"
            )
        self._trajectory, self._task = trajectory, arm.coordinates
        self._end = trajectory.duration * (1.0 + 1e-12)

    def start(self, x: TaskValue) -> None:
        """Start where the task frame is, and look at the first target, which says whether there is one."""
        self._start = x
        self._trajectory.target(0.0, x, self._task)

    def target(self, t: float) -> Target | None:
        """Return the target of the trajectory."""
        return self._trajectory.target(t, self._start, self._task) if t <= self._end else None

    def __repr__(self) -> str:
        """Show the trajectory."""
        return repr(self._trajectory)


class Streaming(Motion):
    """Targets from outside, made smooth; over when no more come and the last is reached."""

    def __init__(self, arm: Arm, targets: Iterable[TaskValue | None], **limits: ArrayLike) -> None:
        """Set where the targets come from, and the limits of `StreamedTarget`.

        Raises:
            ParameterError: If they come from nowhere, or a limit is not above zero.
            ShapeError: If a limit has the wrong shape.
        """
        if not isinstance(targets, Iterable):
            raise ParameterError(f"targets must be an iterable of task values and None, got {shown(targets)}")
        self._task, self._limits, self._targets = arm.coordinates, limits, iter(targets)
        self._ended = False

    def start(self, x: TaskValue) -> None:
        """Stand still where the task frame is."""
        self._smooth = StreamedTarget(self._task, x, **self._limits)

    def target(self, t: float) -> Target | None:
        """Ask for a new target, and return the smooth one."""
        if not self._ended:
            newest: Any = next(self._targets, self)
            if newest is self:
                self._ended = True
            elif newest is not None:
                self._smooth.go_to(t, newest)
        return None if self._ended and self._smooth.arrived(t) else self._smooth.target(t)

    def __repr__(self) -> str:
        """Show the limits."""
        return f"stream({', '.join(f'{name}={value!r}' for name, value in self._limits.items())})"
