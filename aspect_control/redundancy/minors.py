"""Full-row-rank minors of a Jacobian: the aspects, the manipulability and the minor measure.

A minor δ_S is the determinant of the m columns S of the (m, n) Jacobian J. The arm leaves its aspect where one of
them changes sign.

**Order and sign.** The subsets are listed by cyclic rotation: {1, …, m} first, then each of its rotations through the
n columns, then the lexicographically smallest subset not listed yet with its rotations, and so on. The columns of
a minor stand in rotated order, which fixes its sign. For n = 3, m = 2 this gives Eqs. (22)–(24) of the paper,
δ₁ = det[J¹ J²], δ₂ = det[J² J³], δ₃ = det[J³ J¹]; `minor_columns` gives it for every n and m.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .array import Array, Table
from .laplace import laplace_expansion

MAX_MINORS = 20_000
"""The most minors that are computed at once: every one is an m × m determinant at every sample."""

STRUCTURAL_TOLERANCE = 1e-9
"""Relative size below which a minor counts as zero in a posture, for `structural_minor_columns`."""

BORDER = 8.0 * float(np.finfo(np.float64).eps)
"""What `border_tolerance` multiplies m and the m-th power of the longest column of J by."""

_BLOCK = 4_000_000
"""Numbers that are gathered at once when the minors of many Jacobians are computed: 32 MB."""


@lru_cache(maxsize=64)
def minor_columns(n: int, m: int) -> NDArray[np.intp]:
    """Return which columns each minor takes, in the order and sign described above.

    Args:
        n: Number of joints.
        m: Number of task coordinates, 1 ≤ m ≤ n.

    Returns:
        Column indices counted from 0, shape (p, m) with p = n! / (m! (n − m)!); read-only.

    Raises:
        ValueError: If there are more than `MAX_MINORS`.
    """
    count = math.comb(n, m)
    if count > MAX_MINORS:
        raise ValueError(f"a {m} × {n} Jacobian has {count:,} minors; at most {MAX_MINORS:,} are computed")
    listed: dict[frozenset[int], tuple[int, ...]] = {}
    for subset in combinations(range(n), m):
        for shift in range(n):
            rotated = tuple((column + shift) % n for column in subset)
            if listed.setdefault(frozenset(rotated), rotated) is not rotated:
                break
    columns = np.array(list(listed.values()), dtype=np.intp)
    columns.flags.writeable = False
    return columns


def structural_minor_columns(J: Array) -> NDArray[np.intp]:
    """Return the columns of the minors that are not zero throughout a sample of Jacobians.

    Args:
        J: Jacobians of one arm in many random postures, shape (k, m, n).

    Returns:
        Those rows of `minor_columns` whose minor exceeds `STRUCTURAL_TOLERANCE` times the m-th power of the longest
        column of J in at least one posture, shape (p, m).

    Raises:
        ValueError: If there are more than `MAX_MINORS`.
    """
    m, n = J.shape[-2:]
    longest = np.linalg.norm(J, axis=-2).max(axis=-1)
    sizes = np.abs(minors(J)) / longest[:, np.newaxis] ** m
    columns: NDArray[np.intp] = minor_columns(n, m)[sizes.max(axis=0) > STRUCTURAL_TOLERANCE]
    return columns


def minors(J: Array, columns: NDArray[np.intp] | None = None) -> Array:
    """Return the m-th order minors δ_i of J; Eqs. (22)–(24) for n = 3, m = 2.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        columns: Columns of the minors to return, shape (p, m); None for all, in the order of `minor_columns`.

    Returns:
        The minors, shape (..., p). Their unit is the product of the units of J's rows: m² for two positions and
        revolute joints.

    Raises:
        ValueError: If all are asked for and there are more than `MAX_MINORS`.
    """
    m, n = J.shape[-2:]
    chosen = minor_columns(n, m) if columns is None else columns
    stack = J.reshape(-1, m, n)
    block = max(1, _BLOCK // max(chosen.size * m, 1))
    parts = [np.linalg.det(_submatrices(stack[i : i + block], chosen)) for i in range(0, len(stack), block)]
    values: Array = np.concatenate(parts) if parts else np.empty((0, len(chosen)))
    return values.reshape(*J.shape[:-2], len(chosen))


def minor_rates(J: Array, dJ: Array, columns: NDArray[np.intp] | None = None) -> Array:
    """Return the derivatives of the minors where J changes at a rate.

    The minors and their rates grow row by row in one Laplace expansion. No inverse is needed, so that it also holds
    where a minor is zero.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        dJ: Its rate, shape (..., m, n): J̇ for the rate δ̇_i in time, ∂J/∂q_k for one entry of the gradient ∇δ_i.
        columns: Columns of the minors, shape (p, m); None for all, in the order of `minor_columns`.

    Returns:
        The rates, shape (..., p), in the unit of the minors times that of dJ over J.

    Raises:
        ValueError: If all are asked for and there are more than `MAX_MINORS`.
    """
    J, dJ = np.broadcast_arrays(J, dJ)
    m, n = J.shape[-2:]
    chosen = minor_columns(n, m) if columns is None else columns
    terms, order = laplace_expansion(chosen), _order_signs(chosen)
    stack, d_stack = J.reshape(-1, m, n), dJ.reshape(-1, m, n)
    rates = np.empty((len(stack), len(chosen)))
    block = max(1, _BLOCK // max(terms.shape[1], 1))
    for i in range(0, len(stack), block):
        rates[i : i + block] = order * _expanded_rates(stack[i : i + block], d_stack[i : i + block], terms)
    return rates.reshape(*J.shape[:-2], len(chosen))


def border_distance(minors: Array, scales: Array) -> Array:
    """Return min_i |δ_i| / scale_i: how far the nearest border of the aspect is, as a part of its minor's own scale.

    Args:
        minors: Minors δ_i, shape (..., p).
        scales: Magnitude that each minor is compared with, shape (p,), such as `Arm.minor_scales`.

    Returns:
        The distance, shape (...), dimensionless: 0 on a border; infinite if there are no minors.
    """
    distance: Array = (np.abs(minors) / scales).min(axis=-1, initial=np.inf)
    return distance


def time_to_border(minors: Array, rates: Array) -> Array:
    """Return the least of −δ_i / δ̇_i over the minors that shrink: when the nearest border is reached at this rate.

    Args:
        minors: Minors δ_i, shape (..., p).
        rates: Their rates δ̇_i, shape (..., p), per s.

    Returns:
        The time, shape (...), s: 0 on a border, infinite where every minor grows or stands still. To first order: it
        takes the present rates as if they lasted.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        times = -minors / rates
    times = np.where(minors == 0.0, 0.0, np.where(times > 0.0, times, np.inf))
    nearest: Array = times.min(axis=-1, initial=np.inf)
    return nearest


