"""What the command line shows: progress and tables."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from ..analysis.section4 import AGREES, Claim

LONG = 3600.0
"""Time from which a computation is not begun without having been asked for twice, s."""


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def describe_time(seconds: float) -> str:
    """Return a time for reading: `"40 s"`, `"12 min"`, `"3.5 h"`, `"2.1 days"`."""
    for length, unit in ((86400.0, "days"), (3600.0, "h")):
        if seconds >= length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds / 60.0:.0f} min" if seconds >= 60.0 else f"{seconds:.0f} s"


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


def show_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print rows of text under a header."""
    table = Table(*header, box=None, pad_edge=False)
    for column in table.columns:
        column.overflow = "fold"
    for row in rows:
        table.add_row(*map(escape, row))
    Console().print(table)
