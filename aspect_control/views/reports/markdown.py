"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...studies.proportion import Proportion


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines]


def share(each: Proportion) -> str:
    """Write a proportion with its interval, such as `0.25 [0.18, 0.33]`; a dash for that of no runs."""
    return "–" if each.value is None else f"{each.value:.2f} [{each.low:.2f}, {each.high:.2f}]"
