"""A claim of the paper, and the readings of a run that several claims share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...analysis import aspect_preserved, minor_zero_crossings
from ...redundancy import Array
from ...simulation import Run

AGREES, PARTLY, DIFFERS, NOT_MEASURED = "agrees", "partly", "differs", "not measured"

CALM = 20.0
"""Peak torque below which a run of the paper's arm counts as calm, N m."""

EXPLODED = 100.0 * CALM
"""Peak torque above which it counts as exploded, N m."""

PAPER_PEAK_TIMES = (1.25, 1.8)
"""When the paper sees the torque peaks of the null space vector method, s."""


class Claim(NamedTuple):
    """One row of the report.

    Attributes:
        subject: What the claim is about.
        says: What the paper says.
        measured: What was measured.
        verdict: `"agrees"`, `"partly"`, `"differs"`, or `"not measured"` where a run ended early.
        why: The reason where they do not agree.
    """

    subject: str
    says: str
    measured: str
    verdict: str
    why: str = ""


def torque_peaks(run: Run) -> list[tuple[float, float]]:
    """Return time (s) and size (N m) of the largest |τ_i| in each half-second around the paper's two peaks.

    The windows meet midway between the paper's times, 1.25 and 1.8 s, and reach 0.25 s to the outer sides.
    """
    middle = sum(PAPER_PEAK_TIMES) / 2.0
    peaks = []
    for low, high in ((PAPER_PEAK_TIMES[0] - 0.25, middle), (middle, PAPER_PEAK_TIMES[1] + 0.25)):
        inside = np.flatnonzero((run.t >= low) & (run.t < high))
        best = inside[largest_torque(run)[inside].argmax()]
        peaks.append((float(run.t[best]), float(largest_torque(run)[best])))
    return peaks


def one_aspect(subject: str, says: str, run: Run) -> Claim:
    """Return the claim that a run stays within one aspect."""
    smallest = np.abs(run.minors).min(axis=0)
    return Claim(
        subject,
        says,
        f"{len(minor_zero_crossings(run))} zero crossings; smallest |δ_i| {', '.join(f'{d:.2f}' for d in smallest)} m²",
        AGREES if aspect_preserved(run) else DIFFERS,
    )


def describe_stretches(stretches: list[tuple[float, float]]) -> str:
    """Put stretches of time into words."""
    if not stretches:
        return "never"
    shown = ", ".join(f"{start:.3f}–{end:.3f} s" for start, end in stretches[:3])
    return f"in {shown}" + (f" and {len(stretches) - 3} more stretches" if len(stretches) > 3 else "")


def largest_torque(run: Run) -> Array:
    """Return the largest |τ_i| over the joints at each sample, shape (k,), N m."""
    largest: Array = np.abs(run.tau).max(axis=1)
    return largest


def peak_torque(run: Run) -> float:
    """Return the largest |τ_i| over joints and time, N m."""
    return float(largest_torque(run).max())


def self_motion_speed(run: Run) -> Array:
    """Return ‖θ̇_H‖ at each sample, shape (k,), rad/s."""
    speed: Array = np.linalg.norm(run.homogeneous_velocity, axis=1)
    return speed
