"""A task frame too far from its target."""

from __future__ import annotations

from math import dist

from ...checks import positive
from ...redundancy import manipulability
from .event import Event, Sample


class TrackingLost(Event):
    """The task frame is too far from its target."""

    name = "tracking-lost"
    status = "tracking lost"

    def __init__(self, distance: float = 0.5) -> None:
        """Set the limit.

        Args:
            distance: Largest distance between the desired and the actual position, m.

        Raises:
            ParameterError: If it is not above zero.
        """
        self.distance = positive("distance", distance, "m")

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None."""
        arm, x_d, x = sample.arm, sample.target.x, sample.x
        if arm.coordinates.has_rotation:
            axes = arm.coordinates.position_axes
            x_d, x = x_d.translation[axes], x.translation[axes]
        distance = dist(x_d.tolist(), x.tolist())
        if distance <= self.distance:
            return None
        return (
            f"{arm.frame!r} is {distance:.3g} m from its target, limit {self.distance:g} m; "
            f"the manipulability there is {float(manipulability(arm.jacobian(sample.q))):.3g}"
        )
