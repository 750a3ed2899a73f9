"""What the table of any study says: shares and percentiles of its runs, by scenario, grid point and law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .proportion import Proportion, proportion

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

THRESHOLD = 10.0
"""Peak torque over the reference beyond which a run counts as exploded, where only one threshold is used."""


@dataclass(frozen=True)
class Spread:
    """Where a metric lies.

    Attributes:
        median: Half of the runs have at most this; NaN without runs.
        p95: 95 % of the runs have at most this; NaN without runs.
    """

    median: float
    p95: float


@dataclass(frozen=True)
class RunsSummary:
    """What a group of runs of a study came to.

    Attributes:
        group: What the runs have in common: values by the names of their columns.
        runs: How many runs there are.
        finished: Those that reached the end of their motion.
        failed: Those that an error ended; all that follows leaves them out.
        kept: Share of the runs that kept their aspect, with the interval of as many runs as there are motions.
        exploded: Share of the runs with a reference that exploded, see `with_explosions`; with the same interval.
        overflowed: Runs whose peak torque is no finite number; the spreads leave them out.
        peak_torque: Largest |τ| of any joint, N m.
        torque_squared_integral: ∫‖τ‖²dt, N² m² s.
        tracking_error: Largest distance from the target, m.
        wall_time: Mean time that a run took, s; NaN if it is not known.
    """

    group: dict[str, Any]
    runs: int
    finished: int
    failed: int
    kept: Proportion
    exploded: Proportion
    overflowed: int
    peak_torque: Spread
    torque_squared_integral: Spread
    tracking_error: Spread
    wall_time: float


def grid_keys(table: pa.Table) -> list[str]:
    """Return the keys of a study's grid: the columns between `point` and `parameters`.

    Args:
        table: The table of a study.
    """
    names: list[str] = table.column_names
    return names[names.index("point") + 1 : names.index("parameters")]


def varying_keys(table: pa.Table) -> list[str]:
    """Return those of the keys of a study's grid that take more than one value.

    Args:
        table: The table of a study.
    """
    return [key for key in grid_keys(table) if len(table[key].drop_null().unique()) > 1]


def with_explosions(table: pa.Table) -> pd.DataFrame:
    """Return the runs of a study, each beside the calmest run of the same motion.

    Args:
        table: The table of a study.

    Returns:
        The table with three more columns. `reference`: the smallest peak torque among the laws that finish the same
        sample of the same scenario, N m, with the same values of the grid but for parameters of single laws;
        `peak_ratio`: the run's peak over it; `exploded`: whether that is above `THRESHOLD` or the run diverged. All are
        missing without a reference and for a run that failed. A torque that overflowed counts as infinite.
    """
    runs = table.to_pandas()
    failed = runs["status"] == "error"
    peaks = runs["peak_torque"].astype(float).fillna(np.inf).mask(failed)
    finished = peaks.where(runs["status"] == "finished")
    of_one_law = tuple(f"controller.{law}." for law in runs["law"].unique())
    same = ["scenario", "sample", *(key for key in grid_keys(table) if not key.startswith(of_one_law))]
    reference = finished.groupby([runs[key] for key in same], dropna=False).transform("min")
    ratio = peaks / reference
    exploded = (ratio > THRESHOLD) | (runs["status"] == "diverged")
    return runs.assign(
        reference=reference, peak_ratio=ratio, exploded=exploded.astype("boolean").mask(ratio.isna().to_numpy())
    )


def study_summary(table: pa.Table, by: Sequence[str] = ("scenario", "law")) -> list[RunsSummary]:
    """Return one summary for each group of runs of a study, in the order of their first runs.

    Args:
        table: The table of a study.
        by: Columns whose values make a group.
    """
    groups = with_explosions(table).groupby(list(by), sort=False, dropna=False)
    return [_summary(dict(zip(by, key, strict=True)), runs) for key, runs in groups]


def _summary(group: dict[str, Any], runs: pd.DataFrame) -> RunsSummary:
    failed = runs["status"] == "error"
    return RunsSummary(
        group=group,
        runs=len(runs),
        finished=int((runs["status"] == "finished").sum()),
        failed=int(failed.sum()),
        kept=_share(runs, "aspect_preserved"),
        exploded=_share(runs, "exploded"),
        overflowed=int((runs["peak_torque"].isna() & ~failed).sum()),
        peak_torque=_spread(runs["peak_torque"]),
        torque_squared_integral=_spread(runs["torque_squared_integral"]),
        tracking_error=_spread(runs["tracking_error_max"]),
        wall_time=float(runs["wall_time"].mean()),
    )


def _share(runs: pd.DataFrame, column: str) -> Proportion:
    """Return the share of a truth value, with the interval of as many runs as there are motions.

    Runs on one motion, at several points of a grid, tell little more than one of them.
    """
    known = runs.dropna(subset=[column])
    count, motions = int(known[column].sum()), len(known[["scenario", "sample"]].drop_duplicates())
    interval = proportion(round(motions * count / len(known)), motions) if motions else proportion(0, 0)
    return Proportion(count, len(known), interval.low, interval.high)


def _spread(values: pd.Series[Any]) -> Spread:
    numbers = values.astype(float)
    return Spread(float(numbers.quantile(0.5)), float(numbers.quantile(0.95)))
