"""The pseudoinverse of a Jacobian and the null space that it leaves."""

from __future__ import annotations

import numpy as np

from .array import Array, Matrix, Vector
from .kernels import kernel

RANK_TOLERANCE = 1e-12
"""Relative size below which a direction counts as lost: well above the rounding of a Jacobian, far below any use."""


@kernel
def least_norm_solution(A: Matrix, b: Vector) -> Vector:
    """Return x = A⁺b: the shortest of all x that bring A x nearest to b.

    By the singular values of A, so that its condition number is not squared as in Eq. (26), A⁺ = Aᵀ(A Aᵀ)⁻¹. Those
    below `RANK_TOLERANCE` times the largest one are left out: x stays bounded at and around the loss of rank.

    Args:
        A: Matrix, shape (m, n).
        b: Right-hand side, shape (m,).

    Returns:
        x, shape (n,).
    """
    return np.linalg.lstsq(A, b, RANK_TOLERANCE)[0]


@kernel
def pseudoinverse(A: Matrix) -> Matrix:
    """Return the Moore-Penrose inverse A⁺, Eq. (26) where A has full row rank.

    Singular values below `RANK_TOLERANCE` times the largest one are left out.

    Args:
        A: Matrix, shape (m, n).

    Returns:
        A⁺, shape (n, m), in the inverse units of A.

    Raises:
        numpy.linalg.LinAlgError: If A is not finite.
    """
    return np.linalg.pinv(A, RANK_TOLERANCE)


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
