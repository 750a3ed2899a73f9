"""What every trajectory offers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from ..arm.tasks import Task, TaskValue
from .target import Target


class Trajectory(ABC):
    """A motion of the task coordinates that starts where the arm is.

    Attributes:
        name: Name in the registry.
        duration: Length of the motion, s.
    """

    name: ClassVar[str]
    duration: float

    @property
    @abstractmethod
    def task_dim(self) -> int | None:
        """Number of task coordinates m; None for a motion that suits any task."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times inside the motion at which the acceleration jumps, s, increasing."""
        return ()

    @abstractmethod
    def target(self, t: float, start: TaskValue, task: Task | None = None) -> Target:
        """Return the target at a time.

        Before 0 and after `duration` the target stands still at the start and the end. At a jump of the acceleration,
        the acceleration is the one that follows; at the very end it is the one that was.

        Args:
            t: Time since the start of the motion, s.
            start: Task value at t = 0: an array of shape (m,), m, or a `pin.SE3` for a task with rotations.
            task: The task that the value is of; None for the one that the value suggests.

        Raises:
            ShapeError: If the start is no value of the task, or the motion has another number of coordinates.
            NonFiniteError: If the start is not finite, or the target would not be.
            ParameterError: If `t` is not a finite number, or the task lacks a coordinate that the motion needs.
        """
