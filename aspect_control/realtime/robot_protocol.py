"""What a robot is to the loop: something that can be read and written."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from numpy.typing import ArrayLike

from ..redundancy import Array


@runtime_checkable
class Robot(Protocol):
    """A robot, or what stands for one: a driver, a simulation, a test bench.

    It may have two things more:

    - A clock of its own. Such a robot is a `ClockedRobot`.
    - `stop()`, called once after the last command of a motion, for robots that want to be told that no more will come.
    """

    def read(self) -> tuple[ArrayLike, ArrayLike]:
        """Return the joint configuration q, shape (nq,), rad, and the joint velocity v, shape (nv,), rad/s.

        Raises:
            Exception: Whatever says that the robot does not answer; the loop ends as `"failed"`.
        """

    def write(self, tau: Array, /) -> None:
        """Send joint torques, shape (nv,), N m, which the robot holds until the next; the array is not changed."""


@runtime_checkable
class ClockedRobot(Robot, Protocol):
    """A robot with a clock of its own: `read` waits for its next sample and returns the newest there is."""

    @property
    def time(self) -> float:
        """Time of the sample that `read` returned last, on the robot's clock, s."""
