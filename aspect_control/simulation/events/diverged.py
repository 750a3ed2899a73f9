"""Joints faster than any arm."""

from __future__ import annotations

from ...checks import positive
from .event import Event, Sample


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

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None."""
        speeds = list(map(abs, sample.v.tolist()))
        speed = max(speeds)
        if speed <= self.speed:
            return None
        joint = speeds.index(speed)
        return f"joint {sample.arm.joint_names[joint]!r} at {speed:.3g} rad/s, limit {self.speed:g} rad/s"
