"""The aspects of an arm: self-motions, the best posture to start from, maps of configurations."""

from .sampling import SelfMotionSample, sample_self_motion
from .self_motion import AspectInterval, BorderCrossing, LimitCrossing, SelfMotion, self_motion
from .start import Start, choose_start

__all__ = [
    "AspectInterval",
    "BorderCrossing",
    "LimitCrossing",
    "SelfMotion",
    "SelfMotionSample",
    "Start",
    "choose_start",
    "sample_self_motion",
    "self_motion",
]
