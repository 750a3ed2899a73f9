"""What is computed from runs."""

from .limit import ContinuousLimit, continuous_limit
from .metrics import (
    ZeroCrossing,
    aspect_preserved,
    intervals,
    minor_zero_crossings,
    peak_torque,
    summarize,
    total_variation,
)

__all__ = [
    "ContinuousLimit",
    "ZeroCrossing",
    "aspect_preserved",
    "continuous_limit",
    "intervals",
    "minor_zero_crossings",
    "peak_torque",
    "summarize",
    "total_variation",
]
