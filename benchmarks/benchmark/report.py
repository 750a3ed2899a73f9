"""The benchmark as Markdown, and as tables on the screen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import typer

from aspect_control.views.screen import show_table

from .targets import Verdict
from .timing import PERCENTILES, EveryTick, Row

EVERY_TICK_HEADER = ("every tick", "", "median", *PERCENTILES, "ticks")
"""What the cells of `every_tick_table` are; times are ratios to the median floor."""


def benchmark_report(
    rows: Sequence[Row], judged: Sequence[Verdict], missing: Sequence[str], machine: Mapping[str, Any]
) -> str:
    """Write the benchmark as Markdown: the machine, the targets, every tick of motions, and every row, ratios first.

    Args:
        rows: The rows of `benchmark.benchmark`.
        judged: What `benchmark.verdicts` makes of them.
        missing: Packages and solvers that are not installed.
        machine: What `benchmark.machine` says.
    """
    versions = ", ".join(f"{name} {number}" for name, number in machine["versions"].items())
    words = {True: "met", False: "**missed**", None: "not measured"}
    motions, others = every_tick_table(rows), [row for row in rows if not isinstance(row, EveryTick)]
    counts = [len(row.seconds) for row in others]
    most, fewest = max(counts), min(counts)
    lines = [
        "# Cost, measured",
        "",
        f"{machine['processor']}, {machine['system']}, Python {machine['python']}; {versions}.",
        f"Not installed: {', '.join(missing) or 'none'}. Wall time; ratios are medians over "
        f"{most} rounds ({fewest} for runs and starts) in which the calls take turns.",
        "",
        "| target | measured | |",
        "| --- | --- | --- |",
    ]
    for each in judged:
        measured = "" if each.measured is None else f"{each.measured:.2f}"
        lines.append(f"| {each.target} | {measured} | {words[each.met]} |")
    lines += ["", f"| {' | '.join(EVERY_TICK_HEADER)} |", "| --- | --- | --- | --- | --- | --- | --- |"]
    lines += [f"| {' | '.join(cells)} |" for cells in motions]
    lines += ["", "| what | | ratio | quartiles | of | µs | |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for row in others:
        values = row.to_dict()
        low, high = values["ratio_quartiles"]
        lines.append(
            f"| {row.group} | {row.name} | {values['ratio']:.2f} | {low:.2f}–{high:.2f} | {row.of} | "
            f"{values['microseconds']:,.1f} | {row.note} |"
        )
    return "\n".join(lines) + "\n"


def every_tick_table(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """Return the rows of which every tick was timed as cells under `EVERY_TICK_HEADER`."""
    return [
        (
            row.group,
            row.name,
            *(f"{value:.2f}" for value in (row.ratio, *row.percentiles.values())),
            f"{len(row.seconds):,}",
        )
        for row in rows
        if isinstance(row, EveryTick)
    ]


def show_benchmark(rows: Sequence[Row], judged: Sequence[Verdict], missing: Sequence[str]) -> None:
    """Print the rows of the benchmark, ratios first, then every tick of motions, and then which targets are met."""
    others = [row for row in rows if not isinstance(row, EveryTick)]
    show_table(
        ("what", "", "ratio", "quartiles", "of", "µs", ""),
        [
            (
                "" if i > 0 and others[i - 1].group == row.group else row.group,
                row.name,
                f"{values['ratio']:.2f}",
                "{:.2f}–{:.2f}".format(*values["ratio_quartiles"]),
                row.of,
                f"{values['microseconds']:,.1f}",
                row.note,
            )
            for i, row in enumerate(others)
            for values in [row.to_dict()]
        ],
    )
    show_table(EVERY_TICK_HEADER, every_tick_table(rows))
    words = {True: "met", False: "missed", None: "not measured"}
    show_table(
        ("target", "measured", ""),
        [(each.target, "" if each.measured is None else f"{each.measured:.2f}", words[each.met]) for each in judged],
    )
    for name in missing:
        typer.echo(f"not installed: {name}")
