"""Shares of runs with their confidence intervals."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Proportion:
    """A share of runs, with the 95 % confidence interval of Wilson.

    Attributes:
        count: Runs of the kind.
        total: Runs in all.
        low: Lower end of the interval.
        high: Upper end of the interval.
    """

    count: int
    total: int
    low: float
    high: float

    @property
    def value(self) -> float | None:
        """The share; None without runs."""
        return self.count / self.total if self.total else None

    def to_dict(self) -> dict[str, Any]:
        """Return the proportion as plain numbers, for JSON."""
        return {**asdict(self), "value": self.value}


def proportion(count: int, total: int) -> Proportion:
    """Return a share with its interval; of no runs nothing is known, so that the interval is 0 to 1."""
    from scipy.stats import binomtest

    if total == 0:
        return Proportion(0, 0, 0.0, 1.0)
    low, high = binomtest(count, total).proportion_ci(0.95, method="wilson")
    return Proportion(count, total, float(low), float(high))
