"""What the command line shows: progress and tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from ..analysis.section4 import AGREES, Claim
from ..benchmark import Row, Verdict


def quantity(value: float) -> str:
    """Write a number for reading: with a decimal and thousands apart, or in scientific notation if it is huge."""
    return f"{value:,.1f}" if abs(value) < 1e7 else f"{value:.1e}"


@contextmanager
def progress_bar() -> Iterator[Callable[[str, float], None]]:
    """Show a progress bar if standard error is a terminal.

    Yields:
        A function that takes what is being done and the part of all work that is done, 0 to 1.
    """
    columns = (
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("", total=1.0)
        yield lambda label, part: progress.update(task, description=label, completed=part)


def show_laws(summary: dict[str, dict[str, Any]]) -> None:
    """Print one row a law: how it ended, peak torque, aspect, tracking error."""
    table = Table("law", "peak torque", "aspect", "tracking error", "ended", box=None, pad_edge=False)
    for column in table.columns:
        column.overflow = "fold"
    for law, values in summary.items():
        table.add_row(
            law,
            f"{quantity(max(values['peak_torque']))} N m",
            "kept" if values["aspect_preserved"] else f"left, {len(values['minor_zero_crossings'])} sign changes",
            f"{1e3 * values['max_tracking_error']:.2g} mm",
            values["status"],
        )
    Console().print(table)
    for law, values in summary.items():
        if values["status"] != "finished":
            Console().print(escape(f"{law}: {values['message']}"))


def show_claims(claims: Sequence[Claim]) -> None:
    """Print one row a claim: the verdict, what the paper says, what was measured."""
    table = Table("verdict", "the paper says", "measured", box=SIMPLE_HEAD, pad_edge=False)
    for claim in claims:
        colour = "green" if claim.verdict == AGREES else "yellow"
        table.add_row(f"[{colour}]{claim.verdict}[/]", f"{claim.subject}: {claim.says}", escape(claim.measured))
    Console().print(table)


def show_benchmark(rows: Sequence[Row], judged: Sequence[Verdict], missing: Sequence[str]) -> None:
    """Print the rows of the benchmark, ratios first, and then which targets are met."""
    show_table(
        ("what", "", "ratio", "quartiles", "of", "µs", ""),
        [
            (
                "" if i > 0 and rows[i - 1].group == row.group else row.group,
                row.name,
                f"{values['ratio']:.2f}",
                "{:.2f}–{:.2f}".format(*values["ratio_quartiles"]),
                row.of,
                f"{values['microseconds']:,.1f}",
                row.note,
            )
            for i, row in enumerate(rows)
            for values in [row.to_dict()]
        ],
    )
    words = {True: "met", False: "missed", None: "not measured"}
    show_table(
        ("target", "measured", ""),
        [(each.target, "" if each.measured is None else f"{each.measured:.2f}", words[each.met]) for each in judged],
    )
    for name in missing:
        Console().print(f"not installed: {name}")


def show_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print rows of text under a header."""
    table = Table(*header, box=None, pad_edge=False)
    for column in table.columns:
        column.overflow = "fold"
    for row in rows:
        table.add_row(*map(escape, row))
    Console().print(table)
