"""The paper's hypothesis on random motions: is keeping the aspect necessary for a stable torque?

`outcome` holds the definitions, `experiment` the draws, `tables` the statistics.
"""

from __future__ import annotations

from .examine import examine_hypothesis, time_estimate
from .experiment import ABLATION, Draw, Experiment
from .outcome import THRESHOLD, THRESHOLDS, Outcome, SampleOutcome
from .result import EXPLODED_INSIDE, LEFT_AND_CALM, Counterexample, HypothesisResult
from .tables import AspectTable, Proportion, proportion, rank_correlation

__all__ = [
    "ABLATION",
    "EXPLODED_INSIDE",
    "LEFT_AND_CALM",
    "THRESHOLD",
    "THRESHOLDS",
    "AspectTable",
    "Counterexample",
    "Draw",
    "Experiment",
    "HypothesisResult",
    "Outcome",
    "Proportion",
    "SampleOutcome",
    "examine_hypothesis",
    "proportion",
    "rank_correlation",
    "time_estimate",
]
