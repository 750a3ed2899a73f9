"""Minima of ½ xᵀ diag(p) x + qᵀx subject to lower ≤ A x ≤ upper: on bounds that are known, and how they are told."""

from __future__ import annotations

import numpy as np

from .array import Array
from .compiled import MATRIX, VECTOR, compiled
from .products import product, times, transpose_times
from .pseudoinverse import pseudoinverse

PROGRAM = (VECTOR, VECTOR, MATRIX, VECTOR, VECTOR)
"""Arguments of a program: p, above zero, q, A, lower, upper."""

ROUNDING = 1e-9
"""By how much the minimum on bounds that are known may miss another one: part of its size, plus 1e-9."""

_SIGN_KNOWN = 1e-11
"""Part of the largest multiplier below which the sign of another is not known."""

_SUM_KNOWN = 1e-8
"""Largest sum of the gradient and the multipliers, as part of the gradient of the quadratic cost."""

_LEAST_MULTIPLIER = 1e-9
"""Part of the largest multiplier from which on a bound counts as held."""


@compiled(*PROGRAM, VECTOR)
def minimum_on_bounds(p: Array, q: Array, A: Array, lower: Array, upper: Array, side: Array) -> tuple[Array, Array]:
    """Return the x of least ½ xᵀ diag(p) x + qᵀx for which A x is at some bounds, and the multipliers.

    With y = diag(√p) x and W = A diag(1/√p) it is the point nearest to −diag(1/√p) q: the one plus W⁺ times what is
    missing to the bounds.

    Args:
        p: Diagonal of the cost matrix, shape (k,), above zero.
        q: Linear cost, shape (k,).
        A: Rows of the inequalities, shape (c, k).
        lower: Lower bounds, shape (c,).
        upper: Upper bounds, shape (c,).
        side: Positive where the upper bound is held, negative where the lower, zero where none, shape (c,).

    Returns:
        x, shape (k,), and the multipliers μ with diag(p) x + q + Aᵀμ = 0, shape (c,), zero where nothing is held.
    """
    root, multipliers = np.sqrt(p), np.zeros(len(A))
    nearest_to = -q / root
    held = np.flatnonzero(side)
    if len(held) == 0:
        return nearest_to / root, multipliers
    W = A[held] / root
    W_pinv = pseudoinverse(W)
    bounds = np.where(side > 0.0, upper, lower)[held]
    step = times(W_pinv, bounds - times(W, nearest_to))
    y = nearest_to + step
    held_multipliers = -transpose_times(W_pinv, step.reshape(-1, 1))[:, 0]
    # What rounding has left where the linear cost is large.
    y += times(W_pinv, bounds - times(W, y))
    left = y - nearest_to + transpose_times(W, held_multipliers.reshape(-1, 1))[:, 0]
    multipliers[held] = held_multipliers - transpose_times(W_pinv, left.reshape(-1, 1))[:, 0]
    return y / root, multipliers


@compiled(*PROGRAM, VECTOR, VECTOR)
def violations(
    p: Array, q: Array, A: Array, lower: Array, upper: Array, x: Array, mu: Array
) -> tuple[float, float, float]:
    """Return by how much x and μ miss the bounds, the stationarity and the duality, each as part of its size.

    Args:
        p: As for `minimum_on_bounds`; zero too.
        q: As for `minimum_on_bounds`.
        A: As for `minimum_on_bounds`.
        lower: As for `minimum_on_bounds`.
        upper: As for `minimum_on_bounds`.
        x: The point, shape (k,).
        mu: The multipliers, shape (c,): positive at the upper bound, negative at the lower.

    Returns:
        The largest excess over a bound, the largest entry of diag(p) x + q + Aᵀμ, and Σ|μ| times the distance from the
        bound that the sign of μ is of, over the multipliers that are more than rounding.
    """
    excess, stationarity, gap, size, reach = 0.0, 0.0, 0.0, 1.0, 1.0
    gradient = p * x + q
    size += np.max(np.abs(p * x)) + np.max(np.abs(q))
    reach += np.max(np.abs(x))
    values = times(A, x)
    for i in range(len(values)):
        nearest = min(max(values[i], lower[i]), upper[i])
        excess = max(excess, abs(values[i] - nearest) / (1.0 + abs(nearest)))
        gradient += mu[i] * A[i]
        if abs(mu[i]) > 1e-6 * size:
            gap += abs(mu[i] * (values[i] - (upper[i] if mu[i] > 0.0 else lower[i])))
    stationarity = np.max(np.abs(gradient)) / size
    return excess, stationarity, gap / (size * reach)


