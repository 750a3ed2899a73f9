"""The arm: a chain of joints that moves a frame, the task coordinates of that frame, and its state."""

from __future__ import annotations

from .arm import BORDER_TOLERANCE, Arm
from .arm_state import ArmState

__all__ = ["BORDER_TOLERANCE", "Arm", "ArmState"]
