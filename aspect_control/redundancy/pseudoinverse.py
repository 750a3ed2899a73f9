"""The pseudoinverse of a Jacobian and the null space that it leaves."""

from __future__ import annotations

import numpy as np

from .array import Array
from .cholesky import cholesky, cholesky_inverse
from .compiled import MATRIX, VECTOR, compiled
from .products import product_with_transpose

RANK_TOLERANCE = 1e-12
"""Relative size below which a direction counts as lost: well above the rounding of a Jacobian, far below any use."""

WELL_CONDITIONED = 1e9
"""Largest ‖A‖²‖A⁺‖², by the Frobenius norm, up to which one refinement makes Eq. (26) exact to the rounding of A."""

_EPSILON = float(np.finfo(np.float64).eps)
_TINY = float(np.finfo(np.float64).tiny)


@compiled(MATRIX)
def _truncated(A: Array) -> Array:
    return np.ascontiguousarray(np.linalg.pinv(A, RANK_TOLERANCE))


@compiled(MATRIX, MATRIX)
def least_norm(A: Array, B: Array) -> Array:
    """Return X with the rows x = A⁺b: the shortest x with A x = b, for every row b of B.

    Eq. (26) as it stands, A⁺ = Aᵀ(A Aᵀ)⁻¹, squares the condition number of A. One refinement by what is missing,
    x + A⁺(b − A x), squares the error that is left, and x is exact to the rounding of A itself: a step of the
    Newton-Schulz iteration. It is good for condition numbers up to about 10⁴, which the inverse of A Aᵀ tells.
    Elsewhere, at and around the loss of rank, A⁺ comes from the singular values: those below `RANK_TOLERANCE` times
    the largest one are left out, so that the result stays bounded.

    Args:
        A: Matrix, shape (m, n).
        B: Right-hand sides, one a row, shape (k, m).

    Returns:
        X, shape (k, n).

    Raises:
        numpy.linalg.LinAlgError: If A is not finite.
    """
    if B.shape[1] != len(A):
        raise ValueError("the shapes of a linear system do not fit")
    gram = product_with_transpose(A, A)
    size = np.trace(gram)
    # Rounding cannot make this one indefinite, and its inverse is as good a start of the refinement.
    shift = 8.0 * len(A) * _EPSILON * size + _TINY
    for i in range(len(A)):
        gram[i, i] += shift
    inverse = cholesky_inverse(cholesky(gram))
    if not size * np.trace(inverse) <= WELL_CONDITIONED:
        return product_with_transpose(B, _truncated(A))
    X = np.zeros((len(B), A.shape[1]))
    _add_product(B, inverse, A, X)
    missing = product_with_transpose(X, A)
    np.subtract(B, missing, missing)
    _add_product(missing, inverse, A, X)
    return X


@compiled(MATRIX, MATRIX, MATRIX, MATRIX)
def _add_product(B: Array, C: Array, A: Array, X: Array) -> None:
    """Add B C A to X, without room for what is in between; C is symmetric."""
    for row in range(len(B)):
        for i in range(len(A)):
            entry = 0.0
            for j in range(len(A)):
                entry += B[row, j] * C[i, j]
            for k in range(A.shape[1]):
                X[row, k] += entry * A[i, k]


@compiled(MATRIX, VECTOR)
def least_norm_solution(A: Array, b: Array) -> Array:
    """Return x = A⁺b, shape (n,), of A (m, n) and b (m,); see `least_norm`."""
    return least_norm(A, b.reshape(1, -1))[0]


@compiled(MATRIX)
def pseudoinverse(A: Array) -> Array:
    """Return the Moore-Penrose inverse A⁺, Eq. (26) where A has full row rank; see `least_norm`.

    Args:
        A: Matrix, shape (m, n).

    Returns:
        A⁺, shape (n, m), in the inverse units of A.

    Raises:
        numpy.linalg.LinAlgError: If A is not finite.
    """
    if A.shape[0] > A.shape[1]:
        return least_norm(np.ascontiguousarray(A.T), np.eye(A.shape[1]))
    return np.ascontiguousarray(least_norm(A, np.eye(A.shape[0])).T)


def null_space_projector(J: Array) -> Array:
    """Return P = I − J⁺J, the orthogonal projector onto the null space of J; see Eq. (2).

    Args:
        J: Jacobian, shape (m, n).

    Returns:
        P, shape (n, n), symmetric and idempotent, dimensionless.
    """
    return np.eye(J.shape[1]) - pseudoinverse(J) @ J


def null_space_basis(J: Array) -> Array:
    """Return Z, an orthonormal basis of the null space of J, from its singular value decomposition.

    Args:
        J: Jacobian, shape (m, n).

    Returns:
        Z, shape (n, n − rank J), with J Z = 0 and ZᵀZ = I. Neither its signs nor, for more than one column, its
        rotation within the null space are continuous in J.
    """
    _, singular_values, Vt = np.linalg.svd(J)
    rank = int(np.count_nonzero(singular_values > RANK_TOLERANCE * singular_values.max(initial=0.0)))
    basis: Array = Vt[rank:].T
    return basis
