"""Laplace expansions of many minors at once, in which minors of fewer rows are shared."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .array import Table

MAX_TERMS = 2_000_000
"""The most terms of a Laplace expansion: 64 MB of indices. A task of six coordinates at most needs far fewer."""


def laplace_expansion(columns: NDArray[np.intp]) -> Table:
    """Return the terms of the Laplace expansion of minors, each minor along its last row.

    A minor of k rows and the columns S is Σ_j ±J[k−1, j] δ_{S without j} over j in S, with the minor of no rows 1.

    Args:
        columns: Columns of the minors, shape (p, m); their order within a minor does not matter here.

    Returns:
        Row of J, column of J, index of the smaller minor, index of the minor, and sign of each term, shape (5, t).
        Minors are counted among those of as many rows; terms stand in the order of their row.

    Raises:
        ValueError: If there are more than `MAX_TERMS`.
    """
    subsets = [tuple(sorted(each)) for each in columns.tolist()]
    return _laplace_expansion(tuple(subsets))


@lru_cache(maxsize=16)
def _laplace_expansion(subsets: tuple[tuple[int, ...], ...]) -> Table:
    levels: list[Sequence[tuple[int, ...]]] = [subsets]
    m, count = len(subsets[0]) if subsets else 0, 0
    for k in range(m, 0, -1):
        count += k * len(levels[-1])
        if count > MAX_TERMS:
            raise ValueError(f"the expansion of {len(subsets):,} minors of {m} rows has more than {MAX_TERMS:,} terms")
        levels.append(sorted({each for subset in levels[-1] for each in combinations(subset, k - 1)}))
    terms: list[tuple[int, ...]] = []
    index: dict[tuple[int, ...], int] = {(): 0}
    for k, level in enumerate(levels[-2::-1]):
        for minor, subset in enumerate(level):
            for j, column in enumerate(subset):
                terms.append((k, column, index[subset[:j] + subset[j + 1 :]], minor, (-1) ** (k + j)))
        index = {subset: minor for minor, subset in enumerate(level)}
    table = np.array(terms, dtype=np.int64).reshape(-1, 5).T.copy()
    table.flags.writeable = False
    return table
