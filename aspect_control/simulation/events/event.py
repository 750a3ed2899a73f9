"""What every event is: a condition that ends a run, and says how it ended and why."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

from ...arm import Arm
from ...arm.tasks import TaskValue
from ...redundancy import Array
from ...trajectories import Target, Trajectory


class Sample(NamedTuple):
    """One sample of a run in the making; its arrays are read-only.

    Attributes:
        arm: The arm.
        t: Time, s.
        q: Joint configuration, shape (nq,), rad.
        v: Joint velocity, shape (nv,), rad/s.
        tau: Joint torque that the law asks for, before any saturation, shape (nv,), N m.
        target: What the task is to do.
    """

    arm: Arm
    t: float
    q: Array
    v: Array
    tau: Array
    target: Target

    @property
    def x(self) -> TaskValue:
        """Task value at q, computed when asked for: shape (m,), m, or a `pin.SE3` for a task with rotations."""
        return self.arm.task_position(self.q)


class Event(ABC):
    """A condition that ends a run.

    Attributes:
        name: Name in the registry.
        status: How a run ended that it has ended.
    """

    name: ClassVar[str]
    status: str

    def require_fits(self, arm: Arm) -> None:  # noqa: B027
        """Raise an error of ours if the event does not fit the arm; called before the run starts."""

    def begin(self, arm: Arm, trajectory: Trajectory, q0: Array) -> Event:
        """Return the event for one motion, before it starts: this one, or one that knows the motion.

        What is found out about the motion belongs to what is returned: the event itself may serve many runs.

        Args:
            arm: The arm.
            trajectory: What the task is to do.
            q0: Joint configuration at the start, shape (nq,), rad.
        """
        return self

    @abstractmethod
    def check(self, sample: Sample) -> str | None:
        """Return why the run ends at this sample, without the time, or None if it goes on."""
