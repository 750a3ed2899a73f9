"""What is computed from one run."""

from ..simulation.metrics import (
    ZeroCrossing,
    aspect_preserved,
    minor_zero_crossings,
    peak_torque,
    total_variation,
)
from .border_ahead import BorderAhead, border_ahead, preview, warn_of_border_ahead
from .limit import ContinuousLimit, continuous_limit
from .summary import exploded, intervals, summarize

__all__ = [
    "BorderAhead",
    "ContinuousLimit",
    "ZeroCrossing",
    "aspect_preserved",
    "border_ahead",
    "continuous_limit",
    "exploded",
    "intervals",
    "minor_zero_crossings",
    "peak_torque",
    "preview",
    "summarize",
    "total_variation",
    "warn_of_border_ahead",
]
