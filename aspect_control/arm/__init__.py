"""The arm: a chain of joints that moves a frame, the task coordinates of that frame, and its state."""

from __future__ import annotations

from .arm import Arm
from .arm_state import ArmState
from .task_minors import BORDER_TOLERANCE

__all__ = ["BORDER_TOLERANCE", "Arm", "ArmState"]
