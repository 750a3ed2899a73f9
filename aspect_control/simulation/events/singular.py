"""A configuration too near a singularity."""

from __future__ import annotations

from ...checks import positive
from ...redundancy import manipulability
from .event import Event, Sample


class Singular(Event):
    """The manipulability of Eq. (25) has fallen below a threshold."""

    name = "singular"
    status = "singular"

    def __init__(self, manipulability: float) -> None:
        """Set the threshold.

        Args:
            manipulability: Smallest w, in the unit of the minors.

        Raises:
            ParameterError: If it is not above zero.
        """
        self.manipulability = positive("manipulability", manipulability)

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None."""
        w = float(manipulability(sample.arm.jacobian(sample.q)))
        return None if w >= self.manipulability else f"manipulability {w:.3g}, limit {self.manipulability:g}"
