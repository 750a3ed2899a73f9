"""Figures of merit of a run."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..redundancy import Array
from ..simulation import Run


class ZeroCrossing(NamedTuple):
    """One minor changing sign.

    Attributes:
        minor: Which one, counted from 1 in the order of `redundancy.minor_columns`.
        time: When, s; interpolated linearly between the samples on both sides.
    """

    minor: int
    time: float


def minor_zero_crossings(run: Run) -> list[ZeroCrossing]:
    """Return every sign change of a minor, in order of time, but for minors that have no sign at the start."""
    crossings = []
    for index in signed_at_start(run):
        values, signs = run.minors[:, index], run.aspect_signatures[:, index]
        sampled = np.flatnonzero(signs)
        changes = np.flatnonzero(np.diff(signs[sampled]))
        before, after = sampled[changes], sampled[changes + 1]
        share = values[before] / (values[before] - values[after])
        times = run.t[before] + share * (run.t[after] - run.t[before])
        crossings += [ZeroCrossing(int(index) + 1, float(time)) for time in times]
    return sorted(crossings, key=lambda crossing: crossing.time)


def aspect_preserved(run: Run) -> bool:
    """Tell whether every minor that has a sign at the start keeps it; see `Arm.minors_on_border`."""
    signs = run.aspect_signatures[:, signed_at_start(run)]
    return bool(np.all(signs == signs[:1]))


def signed_at_start(run: Run) -> NDArray[np.intp]:
    """Return the indices of the minors that are off the border at the start, so that they have a sign, shape (any,)."""
    return np.setdiff1d(np.arange(run.minors.shape[1]), run.arm.minors_on_border(run.q[0]))


def peak_torque(run: Run) -> tuple[Array, Array]:
    """Return the largest |τ| of each joint, shape (nv,), N m, and when it occurs, shape (nv,), s."""
    magnitude = np.abs(run.tau)
    return magnitude.max(axis=0), run.t[magnitude.argmax(axis=0)]


def exploded(status: str, peak_ratio: float, threshold: float) -> bool:
    """Tell whether a torque exploded: the run ended early, or its peak is beyond a threshold.

    Args:
        status: How the run ended.
        peak_ratio: Its peak torque over that of a reference on the same motion.
        threshold: The largest ratio of a calm run.
    """
    return status != "finished" or peak_ratio > threshold


def total_variation(values: Array) -> Array:
    """Return Σ|x_{i+1} − x_i| of each column, shape (n,), in the unit of `values`, shape (k, n)."""
    variation: Array = np.abs(np.diff(values, axis=0)).sum(axis=0)
    return variation


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
        "peak_torque_time": [_seconds(time) for time in times],
        "aspect_preserved": aspect_preserved(run),
        "minor_zero_crossings": [{"minor": minor, "time": _seconds(time)} for minor, time in minor_zero_crossings(run)],
        "maciejewski_product_max": float(product.max()),
        "maciejewski_product_max_time": _seconds(run.t[product.argmax()]),
        "max_tracking_error": float(run.tracking_error.max()),
        "max_orientation_error": float(run.orientation_error.max()),
        "minors": run.minors.shape[1],
        "minors_on_border_at_start": (run.arm.minors_on_border(run.q[0]) + 1).tolist(),
        "minor_measure_min": float(run.minor_measure.min()),
        "border_distance_min": float(run.border_distance.min()),
        "border_distance_min_time": _seconds(run.t[run.border_distance.argmin()]),
        "time_to_border_min": soonest if math.isfinite(soonest) else None,
        "torque_total_variation": total_variation(run.tau).tolist(),
        "torque_squared_integral": float((run.tau[:-1] ** 2).sum() * run.info.dt),
    }
    if run.info.switches:
        summary["null_space_term_on"] = [
            [_seconds(start), _seconds(end)] for start, end in intervals(run.t, run.null_space_term_on)
        ]
    return summary


def _seconds(time: float) -> float:
    """Round the noise of i·dt away."""
    return round(float(time), 9)
