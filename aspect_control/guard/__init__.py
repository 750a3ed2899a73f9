"""What stands between a torque law and a robot: limits, plausibility, divergence, a soft stop."""

from .guard import Guard
from .status import GuardStatus

__all__ = ["Guard", "GuardStatus"]
