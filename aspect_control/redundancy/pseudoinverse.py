"""The pseudoinverse of a Jacobian and the null space that it leaves."""

from __future__ import annotations

import numpy as np

from .array import Array
from .cholesky import cholesky, cholesky_solve
from .compiled import MATRIX, compiled
from .products import product, product_with_transpose, transpose_times

RANK_TOLERANCE = 1e-12
"""Relative size below which a direction counts as lost: well above the rounding of a Jacobian, far below any use."""

CONVERGENT = 1e-5
"""Largest entry of I − A X up to which one Newton-Schulz step makes X the pseudoinverse to rounding."""

_EPSILON = float(np.finfo(np.float64).eps)
_TINY = float(np.finfo(np.float64).tiny)


@compiled(MATRIX)
def _truncated(A: Array) -> Array:
    return np.ascontiguousarray(np.linalg.pinv(A, RANK_TOLERANCE))


@compiled(MATRIX)
def _of_wide(A: Array) -> Array:
    m = A.shape[0]
    gram = product_with_transpose(A, A)
    # Rounding cannot make this one indefinite, and its inverse is as good a start of the iteration.
    shift = 8.0 * m * _EPSILON * np.trace(gram) + _TINY
    for i in range(m):
        gram[i, i] += shift
    X = transpose_times(A, cholesky_solve(cholesky(gram), np.eye(m)))
    E = product(A, X)
    largest = 0.0
    for i in range(m):
        for j in range(m):
            E[i, j] = (1.0 if i == j else 0.0) - E[i, j]
            largest = max(largest, abs(E[i, j]))
    if largest <= CONVERGENT:
        X += product(X, E)
        return X
    return _truncated(A)


@compiled(MATRIX)
def pseudoinverse(A: Array) -> Array:
    """Return the Moore-Penrose inverse A⁺, Eq. (26) where A has full row rank.

    Eq. (26) as it stands, X = Aᵀ(A Aᵀ)⁻¹, squares the condition number of A. One step of the Newton-Schulz iteration,
    X + X(I − A X), squares what is left of I − A X, and A⁺ is exact to the rounding of A itself. I − A X is known, so
    that the step is taken only where it converges, up to condition numbers of about 10⁴. Elsewhere, at and around
    the loss of rank, A⁺ comes from the singular values: those below `RANK_TOLERANCE` times the largest one are left
    out, so that the result stays bounded.

    Args:
        A: Matrix, shape (m, n).

    Returns:
        A⁺, shape (n, m), in the inverse units of A.

    Raises:
        numpy.linalg.LinAlgError: If A is not finite.
    """
    if A.shape[0] > A.shape[1]:
        return np.ascontiguousarray(_of_wide(np.ascontiguousarray(A.T)).T)
    return _of_wide(A)


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
