"""Gradients of the minor measure and of the manipulability with respect to the joint coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .array import Array, Matrix, Table, Tensor, Vector
from .generalized_inverse import pseudoinverse
from .kernels import kernel
from .laplace import laplace_expansion
from .minors import BORDER, minor_columns


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
    gradient: Array = expanded_gradient(J, dJ, laplace_expansion(chosen))
    return gradient


@kernel
def expanded_gradient(J: Matrix, dJ: Tensor, terms: Table) -> Vector:
    """Return ∇H of `minor_measure_gradient` from the terms of the expansion.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).
        terms: What `laplace_expansion` returns for the columns of the minors.

    Returns:
        ∇H, shape (n,).
    """
    m, n = J.shape
    if terms.shape[1] == 0:
        return np.zeros(n)
    ends = np.searchsorted(terms[0], np.arange(m + 1))
    levels: list[Array] = [np.ones(1)]
    for k in range(m):
        of_row = terms[:, ends[k] : ends[k + 1]]
        column, smaller, minor, sign = of_row[1], of_row[2], of_row[3], of_row[4]
        levels.append(np.bincount(minor, sign * J[k][column] * levels[k][smaller]))
    delta = levels[m]
    size = np.abs(delta)
    if size.min() <= BORDER * m * np.sqrt((J * J).sum(axis=0).max()) ** m:
        return np.zeros(n)
    # Backwards: the slope of Σ ln|δ| in the minors of fewer and fewer rows, and with each row its slope in J.
    total, slope = np.zeros((m, n)), 1.0 / delta
    for k in range(m - 1, -1, -1):
        of_row = terms[:, ends[k] : ends[k + 1]]
        column, smaller, minor, sign = of_row[1], of_row[2], of_row[3], of_row[4]
        of_term = sign * slope[minor]
        total[k] = np.bincount(column, of_term * levels[k][smaller], n)
        if k > 0:
            slope = np.bincount(smaller, of_term * J[k][column])
    measure = np.exp(np.log(size).sum() / len(size))
    return measure / len(size) * contracted(total, dJ)


@kernel
def manipulability_gradient(J: Matrix, dJ: Tensor) -> Vector:
    """Return ∇w, the gradient of the manipulability of Eq. (25) with respect to the joint coordinates.

    ∂w/∂q_k = w tr(J⁺ ∂J/∂q_k); zero where J has lost rank, where w has a cusp.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).

    Returns:
        ∇w, shape (n,), in the unit of w per rad (per m for a prismatic joint).
    """
    return np.prod(np.linalg.svd(J)[1]) * contracted(pseudoinverse(J).T, dJ)


@kernel
def contracted(slope: Matrix, dJ: Tensor) -> Vector:
    """Return Σ_ij slope[i, j] ∂J[i, j]/∂q_k: the gradient of a function of J by its slope in the entries of J.

    Args:
        slope: Shape (m, n).
        dJ: Derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).

    Returns:
        Shape (n,).
    """
    return slope.copy().reshape(-1) @ dJ.reshape(-1, dJ.shape[2])
