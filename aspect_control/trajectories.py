"""Where the task coordinates are to be, and how fast, at any time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

from numpy.typing import ArrayLike

from .checks import finite_vector, positive
from .exceptions import ShapeError, UnknownNameError
from .redundancy import Array

_SAME_INSTANT = 1e-12
"""Times closer than this part of the duration are the same instant: i·dt is rarely exact."""


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """What the task is to do at one instant.

    Attributes:
        x: Desired task coordinates x_d, shape (m,), m.
        dx: Desired velocity ẋ_d, shape (m,), m/s.
        ddx: Desired acceleration ẍ_d, shape (m,), m/s².

    Raises:
        ShapeError: If the three are not vectors of one length.
        NonFiniteError: If one holds NaN or infinity.
    """

    x: Array
    dx: Array
    ddx: Array

    def __post_init__(self) -> None:
        """Check the three vectors and turn them into arrays."""
        for name in ("x", "dx", "ddx"):
            object.__setattr__(self, name, finite_vector(f"target.{name}", getattr(self, name)))
        if not self.x.shape == self.dx.shape == self.ddx.shape:
            raise ShapeError(
                "target.x, target.dx and target.ddx must have one shape, "
                f"got {self.x.shape}, {self.dx.shape} and {self.ddx.shape}"
            )


class Trajectory(ABC):
    """A motion of the task coordinates that starts where the arm is.

    Attributes:
        duration: Length of the motion, s.
    """

    duration: float

    @property
    @abstractmethod
    def task_dim(self) -> int:
        """Number of task coordinates m."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times inside the motion at which the acceleration jumps, s."""
        return ()

    @abstractmethod
    def target(self, t: float, start: Array) -> Target:
        """Return the target at a time.

        Args:
            t: Time since the start of the motion, s. Before 0 and after `duration` the target stands still.
            start: Task coordinates at t = 0, shape (m,), m.
        """


class StraightLine(Trajectory):
    """A straight line in task space, from rest to rest.

    With the profile `"bang-bang"` the acceleration is constant over the first half and its opposite over the second:
    the paper's trajectory A is `StraightLine([1.5, 1.0], duration=2.0)`, with ±[1.5, 1.0] m/s².
    At the instant of a jump the acceleration is the one that follows; at the very end it is the one that was.
    """

    def __init__(self, displacement: ArrayLike, duration: float, profile: str = "bang-bang") -> None:
        """Set the line.

        Args:
            displacement: From the start to the end, shape (m,), m.
            duration: Time that the motion takes, s.
            profile: How the distance grows with time; `"bang-bang"`.

        Raises:
            ShapeError: If `displacement` is no vector.
            NonFiniteError: If it is not finite.
            ParameterError: If `duration` is not above zero.
            UnknownNameError: If there is no such profile.
        """
        self.displacement = finite_vector("displacement", displacement)
        self.duration = positive("duration", duration, "s")
        if profile not in PROFILES:
            raise UnknownNameError(profile, PROFILES, kind="profile")
        self.profile = profile
        self._profile = PROFILES[profile]

    @property
    def task_dim(self) -> int:
        """Number of task coordinates m."""
        return len(self.displacement)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times inside the motion at which the acceleration jumps, s."""
        return (self.duration / 2.0,)

    def target(self, t: float, start: Array) -> Target:
        """Return the target at a time; see `Trajectory.target`."""
        s, ds, dds = self._profile(t / self.duration)
        return Target(
            start + s * self.displacement,
            ds / self.duration * self.displacement,
            dds / self.duration**2 * self.displacement,
        )

    def __repr__(self) -> str:
        """Show the line as it was constructed."""
        return f"StraightLine({self.displacement.tolist()}, duration={self.duration}, profile={self.profile!r})"


def _bang_bang(u: float) -> tuple[float, float, float]:
    if u < 0.0:
        return 0.0, 0.0, 0.0
    if u < 0.5 - _SAME_INSTANT:
        return 2.0 * u**2, 4.0 * u, 4.0
    if u <= 1.0 + _SAME_INSTANT:
        return 1.0 - 2.0 * (1.0 - u) ** 2, 4.0 * (1.0 - u), -4.0
    return 1.0, 0.0, 0.0


PROFILES: dict[str, Callable[[float], tuple[float, float, float]]] = {"bang-bang": _bang_bang}
"""Distance, speed and acceleration along a motion of unit length and duration, by name."""
