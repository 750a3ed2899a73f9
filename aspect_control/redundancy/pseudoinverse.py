"""The pseudoinverse of a Jacobian and the null space that it leaves."""

from __future__ import annotations

import eigenpy
import numpy as np

from .array import Array

RANK_TOLERANCE = 1e-12
"""Relative size below which a direction counts as lost: well above the rounding of a Jacobian, far below any use."""


def pseudoinverse(A: Array) -> Array:
    """Return the Moore-Penrose inverse A⁺, Eq. (26) where A has full row rank.

    By a complete orthogonal decomposition, which also covers rank loss: directions whose pivot is below
    `RANK_TOLERANCE` times the largest one are left out, so that the result stays bounded.

    Args:
        A: Matrix, shape (m, n).

    Returns:
        A⁺, shape (n, m), in the inverse units of A.
    """
    decomposition = eigenpy.CompleteOrthogonalDecomposition(*A.shape)
    decomposition.setThreshold(RANK_TOLERANCE)
    decomposition.compute(A)
    # eigenpy hands a matrix of one row or column back as a vector.
    result: Array = decomposition.pseudoInverse().reshape(A.shape[::-1])
    return result


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
