"""Runs by aspect and torque: counts, tests of association and of differences, and rank correlations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..proportion import Proportion, proportion


@dataclass(frozen=True)
class AspectTable:
    """Runs of a law by aspect and torque.

    Attributes:
        law: Label of the law.
        threshold: Peak torque over the reference beyond which a run counts as exploded.
        kept_calm: Runs that kept their aspect and stayed calm.
        kept_exploded: Runs that kept their aspect and exploded.
        left_calm: Runs that left their aspect and stayed calm.
        left_exploded: Runs that left their aspect and exploded.
        left_first: Those of them that left it before, or in the same sample as, the torque passed the threshold.
    """

    law: str
    threshold: float
    kept_calm: int
    kept_exploded: int
    left_calm: int
    left_exploded: int
    left_first: int

    @classmethod
    def of(
        cls, law: str, threshold: float, kept: NDArray[np.bool_], burst: NDArray[np.bool_], inside: NDArray[np.bool_]
    ) -> AspectTable:
        """Count the runs of a law.

        Args:
            law: Label of the law.
            threshold: Peak torque over the reference beyond which a run counts as exploded.
            kept: Which runs kept their aspect, shape (k,).
            burst: Which runs exploded, shape (k,).
            inside: In which runs the torque passed the threshold before the aspect was left, shape (k,).
        """
        return cls(
            law,
            threshold,
            kept_calm=int((kept & ~burst).sum()),
            kept_exploded=int((kept & burst).sum()),
            left_calm=int((~kept & ~burst).sum()),
            left_exploded=int((~kept & burst).sum()),
            left_first=int((~kept & burst & ~inside).sum()),
        )

    @property
    def total(self) -> int:
        """All runs."""
        return self.kept + self.left

    @property
    def kept(self) -> int:
        """Runs that kept their aspect."""
        return self.kept_calm + self.kept_exploded

    @property
    def left(self) -> int:
        """Runs that left their aspect."""
        return self.left_calm + self.left_exploded

    @property
    def exploded_if_kept(self) -> Proportion:
        """P(exploded | kept): 0 if keeping the aspect is sufficient for a calm torque."""
        return proportion(self.kept_exploded, self.kept)

    @property
    def exploded_if_left(self) -> Proportion:
        """P(exploded | left)."""
        return proportion(self.left_exploded, self.left)

    @property
    def calm_if_left(self) -> Proportion:
        """P(calm | left): 0 if keeping the aspect is necessary for a calm torque."""
        return proportion(self.left_calm, self.left)

    @property
    def exploded_inside(self) -> Proportion:
        """Share of the exploded runs whose torque passed the threshold while they were inside their aspect."""
        burst = self.kept_exploded + self.left_exploded
        return proportion(burst - self.left_first, burst)

    @property
    def risk_difference(self) -> float | None:
        """P(exploded | left) − P(exploded | kept); None if either is unknown."""
        left, kept = self.exploded_if_left.value, self.exploded_if_kept.value
        return None if left is None or kept is None else left - kept

    @property
    def odds_ratio(self) -> tuple[float, float, float] | None:
        """Conditional odds ratio of exploding after leaving to exploding after keeping, with its exact 95 % interval.

        Infinite where no run that kept its aspect exploded; None where a margin of the table is empty.
        """
        from scipy.stats.contingency import odds_ratio

        if not self._has_margins:
            return None
        ratio = odds_ratio(self._matrix, kind="conditional")
        low, high = ratio.confidence_interval(0.95)
        return float(ratio.statistic), float(low), float(high)

    @property
    def fisher_p(self) -> float | None:
        """Fisher's exact test, two-sided, of no association of aspect and torque; None where a margin is empty."""
        from scipy.stats import fisher_exact

        return float(fisher_exact(self._matrix).pvalue) if self._has_margins else None

    @property
    def _matrix(self) -> list[list[int]]:
        return [[self.left_exploded, self.left_calm], [self.kept_exploded, self.kept_calm]]

    @property
    def _has_margins(self) -> bool:
        matrix = np.array(self._matrix)
        return bool(matrix.sum(axis=0).all() and matrix.sum(axis=1).all())

    def to_dict(self) -> dict[str, Any]:
        """Return counts and proportions as plain numbers, for JSON."""
        counts = ("kept_calm", "kept_exploded", "left_calm", "left_exploded", "left_first")
        shares = ("exploded_if_kept", "exploded_if_left", "calm_if_left", "exploded_inside")
        return {
            "law": self.law,
            "threshold": self.threshold,
            **{name: getattr(self, name) for name in counts},
            **{name: getattr(self, name).to_dict() for name in shares},
        }

    def association(self) -> dict[str, Any]:
        """Return how leaving and exploding go together, as plain numbers for JSON; an infinite odds ratio is None.

        The exact interval takes a second for a table of 10,000 runs.
        """
        ratio = self.odds_ratio
        return {
            "risk_difference": self.risk_difference,
            "odds_ratio": None if ratio is None else [each if math.isfinite(each) else None for each in ratio],
            "fisher_p": self.fisher_p,
        }


def paired_difference(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> dict[str, Any]:
    """Compare how often something holds under two laws on the same motions.

    Args:
        one: Whether it holds under the one, shape (k,).
        other: Whether it holds under the other, shape (k,).

    Returns:
        `one` and `other`, the counts; `one_alone` and `other_alone`, the motions on which they differ; and `p` of
        McNemar's exact test, two-sided, of no difference, None where they never differ.
    """
    from scipy.stats import binomtest

    alone, other_alone = int((one & ~other).sum()), int((other & ~one).sum())
    p = float(binomtest(alone, alone + other_alone).pvalue) if alone + other_alone else None
    return {
        "one": int(one.sum()),
        "other": int(other.sum()),
        "one_alone": alone,
        "other_alone": other_alone,
        "p": p,
    }


def rank_correlation(x: ArrayLike, y: ArrayLike) -> float | None:
    """Return Spearman's rank correlation; None for fewer than three pairs, or if one side is constant."""
    from scipy.stats import spearmanr

    a, b = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if len(a) < 3 or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return None
    return float(spearmanr(a, b).statistic)
