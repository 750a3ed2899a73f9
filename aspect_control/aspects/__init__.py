"""The aspects of an arm: self-motions, the best posture to start from, maps of configurations."""

from .atlas import Atlas, compute_atlas, estimated_time
from .crossings import AspectInterval, BorderCrossing, LimitCrossing
from .sampling import SelfMotionSample, sample_self_motion
from .self_motion import SelfMotion, self_motion
from .slices import Axis, JointSlice, SelfMotionSlice, Slice
from .stability_map import Growth, growth, stability
from .start import Start, choose_start

__all__ = [
    "AspectInterval",
    "Atlas",
    "Axis",
    "BorderCrossing",
    "Growth",
    "JointSlice",
    "LimitCrossing",
    "SelfMotion",
    "SelfMotionSample",
    "SelfMotionSlice",
    "Slice",
    "Start",
    "choose_start",
    "compute_atlas",
    "estimated_time",
    "growth",
    "sample_self_motion",
    "self_motion",
    "stability",
]
