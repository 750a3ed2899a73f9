"""What stands between a law and a robot: a guard, whether a path can be reached, and going over to another law."""

from .blend import Blend, BlendMemory
from .guard import GUARD_FAILED, Guard
from .plausibility import AS_TOLD
from .reach import Reach, check_reach, out_of_reach
from .status import GuardStatus

__all__ = [
    "AS_TOLD",
    "GUARD_FAILED",
    "Blend",
    "BlendMemory",
    "Guard",
    "GuardStatus",
    "Reach",
    "check_reach",
    "out_of_reach",
]
