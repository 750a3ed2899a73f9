"""Joints faster than any arm."""

from __future__ import annotations

from ...checks import positive
from .event import Event, Moment


class Diverged(Event):
    """The joints have become faster than any arm."""

    name = "diverged"
    status = "diverged"

    def __init__(self, speed: float = 1e3) -> None:
        """Set the limit.

        Args:
            speed: Largest joint speed, rad/s (m/s for prismatic joints).

        Raises:
            ParameterError: If it is not above zero.
        """
        self.speed = positive("speed", speed, "rad/s")

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        speeds = list(map(abs, moment.v.tolist()))
        speed = max(speeds)
        if speed <= self.speed:
            return None
        joint = speeds.index(speed)
        return f"joint {moment.arm.joint_names[joint]!r} at {speed:.3g} rad/s, limit {self.speed:g} rad/s"
