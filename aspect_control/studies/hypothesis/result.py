"""What random motions say about the hypothesis, for one arm under one setting.

Aspect kept: no minor that has a sign at the start changes it (`analysis.aspect_preserved`).

Reference of a motion: the smallest peak torque among the laws that finish it.

Exploded: the run ended early, by divergence or a lost target, or the largest |τ| of any joint is more than a threshold
times the reference; calm is everything else. A motion that no law finishes has no reference and is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..cases import Place
from ..rows import ERROR
from ..study import Study
from ..study_summary import THRESHOLD
from .aspect_table import AspectTable, paired_difference, rank_correlation
from .condition import Condition
from .hypothesis_study import ABLATION

if TYPE_CHECKING:
    import pandas as pd

THRESHOLDS = (2.0, 3.0, 10.0, 30.0, 100.0)
"""Peak torques over the reference beyond which a run counts as exploded; 2 is also the survey's."""

LEFT_AND_CALM, EXPLODED_INSIDE = "left and calm", "kept and exploded"
"""The two kinds of counterexamples: to the necessity of keeping the aspect, and to its sufficiency."""

MOST_COUNTEREXAMPLES = 2
"""Counterexamples that are picked for each law and kind."""

FINER = 4
"""How many times more finely the counterexamples are sampled again."""

MEASURES = ("margin", "manipulability_min", "self_motion_max")
"""Columns that peak torques are correlated with."""


@dataclass(frozen=True)
class Counterexample:
    """A run that contradicts one direction of the hypothesis.

    Attributes:
        kind: `LEFT_AND_CALM` or `EXPLODED_INSIDE`.
        row: Number of its row in the table.
        scenario: Name of the scenario.
        sample: Number of the motion.
        law: Label of the law.
        point: Number of the grid point.
        dt: Sampling time, s.
        reference: Reference of the motion, N m.
        peak_torque: Its peak torque, N m.
        margin: Its smallest normalised minor, negative if the aspect was left.
        sign_changes: How often a minor changed sign.
        status: How it ended.
        finer_peak_torque: Its peak torque at a quarter of the sampling time, N m; None if that was not run.
        holds: Whether it is a counterexample of the same kind then; None if that was not run.
    """

    kind: str
    row: int
    scenario: str
    sample: int
    law: str
    point: int
    dt: float
    reference: float
    peak_torque: float
    margin: float
    sign_changes: int
    status: str
    finer_peak_torque: float | None = None
    holds: bool | None = None

    def checked(self, study: Study) -> Counterexample:
        """Return the counterexample with what becomes of it at a quarter of the sampling time.

        Args:
            study: The study of the table.
        """
        run = study.record(self.scenario, self.sample, self.law, self.point, self.dt / FINER)
        peak = float(np.abs(run.tau).max())
        burst = run.status != "finished" or peak / self.reference > THRESHOLD
        kept = bool(run.metrics()["aspect_preserved"])
        return replace(self, finer_peak_torque=peak, holds=kept == burst and burst == (self.kind == EXPLODED_INSIDE))

    @property
    def place(self) -> Place:
        """Which run of the study it is."""
        return Place(self.scenario, self.sample, self.law, self.point)


