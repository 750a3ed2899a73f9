"""How far long work has come: a bar on a terminal, a line now and then where there is none."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from ..studies.study_progress import StudyProgress

SECONDS_BETWEEN_LINES = 30.0
"""How often a line is printed where there is no terminal, s."""


@contextmanager
def progress_bar() -> Iterator[Callable[[str, float], None]]:
    """Show on standard error how far work has come.

    Yields:
        A function that takes what is being done and the part of all work that is done, 0 to 1.
    """
    console = Console(stderr=True)
    columns = (
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task, lines = progress.add_task("", total=1.0), _Lines(console)

        def show(label: str, part: float) -> None:
            progress.update(task, description=label, completed=part)
            lines.show(f"{100.0 * part:.0f} %: {label}")

        yield show


@contextmanager
def study_progress() -> Iterator[Callable[[StudyProgress], None]]:
    """Show on standard error how far a study has come: runs done and failed, rate and remaining time.

    Yields:
        What `Study.run` takes as `progress`.
    """
    with progress_bar() as show:
        yield lambda progress: show(describe_progress(progress), progress.done / progress.total)


def describe_progress(progress: StudyProgress) -> str:
    """Say in words how far a study has come: `"120 of 400 runs, 1 failed, 12.3 a second, 23 s to go"`."""
    parts = [f"{progress.done:,} of {progress.total:,} runs", f"{progress.failed:,} failed"]
    if progress.remaining is not None:
        parts += [f"{progress.rate:.3g} a second", f"{describe_time(progress.remaining)} to go"]
    return ", ".join(parts)


def describe_time(seconds: float) -> str:
    """Return a time for reading: `"40 s"`, `"12 min"`, `"3.5 h"`, `"2.1 days"`."""
    for length, unit in ((86400.0, "days"), (3600.0, "h")):
        if seconds >= length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds / 60.0:.0f} min" if seconds >= 60.0 else f"{seconds:.0f} s"


class _Lines:
    """Lines on what is no terminal, such as the log of a batch queue."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last = time.monotonic()

    def show(self, text: str) -> None:
        now = time.monotonic()
        if not self._console.is_terminal and now - self._last >= SECONDS_BETWEEN_LINES:
            self._last = now
            self._console.print(text, soft_wrap=True, markup=False, highlight=False)
