"""A joint outside its range."""

from __future__ import annotations

from ...exceptions import ParameterError
from .event import Event, Sample


class JointLimit(Event):
    """A joint has left its range in the robot's description."""

    name = "joint-limit"
    status = "joint limit"

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None."""
        try:
            sample.arm.require_within_limits(sample.q)
        except ParameterError as error:
            return str(error)
        return None
