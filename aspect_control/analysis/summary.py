"""Figures of merit of a run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..redundancy import Array
from ..simulation import Run
from ..simulation.metrics import (
    aspect_preserved,
    minor_zero_crossings,
    peak_torque,
    seconds,
    torque_squared_integral,
    total_variation,
)


def exploded(status: str, peak_ratio: float, threshold: float) -> bool:
    """Tell whether a torque exploded: the run ended early, or its peak is beyond a threshold.

    Args:
        status: How the run ended.
        peak_ratio: Its peak torque over that of a reference on the same motion.
        threshold: The largest ratio of a calm run.
    """
    return status != "finished" or peak_ratio > threshold


def intervals(t: Array, on: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Return where a sampled condition holds, as [start, end) in seconds.

    Args:
        t: Times, shape (k,), s.
        on: The condition at those times, shape (k,); it holds until the next sample.

    Returns:
        Start and end of each stretch; one that is still on at the last sample ends there.
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], on, [False])).astype(np.int8)))
    last = len(t) - 1
    return [(float(t[start]), float(t[min(end, last)])) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def summarize(run: Run) -> dict[str, Any]:
    """Return the run's figures of merit as plain numbers, strings and lists, for JSON.

    Returns:
        `status` and `message`; `peak_torque` (N m) and `peak_torque_time` (s), one a joint; `aspect_preserved`;
        `minor_zero_crossings`, a list of `{"minor": counted from 1, "time": s}`; `maciejewski_product_max`
        (rad²/s³) and `maciejewski_product_max_time` (s); `max_tracking_error` (m); `max_orientation_error` (rad);
        `minors`, how many there are; `minors_on_border_at_start`, counted from 1; `minor_measure_min` (in the unit of
        the minors); `border_distance_min` (dimensionless) and `border_distance_min_time` (s), see
        `Run.border_distance`; `time_to_border_min` (s), None if the arm moves towards no border;
        `torque_total_variation` (N m, one a joint); `torque_squared_integral` (N² m² s); and, for laws that switch,
        `null_space_term_on`, a list of [start, end] in s.
    """
    torques, times = peak_torque(run)
    product = run.maciejewski_product
    soonest = float(run.time_to_border.min())
    summary = {
        "status": run.status,
        "message": run.message,
        "peak_torque": torques.tolist(),
        "peak_torque_time": [seconds(time) for time in times],
        "aspect_preserved": aspect_preserved(run),
        "minor_zero_crossings": [{"minor": minor, "time": seconds(time)} for minor, time in minor_zero_crossings(run)],
        "maciejewski_product_max": float(product.max()),
        "maciejewski_product_max_time": seconds(run.t[product.argmax()]),
        "max_tracking_error": float(run.tracking_error.max()),
        "max_orientation_error": float(run.orientation_error.max()),
        "minors": run.minors.shape[1],
        "minors_on_border_at_start": (run.arm.minors_on_border(run.q[0]) + 1).tolist(),
        "minor_measure_min": float(run.minor_measure.min()),
        "border_distance_min": float(run.border_distance.min()),
        "border_distance_min_time": seconds(run.t[run.border_distance.argmin()]),
        "time_to_border_min": soonest if math.isfinite(soonest) else None,
        "torque_total_variation": total_variation(run.tau).tolist(),
        "torque_squared_integral": torque_squared_integral(run),
    }
    if run.info.switches:
        summary["null_space_term_on"] = [
            [seconds(start), seconds(end)] for start, end in intervals(run.t, run.null_space_term_on)
        ]
    return summary
