"""Gradients of the minor measure and of the manipulability with respect to the joint coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .array import Array
from .compiled import COUNT, INDICES, MATRIX, TENSOR, VECTOR, compiled
from .minors import BORDER, minor_columns
from .pseudoinverse import pseudoinverse

MAX_TERMS = 2_000_000
"""The most terms of a Laplace expansion: 80 MB of indices. A task of six coordinates at most needs far fewer."""


def minor_measure_gradient(J: Array, dJ: Array, columns: NDArray[np.intp] | None = None) -> Array:
    """Return ∇H, the gradient of the minor measure of Eq. (18) with respect to the joint coordinates.

    All minors come from one Laplace expansion, row by row, in which minors of fewer rows are shared; followed
    backwards, it gives Σ_S ∂ ln|δ_S| / ∂J in as many steps. That (m, n) matrix is contracted once with ∂J/∂q.

    On the border of an aspect, where a minor is zero to rounding (`border_tolerance`), H has a cusp and no gradient.
    The result there is zero: no side of the border is preferred.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).
        columns: Columns of the minors that H is made of, shape (p, m); None for all.

    Returns:
        ∇H, shape (n,), in the unit of H per rad (per m for a prismatic joint). Never NaN.

    Raises:
        ValueError: If the expansion has more than `MAX_TERMS`, or all minors are asked for and there are too many.
    """
    m, n = J.shape
    chosen = minor_columns(n, m) if columns is None else columns
    gradient: Array = expanded_gradient(J, dJ, laplace_expansion(chosen), len(chosen))
    return gradient


def laplace_expansion(columns: NDArray[np.intp]) -> NDArray[np.int64]:
    """Return the terms of the Laplace expansion of minors, each minor along its last row.

    A minor of k rows and the columns S is Σ_j ±J[k−1, j] δ_{S without j} over j in S, with the minor of no rows 1.

    Args:
        columns: Columns of the minors, shape (p, m); their order within a minor does not matter here.

    Returns:
        Row of J, column of J, index of the smaller minor, index of the minor, and sign of each term, shape (5, t).
        Minors are counted from the one of no rows, 0, to those of all rows, whose indices are the last p.

    Raises:
        ValueError: If there are more than `MAX_TERMS`.
    """
    subsets = [tuple(sorted(each)) for each in columns.tolist()]
    return _laplace_expansion(tuple(subsets))


@lru_cache(maxsize=16)
def _laplace_expansion(subsets: tuple[tuple[int, ...], ...]) -> NDArray[np.int64]:
    levels: list[Sequence[tuple[int, ...]]] = [subsets]
    m, count = len(subsets[0]) if subsets else 0, 0
    for k in range(m, 0, -1):
        count += k * len(levels[-1])
        if count > MAX_TERMS:
            raise ValueError(f"the expansion of {len(subsets):,} minors of {m} rows has more than {MAX_TERMS:,} terms")
        levels.append(sorted({each for subset in levels[-1] for each in combinations(subset, k - 1)}))
    terms: list[tuple[int, ...]] = []
    index: dict[tuple[int, ...], int] = {(): 0}
    first = 1
    for k, level in enumerate(levels[-2::-1]):
        for minor, subset in enumerate(level, start=first):
            for j, column in enumerate(subset):
                terms.append((k, column, index[subset[:j] + subset[j + 1 :]], minor, (-1) ** (k + j)))
        index = {subset: minor for minor, subset in enumerate(level, start=first)}
        first += len(level)
    table = np.array(terms, dtype=np.int64).reshape(-1, 5).T.copy()
    table.flags.writeable = False
    return table


@compiled(MATRIX, TENSOR, INDICES, COUNT)
def expanded_gradient(J: Array, dJ: Array, terms: NDArray[np.int64], count: int) -> Array:
    """Return ∇H of `minor_measure_gradient` from the terms of the expansion.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).
        terms: What `laplace_expansion` returns for the columns of the minors.
        count: Number of minors p.

    Returns:
        ∇H, shape (n,).
    """
    m, n = J.shape
    gradient = np.zeros(n)
    if count == 0:
        return gradient
    rows, columns, smaller, minor, sign = terms[0], terms[1], terms[2], terms[3], terms[4]
    delta, slope, logarithm = np.zeros(minor[-1] + 1), np.zeros(minor[-1] + 1), 0.0
    delta[0] = 1.0
    for t in range(len(sign)):
        delta[minor[t]] += sign[t] * J[rows[t], columns[t]] * delta[smaller[t]]
    border = BORDER * m * _longest_column(J) ** m
    for i in range(len(delta) - count, len(delta)):
        if abs(delta[i]) <= border:
            return gradient
        logarithm += np.log(abs(delta[i]))
        slope[i] = 1.0 / delta[i]
    total = np.zeros((m, n))
    for t in range(len(sign) - 1, -1, -1):
        slope_of_term = sign[t] * slope[minor[t]]
        total[rows[t], columns[t]] += slope_of_term * delta[smaller[t]]
        slope[smaller[t]] += slope_of_term * J[rows[t], columns[t]]
    for i in range(m):
        for j in range(n):
            for k in range(n):
                gradient[k] += total[i, j] * dJ[i, j, k]
    return np.exp(logarithm / count) / count * gradient


@compiled(MATRIX)
def _longest_column(J: Array) -> float:
    longest = 0.0
    for j in range(J.shape[1]):
        square = 0.0
        for i in range(J.shape[0]):
            square += J[i, j] ** 2
        longest = max(longest, square)
    return np.sqrt(longest)


@compiled(MATRIX, VECTOR)
def given_gradient(J: Array, gradient: Array) -> Array:
    """Return a gradient, shape (n,), that was computed before."""
    return gradient


@compiled(MATRIX, TENSOR)
def manipulability_gradient(J: Array, dJ: Array) -> Array:
    """Return ∇w, the gradient of the manipulability of Eq. (25) with respect to the joint coordinates.

    ∂w/∂q_k = w tr(J⁺ ∂J/∂q_k); zero where J has lost rank, where w has a cusp.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).

    Returns:
        ∇w, shape (n,), in the unit of w per rad (per m for a prismatic joint).
    """
    m, n = J.shape
    J_pinv = pseudoinverse(J)
    gradient = np.zeros(n)
    for i in range(m):
        for j in range(n):
            for k in range(n):
                gradient[k] += J_pinv[j, i] * dJ[i, j, k]
    return np.prod(np.linalg.svd(J)[1]) * gradient
