"""Symmetric positive definite systems, by substitution in their Cholesky factor L."""

from __future__ import annotations

import numpy as np

from .array import Array
from .compiled import MATRIX, compiled


@compiled(MATRIX)
def cholesky(M: Array) -> Array:
    """Return L, lower triangular with L Lᵀ = M, by LAPACK.

    Args:
        M: Symmetric positive definite matrix, shape (n, n).

    Returns:
        L, shape (n, n).

    Raises:
        numpy.linalg.LinAlgError: If M is not positive definite, or not finite.
    """
    return np.linalg.cholesky(M)


@compiled(MATRIX, MATRIX)
def forward_substitution(L: Array, B: Array) -> Array:
    """Return X with X Lᵀ = B.

    Args:
        L: Lower triangular matrix, shape (n, n).
        B: Right-hand sides, one a row, shape (k, n).

    Returns:
        X, shape (k, n).
    """
    if L.shape[0] != B.shape[1]:
        raise ValueError("the shapes of a linear system do not fit")
    X = B.copy()
    for x in X:
        for i in range(len(x)):
            for j in range(i):
                x[i] -= L[i, j] * x[j]
            x[i] /= L[i, i]
    return X


@compiled(MATRIX, MATRIX)
def backward_substitution(L: Array, B: Array) -> Array:
    """Return X with X L = B.

    Args:
        L: Lower triangular matrix, shape (n, n).
        B: Right-hand sides, one a row, shape (k, n).

    Returns:
        X, shape (k, n).
    """
    if L.shape[0] != B.shape[1]:
        raise ValueError("the shapes of a linear system do not fit")
    X = B.copy()
    for x in X:
        for i in range(len(x) - 1, -1, -1):
            x[i] /= L[i, i]
            for j in range(i):
                x[j] -= L[i, j] * x[i]
    return X


@compiled(MATRIX, MATRIX)
def cholesky_solve(L: Array, B: Array) -> Array:
    """Return X = B (L Lᵀ)⁻¹.

    Args:
        L: Lower triangular matrix, shape (n, n).
        B: Right-hand sides, one a row, shape (k, n).

    Returns:
        X, shape (k, n).
    """
    return backward_substitution(L, forward_substitution(L, B))