@compiled(*PROGRAM, VECTOR)
def minimum_known(
    p: Array, q: Array, A: Array, lower: Array, upper: Array, multipliers: Array
) -> tuple[bool, Array, Array]:
    """Return whether the minimum is free of bounds or on those of some multipliers, the minimum and its multipliers.

    The cost is strictly convex: a point within the bounds, with the multipliers of those that are held pointing
    outwards, is the only minimum. This is the warm start of an active-set method, without its iterations.

    Args:
        p: As for `minimum_on_bounds`.
        q: As for `minimum_on_bounds`.
        A: As for `minimum_on_bounds`.
        lower: As for `minimum_on_bounds`.
        upper: As for `minimum_on_bounds`.
        multipliers: Multipliers of a program with as many rows, of the sample before, shape (c,).

    Returns:
        Whether it is, x, shape (k,), and μ, shape (c,).
    """
    free = np.zeros(len(A))
    x, mu = minimum_on_bounds(p, q, A, lower, upper, free)
    if _is_within(times(A, x), lower, upper):
        return True, x, mu
    largest = np.max(np.abs(multipliers))
    if largest == 0.0:
        return False, x, mu
    side = np.where(np.abs(multipliers) > _LEAST_MULTIPLIER * largest, multipliers, 0.0)
    x, mu = minimum_on_bounds(p, q, A, lower, upper, side)
    # Signs and sums that are lost in rounding, as with a large linear cost, tell nothing.
    outwards = np.all(mu * np.sign(side) >= _SIGN_KNOWN * np.max(np.abs(mu)) * np.abs(np.sign(side)))
    gradient = p * x + q + transpose_times(A, mu.reshape(-1, 1))[:, 0]
    stationary = np.max(np.abs(gradient)) <= _SUM_KNOWN * (1.0 + np.max(np.abs(p * x)))
    return outwards and stationary and _is_within(times(A, x), lower, upper), x, mu


@compiled(VECTOR, VECTOR, VECTOR)
def _is_within(values: Array, lower: Array, upper: Array) -> bool:
    for i in range(len(values)):
        lowest, highest = lower[i] - ROUNDING * (1.0 + abs(lower[i])), upper[i] + ROUNDING * (1.0 + abs(upper[i]))
        if not lowest <= values[i] <= highest:
            return False
    return True


@compiled(*PROGRAM)
def evened(
    p: Array, q: Array, A: Array, lower: Array, upper: Array
) -> tuple[Array, Array, Array, Array, Array, Array, Array, float]:
    """Return the program in coordinates u, x = R u, in which the bounds are about equally far apart in all directions.

    With w the half widths of the bounds, diag(1/w) A R has orthonormal columns.

    Args:
        p: As for `minimum_on_bounds`.
        q: As for `minimum_on_bounds`.
        A: As for `minimum_on_bounds`.
        lower: As for `minimum_on_bounds`.
        upper: As for `minimum_on_bounds`.

    Returns:
        The cost matrix, shape (k, k), and q, shape (k,), both divided by a size; A, lower and upper, divided by w; R,
        shape (k, k); w, shape (c,); and the size.
    """
    R, width = _coordinates(A, lower, upper)
    P = transpose_times(R, p.reshape(-1, 1) * R)
    q = transpose_times(R, q.reshape(-1, 1))[:, 0].copy()
    size = max(np.max(np.abs(P)), np.max(np.abs(q)))
    A = product(A, R) / width.reshape(-1, 1)
    return P / size, q / size, A, lower / width, upper / width, R, width, size


@compiled(MATRIX, VECTOR, VECTOR)
def _coordinates(A: Array, lower: Array, upper: Array) -> tuple[Array, Array]:
    two_sided = np.isfinite(lower) & np.isfinite(upper)
    if not two_sided.any():
        return np.eye(A.shape[1]), np.ones(len(A))
    below, above = lower[two_sided], upper[two_sided]
    half = np.maximum((above - below) / 2.0, 1e-6 * (1.0 + np.maximum(np.abs(above), np.abs(below))))
    width = np.full(len(A), np.median(half))
    width[two_sided] = half
    _, singular_values, Vt = np.linalg.svd(A / width.reshape(-1, 1), False)
    if len(singular_values) < A.shape[1]:
        return np.eye(A.shape[1]), width
    return np.ascontiguousarray(Vt.T) / np.maximum(singular_values, 1e-6 * singular_values[0]), width
