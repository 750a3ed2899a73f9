"""Any study as Markdown."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from ...studies.study_summary import THRESHOLD, RunsSummary, Spread, study_summary, varying_keys
from .markdown import markdown_table, share

if TYPE_CHECKING:
    import pyarrow as pa

MOST_MESSAGES = 20
"""The most ways to fail that a report lists."""

_COLUMNS = (
    "runs",
    "finished",
    "failed",
    "kept the aspect",
    "exploded",
    "peak torque (N m)",
    "∫‖τ‖²dt (N² m² s)",
    "tracking error (mm)",
    "time a run (s)",
)


def study_report(table: pa.Table, description: str = "") -> str:
    """Return what the table of any study says, as Markdown.

    Args:
        table: The table of a study.
        description: What the study is about, in a sentence.
    """
    keys = varying_keys(table)
    versions = [name for name in table.column_names if name.startswith("version.")]
    lines = [
        f"# {(table.schema.metadata or {}).get(b'name', b'Study').decode()}",
        "",
        *([description, ""] if description else []),
        f"{table.num_rows:,} runs of study `{_all(table, 'study')}`, seed {_all(table, 'seed')}, "
        f"dt = {_all(table, 'dt')} s. Made with "
        + ", ".join(f"{name.removeprefix('version.')} {_all(table, name)}" for name in versions)
        + f"; kernels: {_all(table, 'kernels')}.",
        "",
        "Kept the aspect: no minor of the Jacobian that has a sign at the start changed it. The reference of a motion "
        "is the smallest peak torque, the largest |τ| of any joint, among the laws that finish it"
        + (" with the same values of the grid, but for parameters of single laws" if keys else "")
        + f". Exploded: the run diverged, or its peak is more than {THRESHOLD:g} times the reference; motions "
        "without a reference are left out. In brackets 95 % confidence intervals (Wilson)"
        + (
            ", where several points of the grid stand together those of as many runs as there are motions"
            if keys
            else ""
        )
        + ". Of peak torque, its integral and the tracking error: median / 95th percentile of the runs that did not "
        "fail.",
        "",
        "![what each law came to](study.png)",
        "",
    ]
    summaries = study_summary(table)
    for scenario in _distinct(table, "scenario"):
        lines += [f"## {scenario}", "", *_table(summaries, scenario, ("law",)), ""]
        if keys:
            lines += [f"![shares along the grid on {scenario}]({quote(f'grid-{scenario}.png')})", ""]
    overflowed = sum(each.overflowed for each in summaries)
    if overflowed:
        lines += [f"The torque of {overflowed:,} runs overflowed; medians and percentiles are without it.", ""]
    if keys:
        lines += ["## Each point of the grid", ""]
        points = study_summary(table, ("scenario", "point", *keys, "law"))
        for scenario in _distinct(table, "scenario"):
            lines += [f"### {scenario}", "", *_table(points, scenario, ("point", *keys, "law")), ""]
    return "\n".join(lines + _endings(table))


def _table(summaries: Sequence[RunsSummary], scenario: str, names: Sequence[str]) -> list[str]:
    """Return the table of those summaries that are of a scenario; what each row begins with is named."""
    mine = [each for each in summaries if each.group["scenario"] == scenario]
    return markdown_table(
        (*names, *_COLUMNS), [[*(_text(each.group[name]) for name in names), *_cells(each)] for each in mine]
    )


def _cells(each: RunsSummary) -> tuple[str, ...]:
    return (
        *(f"{count:,}" for count in (each.runs, each.finished, each.failed)),
        share(each.kept),
        share(each.exploded),
        _spread(each.peak_torque),
        _spread(each.torque_squared_integral),
        _spread(each.tracking_error, 1e3),
        "–" if math.isnan(each.wall_time) else f"{each.wall_time:.2g}",
    )


def _spread(spread: Spread, factor: float = 1.0) -> str:
    if math.isnan(spread.median):
        return "–"
    return f"{_number(factor * spread.median)} / {_number(factor * spread.p95)}"


def _number(value: float) -> str:
    """Write a number with three digits or more, in scientific notation if it is huge."""
    return f"{value:,.0f}" if 1e3 <= value < 1e6 else f"{value:.3g}"


def _text(value: Any) -> str:
    if value is None or value != value:  # NaN, where a key of the grid concerns other laws
        return ""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _distinct(table: pa.Table, name: str) -> list[Any]:
    return list(table[name].unique().drop_null().to_pylist())


def _all(table: pa.Table, name: str) -> str:
    """Return every value of a column, for reading."""
    return ", ".join(map(_text, _distinct(table, name)))


def _endings(table: pa.Table) -> list[str]:
    """Say how the runs ended that did not finish, by law and status, and why some failed."""
    import pyarrow.compute as pc

    ended = table.filter(pc.field("status") != "finished")
    if ended.num_rows == 0:
        return ["All runs finished.", ""]
    laws, statuses, messages = (list(map(str, ended[name].to_pylist())) for name in ("law", "status", "message"))
    endings = Counter(zip(laws, statuses, strict=True))
    reasons = Counter((law, why) for law, how, why in zip(laws, statuses, messages, strict=True) if how == "error")
    lines = [
        "## How the runs ended that did not finish",
        "",
        *markdown_table(("law", "status", "runs"), [(law, how, f"{count:,}") for (law, how), count in endings.items()]),
        "",
    ]
    if reasons:
        more = len(reasons) - MOST_MESSAGES
        lines += [
            "Why runs failed, the most frequent reasons first:",
            "",
            *[f"- {law}: {why} ({count:,})" for (law, why), count in reasons.most_common(MOST_MESSAGES)],
            *([f"- and {more:,} reasons more"] if more > 0 else []),
            "",
        ]
    return lines
