"""The paper's hypothesis: to keep the aspect is necessary for the stability of the torque."""

from __future__ import annotations

from ...analysis import aspect_preserved
from .claim import AGREES, DIFFERS, EXPLODED, PARTLY, Claim, peak_torque
from .trajectory_a import Reproduction


def hypothesis_claims(r: Reproduction) -> list[Claim]:
    """Return the claims that the paper draws from all runs together."""
    left = {law: run for law, run in r.runs.items() if not aspect_preserved(run)}
    exploded = {law for law, run in r.runs.items() if peak_torque(run) > EXPLODED}
    calm_outside = [law for law in left if law not in exploded]
    exploded_inside = [law for law in exploded if law not in left]
    examples = "; ".join(
        f"{law}: {'left' if law in left else 'kept'} the aspect, peak {peak_torque(run):,.1f} N m"
        for law, run in r.runs.items()
    )
    unstable_product = r.runs["null-space-vector"].maciejewski_product.max()
    calm_products = [run.maciejewski_product.max() for law, run in r.runs.items() if law not in exploded]
    return [
        Claim(
            "hypothesis",
            "Preserving the aspect is necessary for the stability of the torque.",
            examples,
            AGREES if not calm_outside and not exploded_inside else PARTLY if not exploded_inside else DIFFERS,
            "the pseudoinverse law leaves the aspect near the end and its torque does not explode: leaving costs "
            "torque here, but keeping the aspect is not necessary for stability",
        ),
        Claim(
            "hypothesis",
            "Instability is a matter of how large the positive peak of θ̇_H·θ̈_H is, not of its sign.",
            f"largest positive value {unstable_product:.2g} where the torque explodes, "
            f"at most {max(calm_products):.2g} elsewhere, yet positive for every law",
            AGREES if min(calm_products) > 0.0 and unstable_product > 1e3 * max(calm_products) else DIFFERS,
        ),
    ]
