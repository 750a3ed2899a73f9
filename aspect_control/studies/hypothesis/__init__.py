"""The paper's hypothesis on random motions: is keeping the aspect necessary for a stable torque?

`hypothesis_study` says what is run, `condition` takes the table apart, `result` holds the definitions, `aspect_table`
the statistics.
"""

from __future__ import annotations

from ..study_summary import THRESHOLD
from .aspect_table import AspectTable, paired_difference, rank_correlation
from .condition import Condition, conditions
from .evidence import Evidence, Part, evidence, results_of, stored
from .hypothesis_study import ABLATION, hypothesis_study
from .result import EXPLODED_INSIDE, LEFT_AND_CALM, THRESHOLDS, Counterexample, HypothesisResult

__all__ = [
    "ABLATION",
    "EXPLODED_INSIDE",
    "LEFT_AND_CALM",
    "THRESHOLD",
    "THRESHOLDS",
    "AspectTable",
    "Condition",
    "Counterexample",
    "Evidence",
    "HypothesisResult",
    "Part",
    "conditions",
    "evidence",
    "hypothesis_study",
    "paired_difference",
    "rank_correlation",
    "results_of",
    "stored",
]
