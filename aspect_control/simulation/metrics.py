"""Figures of merit of one run, as single numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..exceptions import ParameterError
from ..redundancy import Array

if TYPE_CHECKING:
    from .run import Run

Metric: TypeAlias = float | int | bool | str | None
"""A figure of merit: a finite number, a word, or None where there is none."""

METRICS: dict[str, type] = {
    "end": float,
    "samples": int,
    "peak_torque": float,
    "peak_torque_time": float,
    "peak_torque_joint": str,
    "peak_torque_inside": float,
    "torque_squared_integral": float,
    "torque_total_variation": float,
    "peak_speed": float,
    "self_motion_max": float,
    "self_motion_energy_max": float,
    "aspect_preserved": bool,
    "sign_changes": int,
    "left_at": float,
    "margin": float,
    "minors_on_border_at_start": int,
    "minor_measure_min": float,
    "manipulability_min": float,
    "border_distance_min": float,
    "border_distance_min_time": float,
    "time_to_border_min": float,
    "maciejewski_product_max": float,
    "maciejewski_product_max_time": float,
    "tracking_error_max": float,
    "tracking_error_rms": float,
    "tracking_error_end": float,
    "orientation_error_max": float,
}
"""What `Run.metrics` returns, in its order, and the type of each that is not None."""


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
    signed = signed_at_start(run)
    changing = signed[np.any(run.aspect_signatures[:, signed] != run.aspect_signatures[:1, signed], axis=0)]
    for index in changing:
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


def total_variation(values: Array) -> Array:
    """Return Σ|x_{i+1} − x_i| of each column, shape (n,), in the unit of `values`, shape (k, n)."""
    variation: Array = np.abs(np.diff(values, axis=0)).sum(axis=0)
    return variation


def torque_squared_integral(run: Run) -> float:
    """Return ∫‖τ‖²dt with the torque of a sample held until the next, N² m² s."""
    return float((run.tau[:-1] ** 2).sum() * run.info.dt)


def metrics_of(run: Run) -> dict[str, Metric]:
    """Return the figures of merit of a run that `Run.metrics` lists, in its order.

    Raises:
        ParameterError: If the run has no samples.
    """
    if len(run.t) == 0:
        raise ParameterError("a run without samples has no metrics")
    signed, crossings = signed_at_start(run), minor_zero_crossings(run)
    left_at = crossings[0].time if crossings else None
    with np.errstate(over="ignore", invalid="ignore"):
        aspect = {
            "aspect_preserved": aspect_preserved(run),
            "sign_changes": len(crossings),
            "left_at": left_at,
            "margin": _margin(run, signed),
            "minors_on_border_at_start": run.minors.shape[1] - len(signed),
        }
        return _torques(run, left_at) | _motion(run) | aspect | _measures(run) | _errors(run)


def _torques(run: Run, left_at: float | None) -> dict[str, Metric]:
    magnitude = np.abs(run.tau)
    largest = magnitude.max(axis=1)
    sample = int(largest.argmax())
    inside = largest if left_at is None else largest[run.t < left_at]
    return {
        "end": float(run.t[-1]),
        "samples": len(run.t),
        "peak_torque": float(largest[sample]),
        "peak_torque_time": seconds(run.t[sample]),
        "peak_torque_joint": run.arm.joint_names[int(magnitude[sample].argmax())],
        "peak_torque_inside": float(inside.max()),
        "torque_squared_integral": _finite(torque_squared_integral(run)),
        "torque_total_variation": _finite(total_variation(run.tau).sum()),
    }


def _motion(run: Run) -> dict[str, Metric]:
    return {
        "peak_speed": _finite(np.abs(run.v).max()),
        "self_motion_max": _finite(np.linalg.norm(run.homogeneous_velocity, axis=1).max()),
        "self_motion_energy_max": _finite(run.self_motion_energy.max()),
    }


def _margin(run: Run, signed: NDArray[np.intp]) -> float | None:
    """Return the least of sign(δ_i(0)) δ_i / scale_i over the minors that have a sign at the start; None without any.

    Above zero it says how near the border came, below zero how far the arm went beyond it.
    """
    inside = np.sign(run.minors[0, signed]) * run.minors[:, signed] / run.arm.minor_scales[signed]
    return _finite(inside.min(initial=np.inf))


def _measures(run: Run) -> dict[str, Metric]:
    distance, distance_time = _extreme(run, run.border_distance, np.argmin)
    product, product_time = _extreme(run, run.maciejewski_product, np.argmax)
    return {
        "minor_measure_min": _finite(run.minor_measure.min()),
        "manipulability_min": _finite(run.manipulability.min()),
        "border_distance_min": distance,
        "border_distance_min_time": distance_time,
        "time_to_border_min": _finite(run.time_to_border.min()),
        "maciejewski_product_max": product,
        "maciejewski_product_max_time": product_time,
    }


def _errors(run: Run) -> dict[str, Metric]:
    error = run.tracking_error
    return {
        "tracking_error_max": _finite(error.max()),
        "tracking_error_rms": _finite(np.sqrt((error**2).mean())),
        "tracking_error_end": _finite(error[-1]),
        "orientation_error_max": _finite(run.orientation_error.max()),
    }


def _extreme(run: Run, values: Array, pick: Callable[[Array], np.intp]) -> tuple[float | None, float | None]:
    """Return the largest or smallest value and when it occurs; None twice if it is not finite."""
    sample = pick(values)
    found = _finite(values[sample])
    return found, None if found is None else seconds(run.t[sample])


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def seconds(time: float) -> float:
    """Round the noise of i·dt away."""
    return round(float(time), 9)
