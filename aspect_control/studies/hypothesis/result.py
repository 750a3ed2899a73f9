"""What the random motions say about the hypothesis, all of them together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .experiment import Experiment
from .outcome import THRESHOLD, THRESHOLDS, Outcome, SampleOutcome
from .tables import AspectTable, rank_correlation

LEFT_AND_CALM, EXPLODED_INSIDE = "left and calm", "kept and exploded"
"""The two kinds of counterexamples: to the necessity of keeping the aspect, and to its sufficiency."""

MOST_COUNTEREXAMPLES = 2
"""Counterexamples that are picked for each law and kind."""

FINER = 4
"""How many times more finely the counterexamples are sampled again."""

MEASURES = ("margin", "manipulability", "self_motion")
"""Fields of `Outcome` that peak torques are correlated with."""


@dataclass(frozen=True)
class Counterexample:
    """A run that contradicts a direction of the hypothesis.

    Attributes:
        kind: `LEFT_AND_CALM` or `EXPLODED_INSIDE`.
        index: Number of its sample.
        outcome: What it came to.
        finer: What it came to at a quarter of the sampling time, with the same reference; None if that was not run.
    """

    kind: str
    index: int
    outcome: Outcome
    finer: Outcome | None = None

    @property
    def holds(self) -> bool | None:
        """Whether it is a counterexample of the same kind when sampled more finely; None if that was not run."""
        if self.finer is None:
            return None
        return self.kind == _kind(self.finer, THRESHOLD)

    def to_dict(self) -> dict[str, Any]:
        """Return the counterexample as plain data, for JSON."""
        return {**asdict(self), "holds": self.holds}


@dataclass(frozen=True)
class HypothesisResult:
    """Outcomes of random motions, by sample and law.

    Attributes:
        experiment: What was drawn and run.
        requested: How many samples were asked for.
        samples: Those that were computed, by index.
        counterexamples: The clearest ones.
    """

    experiment: Experiment
    requested: int
    samples: tuple[SampleOutcome, ...]
    counterexamples: tuple[Counterexample, ...] = ()

    @property
    def undecided(self) -> tuple[int, ...]:
        """Indices of the samples that no law finished; they are in no table."""
        return tuple(sample.index for sample in self.samples if sample.reference is None)

    @property
    def bound(self) -> float:
        """`THRESHOLD` times the median reference of all samples, N m: what is a large torque whatever the sample."""
        references = [sample.reference for sample in self.samples if sample.reference is not None]
        return THRESHOLD * float(np.median(references)) if references else math.inf

    @property
    def demanding(self) -> tuple[int, ...]:
        """Indices of the samples whose reference is beyond `bound`: no law is calm there but in comparison."""
        return tuple(s.index for s in self.samples if s.reference is not None and s.reference > self.bound)

    def left_and_calm(self) -> list[Outcome]:
        """Return the outcomes that contradict necessity at `THRESHOLD`: those that left their aspect and are calm."""
        return [outcome for _, outcome in self._decided() if _kind(outcome, THRESHOLD) == LEFT_AND_CALM]

    def outcomes(self, law: str) -> list[Outcome]:
        """Return the outcomes of a law on the samples that have a reference."""
        return [outcome for _, outcome in self._decided() if outcome.law == law]

    def table(self, law: str, threshold: float = THRESHOLD) -> AspectTable:
        """Return the runs of a law by aspect and torque.

        Args:
            law: Label of the law.
            threshold: One of `THRESHOLDS`.
        """
        return AspectTable.of(law, self.outcomes(law), threshold, THRESHOLDS.index(threshold))

    def all_tables(self) -> list[AspectTable]:
        """Return the table of every law for every threshold."""
        return [self.table(law, threshold) for threshold in THRESHOLDS for law in self.experiment.laws]

    def correlations(self, law: str) -> dict[str, dict[str, float | None]]:
        """Return rank correlations across the samples.

        Args:
            law: Label of the law.

        Returns:
            Spearman's coefficient of `peak_ratio` and of `peak_torque` with each of `MEASURES`.
        """
        picked = self.outcomes(law)
        return {
            torque: {
                measure: rank_correlation(
                    (getattr(each, measure) for each in picked), (getattr(each, torque) for each in picked)
                )
                for measure in MEASURES
            }
            for torque in ("peak_ratio", "peak_torque")
        }

    def clearest(self) -> list[Counterexample]:
        """Return the clearest counterexamples at `THRESHOLD`, some of each law and kind.

        Runs that left and stayed calm: those that went farthest beyond the border among the calm ones at the lowest
        threshold that has any. Runs that exploded inside their aspect: those with the largest peak ratio.
        """
        found = []
        for law in self.experiment.laws:
            mine = [(sample, each) for sample, each in self._decided() if each.law == law]
            outside = [pair for pair in mine if _kind(pair[1], THRESHOLD) == LEFT_AND_CALM]
            inside = [pair for pair in mine if _kind(pair[1], THRESHOLD) == EXPLODED_INSIDE]
            outside.sort(key=lambda pair: (_calm_up_to(pair[1]), pair[1].margin))
            inside.sort(key=lambda pair: -(pair[1].peak_ratio or 0.0))
            for kind, pairs in ((LEFT_AND_CALM, outside), (EXPLODED_INSIDE, inside)):
                found += [Counterexample(kind, sample.index, each) for sample, each in pairs[:MOST_COUNTEREXAMPLES]]
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the samples one by one as plain data, for JSON."""
        references = [sample.reference for sample in self.samples if sample.reference is not None]
        experiment = self.experiment
        return {
            "scenario": experiment.name,
            "seed": experiment.seed,
            "dt": experiment.dt,
            "laws": [section.model_dump() for section in experiment.scenario.controllers],
            "requested": self.requested,
            "samples": len(self.samples),
            "undecided": list(self.undecided),
            "demanding": list(self.demanding),
            "left_and_calm": {
                "count": len(self.left_and_calm()),
                "below_bound": sum(each.peak_torque <= self.bound for each in self.left_and_calm()),
            },
            "drawn_again_on_border": sum(sample.on_border for sample in self.samples),
            "drawn_again_for_length": sum(sample.wrong_length for sample in self.samples),
            "reference": _spread(references),
            "length": _spread([float(np.linalg.norm(sample.displacement)) for sample in self.samples]),
            "duration": _spread([sample.duration for sample in self.samples]),
            "endings": {law: self._endings(law) for law in experiment.laws},
            "tables": [table.to_dict() for table in self.all_tables()],
            "correlations": {law: self.correlations(law) for law in experiment.laws},
            "counterexamples": [each.to_dict() for each in self.counterexamples],
        }

    def _endings(self, law: str) -> dict[str, int]:
        endings = [each.status for each in self.outcomes(law)]
        return {status: endings.count(status) for status in sorted(set(endings))}

    def _decided(self) -> Iterator[tuple[SampleOutcome, Outcome]]:
        for sample in self.samples:
            if sample.reference is not None:
                for outcome in sample.outcomes:
                    yield sample, outcome


def _kind(outcome: Outcome, threshold: float) -> str | None:
    burst = outcome.exploded(threshold)
    if outcome.aspect_preserved == burst:
        return EXPLODED_INSIDE if burst else LEFT_AND_CALM
    return None


def _calm_up_to(outcome: Outcome) -> float:
    """Return the lowest of `THRESHOLDS` at which the outcome is calm."""
    return min((threshold for threshold in THRESHOLDS if not outcome.exploded(threshold)), default=np.inf)


def _spread(values: Sequence[float]) -> dict[str, float] | None:
    if not values:
        return None
    return {"min": float(min(values)), "median": float(np.median(values)), "max": float(max(values))}
