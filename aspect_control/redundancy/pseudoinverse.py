"""The pseudoinverse of a Jacobian and the null space that it leaves."""

from __future__ import annotations

import eigenpy
import numpy as np

from .array import Array


def pseudoinverse(A: Array) -> Array:
    """Return the Moore-Penrose inverse A⁺, Eq. (26) where A has full row rank.

    By a complete orthogonal decomposition, which also covers rank loss: directions below the decomposition's
    threshold (machine precision times the larger pivot) are left out, so that the result stays finite.

    Args:
        A: Matrix, shape (m, n).

    Returns:
        A⁺, shape (n, m), in the inverse units of A.
    """
    result: Array = eigenpy.CompleteOrthogonalDecomposition(A).pseudoInverse()
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
    threshold = max(J.shape) * np.finfo(np.float64).eps * singular_values.max(initial=0.0)
    rank = int(np.count_nonzero(singular_values > threshold))
    basis: Array = Vt[rank:].T
    return basis
