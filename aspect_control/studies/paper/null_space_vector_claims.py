"""What the paper says of the null space vector method and of its minors."""

from __future__ import annotations

import numpy as np
from scipy.stats import spearmanr

from ...analysis import minor_zero_crossings
from ...redundancy import manipulability
from ...simulation import Run
from .claim import (
    AGREES,
    CALM,
    DIFFERS,
    PAPER_PEAK_TIMES,
    PARTLY,
    Claim,
    largest_torque,
    self_motion_speed,
    torque_peaks,
)
from .trajectory_a import Reproduction

PAPER_PRODUCT_PEAK = 6.5e5
"""Peak of θ̇_H·θ̈_H that the paper gives, rad²/s³."""


def null_space_vector_claims(r: Reproduction) -> list[Claim]:
    """Return the claims about the null space vector method."""
    run, calm = r.runs["null-space-vector"], r.runs["modified-null-space-vector"]
    error, length = run.tracking_error.max(), np.linalg.norm(run.x_desired[-1] - run.x_desired[0])
    first, second = _self_motion_path(run)
    calm_first, calm_second = _self_motion_path(calm)
    peaks = torque_peaks(run)
    near = all(abs(time - paper) <= 0.05 for (time, _), paper in zip(peaks, PAPER_PEAK_TIMES, strict=True))
    large = all(size > 10.0 * CALM for _, size in peaks)
    product, instant = run.maciejewski_product.max(), run.t[run.maciejewski_product.argmax()]
    same_instant = abs(instant - peaks[-1][0]) <= 0.005
    ratio = product / PAPER_PRODUCT_PEAK
    return [
        Claim(
            "null space vector",
            "The end-effector follows the commanded trajectory well.",
            f"largest tracking error {1e3 * error:.2g} mm on a path of {length:.2f} m",
            AGREES if error < 0.01 * length else DIFFERS,
        ),
        Claim(
            "null space vector",
            "Configurations are uniform for a short excursion and non-uniform after mid-course.",
            f"path of the self-motion, ∫‖θ̇_H‖dt: {first:.2f} rad before t = 1 s, {second:.2f} rad after; "
            f"modified method: {calm_first:.2f} and {calm_second:.2f} rad",
            AGREES if second > 3.0 * first and second > 10.0 * calm_second else DIFFERS,
        ),
        Claim(
            "null space vector",
            "Physically unachievable torques at about t = 1.25 s and 1.8 s.",
            "local peaks of the largest |τ_i|: " + " and ".join(f"{size:,.0f} N m at {t:.3f} s" for t, size in peaks),
            AGREES if near and large else PARTLY if large else DIFFERS,
            "" if near and large else "the second peak is nearly singular: it moves with the sampling time",
        ),
        Claim(
            "null space vector",
            "The peak of θ̇_H·θ̈_H, about 6.5·10⁵, is at the instant of the peak torque.",
            f"{product:.3g} at {instant:.3f} s, {1e3 * abs(instant - peaks[-1][0]):.1f} ms from the torque peak; "
            f"in continuous time {r.limit.maciejewski_product_max:.4g} at {r.limit.maciejewski_product_max_time:.4f} s",
            AGREES if same_instant and abs(ratio - 1.0) < 0.25 else PARTLY if same_instant else DIFFERS,
            f"{ratio:.2f} times the paper's figure: its height depends on the sampling time (see the table below)",
        ),
    ]


def minors_claims(r: Reproduction) -> list[Claim]:
    """Return the claims that link the minors to the torque."""
    run = r.runs["null-space-vector"]
    zeros = [crossing.time for crossing in minor_zero_crossings(run) if crossing.minor == 2]
    lags = [min((t - zero for zero in zeros if zero <= t), default=np.inf) for t, _ in torque_peaks(run)]
    at_zero = [largest_torque(run)[np.searchsorted(run.t, zero)] for zero in zeros]
    shares = [size / peak for size, (_, peak) in zip(at_zero, torque_peaks(run), strict=False)]
    w = manipulability(run.jacobians)
    deviation = float(np.abs((run.minors**2).sum(axis=1) / w**2 - 1.0).max())
    peak = int(largest_torque(run).argmax())
    inverse_norm = np.array([1.0 / np.linalg.svd(J, compute_uv=False)[-1] for J in run.jacobians])
    tau_tilde = np.linalg.norm(run.pseudoinverse_torque, axis=1)
    with_inverse = float(spearmanr(tau_tilde, inverse_norm).statistic)
    with_self_motion = float(spearmanr(tau_tilde, self_motion_speed(run)).statistic)
    return [
        Claim(
            "minors",
            "The torque peaks of joints 1 and 2 occur almost exactly when δ₂ becomes zero.",
            "δ₂ = 0 at "
            + ", ".join(f"{zero:.3f}" for zero in zeros)
            + " s; the peaks follow "
            + " and ".join(f"{lag:.3f}" for lag in lags)
            + " s later; at the zeros the torque is "
            + " and ".join(f"{100 * share:.1f} %" for share in shares)
            + " of the peak",
            AGREES if max(lags) <= 0.01 else PARTLY if max(lags) <= 0.15 else DIFFERS,
            "near, not at: the torque at the zero itself is small, and the minors δ₁ and δ₃ cross zero as well",
        ),
        Claim(
            "minors",
            "w = √det(J Jᵀ) = (Σδ_i²)^½, Eq. (25).",
            f"largest relative deviation of Σδ_i² from w² {deviation:.1e}",
            AGREES if deviation < 1e-12 else DIFFERS,
        ),
        Claim(
            "minors",
            "Small minors make J⁺ large, hence τ̃, hence the torque.",
            f"at the peak ‖J⁺‖ = {inverse_norm[peak]:.2f}, at the start {inverse_norm[0]:.2f}; w = {w[peak]:.2f}, its "
            f"smallest value {w.min():.2f} is at t = {run.t[w.argmin()]:.3f} s; rank correlation of ‖τ̃‖ with ‖J⁺‖ "
            f"{with_inverse:.2f}, with ‖θ̇_H‖ {with_self_motion:.2f}",
            AGREES if with_inverse > with_self_motion else DIFFERS,
            f"one minor at zero leaves w and J⁺ where they were; what explodes is the self-motion "
            f"(‖θ̇_H‖ = {self_motion_speed(run)[peak]:.0f} rad/s at the peak) and N with its square",
        ),
    ]


def _self_motion_path(run: Run) -> tuple[float, float]:
    first, second = run.t <= 1.0, run.t >= 1.0
    speed = self_motion_speed(run)
    return float(np.trapezoid(speed[first], run.t[first])), float(np.trapezoid(speed[second], run.t[second]))
