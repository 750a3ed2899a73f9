"""What stands between a torque law and a robot: limits, plausibility, divergence, a soft stop."""

from .guard import GUARD_FAILED, Guard
from .plausibility import AS_TOLD
from .status import GuardStatus

__all__ = ["AS_TOLD", "GUARD_FAILED", "Guard", "GuardStatus"]
