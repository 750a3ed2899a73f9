"""Each claim of the paper's Section 4: what it says, what was measured, and whether they agree.

A verdict is computed from the measurement, by the criterion that stands in the code beside it.
"""

from __future__ import annotations

from .claim import AGREES, DIFFERS, NOT_MEASURED, PARTLY, Claim, torque_peaks
from .cost_claims import cost_claims
from .hypothesis_claims import hypothesis_claims
from .jmdc_claims import jmdc_claims
from .modified_claims import modified_claims
from .null_space_vector_claims import minors_claims, null_space_vector_claims
from .trajectory_a import Reproduction

__all__ = ["AGREES", "DIFFERS", "NOT_MEASURED", "PARTLY", "Claim", "claims", "torque_peaks"]

COARSEST = 0.05
"""The longest sampling time at which the claims can be judged, s."""

_GROUPS = (
    null_space_vector_claims,
    minors_claims,
    modified_claims,
    jmdc_claims,
    cost_claims,
    hypothesis_claims,
)


def claims(reproduction: Reproduction) -> list[Claim]:
    """Hold the runs of trajectory A against the paper's Section 4, in the paper's order.

    Where a run ended early or is sampled too coarsely, there is nothing to hold against the paper, and a row says so.
    """
    if reproduction.dt > COARSEST:
        measured = f"the sampling time is {reproduction.dt:g} s; at most {COARSEST:g} s show the peaks"
        return [Claim("sampling", "The torque peaks are about 0.1 s wide.", measured, NOT_MEASURED)]
    ended_early = [run for run in reproduction.runs.values() if run.status != "finished"]
    if ended_early:
        return [
            Claim(run.info.controller, "The motion of 2 s is completed.", run.message, NOT_MEASURED)
            for run in ended_early
        ]
    return [claim for group in _GROUPS for claim in group(reproduction)]
