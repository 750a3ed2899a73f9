"""What the paper says of the modified null space vector method."""

from __future__ import annotations

import numpy as np

from ...analysis import intervals
from .claim import (
    AGREES,
    CALM,
    DIFFERS,
    PARTLY,
    Claim,
    describe_stretches,
    largest_torque,
    one_aspect,
    peak_torque,
)
from .trajectory_a import Reproduction

PAPER_ON_INTERVALS = ((1.0, 1.65), (1.8, 2.0))
"""When the paper has the null-space term on, s."""


def modified_claims(r: Reproduction) -> list[Claim]:
    """Return the claims about the modified null space vector method."""
    run, exploding = r.runs["modified-null-space-vector"], r.runs["null-space-vector"]
    peak, on = peak_torque(run), intervals(run.t, run.null_space_term_on)
    product = run.maciejewski_product
    fed = product >= 0.0
    return [
        one_aspect("modified method", "The motion stays within one aspect.", run),
        Claim(
            "modified method",
            "Joint torques are drastically held down.",
            f"peak {peak:.1f} N m against {peak_torque(exploding):,.0f} N m",
            AGREES if peak < CALM and peak_torque(exploding) > 100.0 * peak else DIFFERS,
        ),
        Claim(
            "modified method",
            "The null-space term is on from 1.0 to 1.65 s and from 1.8 to 2.0 s.",
            _describe_switching(on),
            AGREES if len(on) == 2 and np.allclose(on, PAPER_ON_INTERVALS, atol=0.05) else PARTLY if on else DIFFERS,
            "once the self-motion is at rest the printed law chatters: the sign of Eq. (12) changes at almost every "
            "sample, and the instants follow rounding errors; the paper's Fig. 3 does not show this",
        ),
        Claim(
            "modified method",
            "Torques stay low even while Eq. (12) holds.",
            f"θ̇_H·θ̈_H ≥ 0 in {100 * fed.mean():.0f} % of the samples, with at most "
            f"{largest_torque(run)[fed].max():.1f} N m there; its largest value is {product.max():.2g}",
            AGREES if largest_torque(run)[fed].max() < CALM else DIFFERS,
        ),
    ]


def _describe_switching(on: list[tuple[float, float]]) -> str:
    if len(on) <= 3:
        return f"on {describe_stretches(on)}"
    start, end = on[0]
    return f"on in {start:.3f}–{end:.3f} s, then switched on and off {len(on) - 1} more times until {on[-1][1]:.3f} s"