def aspect_signature(J: Array, columns: NDArray[np.intp] | None = None) -> NDArray[np.int8]:
    """Return the sign of every minor: two configurations joined by a path of one signature share an aspect.

    A minor that is zero to the rounding of J counts as zero; see `border_tolerance`.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        columns: Columns of the minors to look at, shape (p, m); None for all.

    Returns:
        −1, 0 (on a border) or 1 for each minor, shape (..., p).
    """
    return minor_signs(minors(J, columns), border_tolerance(J))


def minor_signs(values: Array, tolerance: Array) -> NDArray[np.int8]:
    """Return the signs of minors: −1, 0 (on a border) or 1, shape (..., p).

    Args:
        values: The minors, shape (..., p).
        tolerance: The magnitude up to which they count as zero, shape (...); see `border_tolerance`.
    """
    on_border = np.abs(values) <= tolerance[..., np.newaxis]
    return np.where(on_border, 0.0, np.sign(values)).astype(np.int8)


def border_tolerance(J: Array) -> Array:
    """Return the magnitude up to which a minor of J is zero for all that its rounding tells.

    By Hadamard's inequality no minor exceeds the m-th power of the longest column of J; a minor below 8 m machine
    precisions of that bound has no sign of its own.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).

    Returns:
        The tolerance, shape (...), in the unit of the minors.
    """
    m = J.shape[-2]
    longest = np.linalg.norm(J, axis=-2).max(axis=-1)
    tolerance: Array = BORDER * m * longest**m
    return tolerance


def manipulability(J: Array) -> Array:
    """Return w = √det(J Jᵀ), Eq. (25), as the product of the singular values of J.

    By the Cauchy-Binet theorem w² is the sum of the squares of all minors.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n) with m ≤ n.

    Returns:
        w, shape (...), in the unit of the minors.
    """
    result: Array = np.linalg.svd(J, compute_uv=False).prod(axis=-1)
    return result


def minor_measure(J: Array, columns: NDArray[np.intp] | None = None) -> Array:
    """Return H = |δ₁ δ₂ … δ_p|^(1/p), Eq. (18): the geometric mean of the minors' magnitudes.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        columns: Columns of the minors that H is made of, shape (p, m); None for all.

    Returns:
        H, shape (...), in the unit of the minors; zero on the border of an aspect.
    """
    return geometric_mean(minors(J, columns))


def geometric_mean(values: Array) -> Array:
    """Return |δ₁ δ₂ … δ_p|^(1/p) of minors, shape (...), in their unit: the minor measure of Eq. (18).

    Args:
        values: The minors δ_i, shape (..., p).
    """
    with np.errstate(divide="ignore"):
        logarithms = np.log(np.abs(values))
    measure: Array = np.exp(logarithms.mean(axis=-1))
    return measure


def _expanded_rates(J: Array, dJ: Array, terms: Table) -> Array:
    """Return the rates of minors whose columns stand in increasing order, from the terms of `laplace_expansion`."""
    k = len(J)
    delta, rates = np.ones((k, 1)), np.zeros((k, 1))
    for row in range(J.shape[1]):
        _, column, smaller, _, sign = terms[:, terms[0] == row]
        entries, d_entries = sign * J[:, row, column], sign * dJ[:, row, column]
        # A minor of row + 1 rows has as many terms, one after the other.
        of_terms = d_entries * delta[:, smaller] + entries * rates[:, smaller]
        delta = (entries * delta[:, smaller]).reshape(k, -1, row + 1).sum(axis=-1)
        rates = of_terms.reshape(k, -1, row + 1).sum(axis=-1)
    return rates


def _order_signs(columns: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return 1 for each minor whose columns an even number of exchanges sorts, and −1 for the others, shape (p,)."""
    later = np.triu(columns[:, :, np.newaxis] > columns[:, np.newaxis, :], k=1)
    return 1 - 2 * (later.sum(axis=(1, 2)) % 2)


def _submatrices(J: Array, columns: NDArray[np.intp]) -> Array:
    return np.moveaxis(J[..., columns], -2, -3)