class HypothesisResult:
    """The runs of one arm under one setting, held against the reference of their motion.

    Attributes:
        condition: What was run.
        rows: The runs of motions that have a reference, with columns `reference` (N m) and `ratio`, the peak torque
            over it.
        undecided: Numbers of the motions that no law finished; they are in no table.
        failed: How many runs raised an error; they are in no table.
    """

    def __init__(self, condition: Condition) -> None:
        """Hold the runs of a condition against the references of their motions."""
        self.condition = condition
        rows = condition.rows
        finished = rows[rows["status"] == "finished"]
        reference = rows["sample"].map(finished.groupby("sample")["peak_torque"].min())
        self.undecided = tuple(int(sample) for sample in rows["sample"][reference.isna()].unique())
        self.failed = int((rows["status"] == ERROR).sum())
        rows = rows.assign(reference=reference, ratio=rows["peak_torque"] / reference)
        rows = rows[reference.notna() & (rows["status"] != ERROR)]
        self.rows = rows.astype({"aspect_preserved": bool, "sign_changes": int})

    @property
    def laws(self) -> tuple[str, ...]:
        """Labels of the laws."""
        return self.condition.laws

    @cached_property
    def motions(self) -> pd.DataFrame:
        """The motions that have a reference, one row each."""
        return self.rows.drop_duplicates("sample")

    @property
    def bound(self) -> float:
        """`THRESHOLD` times the median reference of all motions, N m: what is a large torque whatever the motion."""
        return THRESHOLD * float(self.motions["reference"].median()) if len(self.motions) else math.inf

    @property
    def demanding(self) -> tuple[int, ...]:
        """Numbers of the motions whose reference is beyond `bound`: no law is calm there but in comparison."""
        return tuple(int(each) for each in self.motions["sample"][self.motions["reference"] > self.bound])

    def of(self, law: str) -> pd.DataFrame:
        """Return the runs of a law."""
        return self.rows[self.rows["law"] == law]

    def table(self, law: str, threshold: float = THRESHOLD) -> AspectTable:
        """Return the runs of a law by aspect and torque.

        Args:
            law: Label of the law.
            threshold: Peak torque over the reference beyond which a run counts as exploded.
        """
        rows = self.of(law)
        kept = rows["aspect_preserved"].to_numpy(dtype=bool)
        inside = rows["peak_torque_inside"].to_numpy() > threshold * rows["reference"].to_numpy()
        return AspectTable.of(law, threshold, kept, exploded(rows, threshold), inside)

    def left_and_calm(self) -> pd.DataFrame:
        """Return the runs that contradict necessity at `THRESHOLD`: those that left their aspect and are calm."""
        return self.rows[~self.rows["aspect_preserved"] & ~exploded(self.rows, THRESHOLD)]

    def correlations(self, law: str) -> dict[str, dict[str, float | None]]:
        """Return Spearman's rank correlations across the motions of `ratio` and `peak_torque` with `MEASURES`."""
        rows = self.of(law)
        return {
            torque: {
                measure: rank_correlation(*(rows[[measure, torque]].dropna()[each] for each in (measure, torque)))
                for measure in MEASURES
            }
            for torque in ("ratio", "peak_torque")
        }

    def minor_measure(self) -> dict[str, Any] | None:
        """Return how JMDC with and without its minor measure differ on the same motions; None if either is missing.

        Returns:
            `kept` and `exploded`, see `paired_difference`: the one is with the measure.
        """
        both = self.rows[self.rows["law"].isin(["jmdc", ABLATION])]
        if both["law"].nunique() < 2:
            return None
        found = {}
        for name, values in (("kept", both["aspect_preserved"]), ("exploded", exploded(both, THRESHOLD))):
            paired = both.assign(holds=values).pivot_table(index="sample", columns="law", values="holds").dropna()
            found[name] = paired_difference(*(paired[law].to_numpy() > 0.5 for law in ("jmdc", ABLATION)))
        return found

    def clearest(self) -> list[Counterexample]:
        """Return the clearest counterexamples at `THRESHOLD`, some of each law and kind.

        Runs that left and stayed calm: those that went farthest beyond the border among the calm ones at the lowest
        threshold that has any. Runs that exploded inside their aspect: those with the largest peak ratio.
        """
        found = []
        for law in self.laws:
            rows = self.of(law)
            burst, kept = exploded(rows, THRESHOLD), rows["aspect_preserved"]
            calm_from = rows.assign(calm_from=np.searchsorted(THRESHOLDS, rows["ratio"]))
            outside = calm_from[~kept & ~burst].sort_values(["calm_from", "margin", "sample"])
            inside = rows[kept & burst].sort_values(["ratio", "sample"], ascending=[False, True])
            for kind, picked in ((LEFT_AND_CALM, outside), (EXPLODED_INSIDE, inside)):
                found += [_counterexample(kind, row) for row in picked.head(MOST_COUNTEREXAMPLES).to_dict("records")]
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the runs one by one as plain data, for JSON."""
        condition, motions = self.condition, self.motions
        calm = self.left_and_calm()
        first = condition.rows.iloc[0] if len(condition.rows) else dict.fromkeys(condition.rows)
        return {
            "scenario": condition.scenario,
            "changes": condition.changes,
            **{key: _plain(first[key]) for key in ("robot", "seed", "dt", "minors", "redundancy")},
            "laws": list(self.laws),
            "samples": int(condition.rows["sample"].nunique()),
            "undecided": list(self.undecided),
            "failed": self.failed,
            "demanding": list(self.demanding),
            "left_and_calm": {"count": len(calm), "below_bound": int((calm["peak_torque"] <= self.bound).sum())},
            **{
                f"drawn_again_{name}": _sum(condition.rows.drop_duplicates("sample")[column])
                for name, column in (("on_border", "on_border"), ("for_length", "wrong_length"))
            },
            "reference": _spread(motions["reference"]),
            "length": _spread(motions["path_length"]),
            "duration": _spread(motions["duration"]),
            "wall_time": _spread(condition.rows["wall_time"]),
            "endings": {law: self._endings(law) for law in self.laws},
            "tables": [self.table(law, threshold).to_dict() for threshold in THRESHOLDS for law in self.laws],
            "association": {law: self.table(law).association() for law in self.laws},
            "correlations": {law: self.correlations(law) for law in self.laws},
            "minor_measure": self.minor_measure(),
        }

    def _endings(self, law: str) -> dict[str, int]:
        counts = self.of(law)["status"].value_counts()
        return {status: int(counts[status]) for status in sorted(counts.index)}


def exploded(rows: pd.DataFrame, threshold: float) -> NDArray[np.bool_]:
    """Return which runs ended early or have a peak torque of more than a threshold times their reference."""
    burst: NDArray[np.bool_] = ((rows["status"] != "finished") | (rows["ratio"] > threshold)).to_numpy(dtype=bool)
    return burst


def _counterexample(kind: str, row: dict[str, Any]) -> Counterexample:
    kept = ("row", "scenario", "sample", "law", "point", "dt", "reference", "peak_torque", "margin", "sign_changes")
    return Counterexample(kind=kind, status=row["status"], **{name: row[name] for name in kept})


def _spread(values: pd.Series[float]) -> dict[str, float] | None:
    values = values.dropna()
    if not len(values):
        return None
    return {
        "min": float(values.min()),
        "median": float(values.median()),
        "mean": float(values.mean()),
        "max": float(values.max()),
    }


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _sum(values: Iterable[float]) -> int:
    return int(np.nansum(np.asarray(values, dtype=np.float64)))
