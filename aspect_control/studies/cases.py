"""What a study runs on every motion, and how its runs are cut into chunks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from ..exceptions import StudyError, shown
from .identity import digest

CHUNKS, LARGEST_CHUNK, MOST_CHUNKS = 64, 50, 20_000
"""A study is cut into about so many chunks, but for that none has more runs, but for that there are no more chunks."""


class Case(NamedTuple):
    """One law of a scenario at a grid point: what is run on every motion.

    Attributes:
        scenario: Name of the scenario.
        point: Number of the grid point.
        law: Label of the law.
        changes: What the point changes, by the names of the fields, without what concerns other laws alone.
    """

    scenario: str
    point: int
    law: str
    changes: dict[str, Any]


class Place(NamedTuple):
    """Which run a row of the table stands for.

    Attributes:
        scenario: Name of the scenario.
        sample: Number of the motion.
        law: Label of the law.
        point: Number of the grid point.
    """

    scenario: str
    sample: int
    law: str
    point: int


def cases_of(scenario: str, laws: Iterable[str], points: Iterable[Mapping[str, Any]]) -> list[Case]:
    """Return the cases of a scenario: a law only once where the grid changes parameters of others.

    Args:
        scenario: Name of the scenario.
        laws: Labels of its laws.
        points: What each grid point changes, by the names of the fields.
    """
    found: dict[str, Case] = {}
    labels = tuple(laws)
    for point, changes in enumerate(points):
        for law in labels:
            foreign = tuple(f"controller.{other}." for other in labels if other != law)
            own = {field: value for field, value in changes.items() if not field.startswith(foreign)}
            found.setdefault(digest([law, own]), Case(scenario, point, law, own))
    return list(found.values())


def chunk_size(runs: int) -> int:
    """Return how many of so many runs are done, and written, together."""
    return max(min(LARGEST_CHUNK, math.ceil(runs / CHUNKS)), math.ceil(runs / MOST_CHUNKS))


def part(chunks: Sequence[int], shard: str | None) -> Sequence[int]:
    """Return a part of the chunks, such as `"2/8"`; None for all.

    Raises:
        StudyError: If `shard` is no part, or an empty one.
    """
    if shard is None:
        return chunks
    try:
        index, number = map(int, shard.split("/"))
        if not 1 <= index <= number:
            raise ValueError
    except (AttributeError, ValueError):
        raise StudyError(f"shard must be i/n with i from 1 to n, such as 2/8, got {shown(shard)}") from None
    if index > len(chunks):
        raise StudyError(f"shard {shard} is empty: the study has {len(chunks)} chunks; give at most that many shards")
    return chunks[index - 1 :: number]
