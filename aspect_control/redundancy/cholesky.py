"""Symmetric positive definite systems, by substitution in their Cholesky factor L."""

from __future__ import annotations

import numpy as np

from .array import Array
from .compiled import MATRIX, VECTOR, compiled


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
    X = B.copy()
    _substitute_forward(L, X)
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
    X = B.copy()
    cholesky_solve_in_place(L, X)
    return X


@compiled(MATRIX, MATRIX)
def cholesky_solve_in_place(L: Array, X: Array) -> None:
    """Turn X, shape (k, n), into X (L Lᵀ)⁻¹ with L (n, n)."""
    _substitute_forward(L, X)
    _substitute_backward(L, X)


@compiled(MATRIX, VECTOR)
def cholesky_solve_vector(L: Array, b: Array) -> Array:
    """Return x = (L Lᵀ)⁻¹b, shape (n,), of L (n, n) and b (n,)."""
    return cholesky_solve(L, b.reshape(1, -1))[0]


@compiled(MATRIX)
def cholesky_inverse(L: Array) -> Array:
    """Return (L Lᵀ)⁻¹, shape (n, n), of L (n, n)."""
    X = np.eye(len(L))
    cholesky_solve_in_place(L, X)
    return X


# One reciprocal for all right-hand sides, which are the inner loop: a division takes as long as several products.


@compiled(MATRIX, MATRIX)
def _substitute_forward(L: Array, X: Array) -> None:
    """Turn X into X L⁻ᵀ."""
    if L.shape[0] != X.shape[1]:
        raise ValueError("the shapes of a linear system do not fit")
    for i in range(X.shape[1]):
        reciprocal = 1.0 / L[i, i]
        for row in range(X.shape[0]):
            rest = X[row, i]
            for j in range(i):
                rest -= L[i, j] * X[row, j]
            X[row, i] = rest * reciprocal


@compiled(MATRIX, MATRIX)
def _substitute_backward(L: Array, X: Array) -> None:
    """Turn X into X L⁻¹."""
    for i in range(X.shape[1] - 1, -1, -1):
        reciprocal = 1.0 / L[i, i]
        for row in range(X.shape[0]):
            X[row, i] *= reciprocal
            for j in range(i):
                X[row, j] -= L[i, j] * X[row, i]
