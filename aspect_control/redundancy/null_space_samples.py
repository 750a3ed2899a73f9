"""The self-motion at many samples at once: Eqs. (7), (12), (15) and (16) for stacks of Jacobians.

With Z, whose rows span the null space of J, the part of a velocity that does not move the task is ZᵀZθ̇, and the torques
that move nothing but the null space are the combinations of the rows of W = ZM. Minimum torque, Eq. (11), is what is
left of a torque of the same task acceleration without its part along W.
"""

from __future__ import annotations

import numpy as np

from .array import Array, Matrix, Tensor
from .generalized_inverse import RANK_TOLERANCE


def null_space_rows(J: Tensor) -> Tensor:
    """Return orthonormal rows that span the null space of each Jacobian, from its singular value decomposition.

    Args:
        J: Jacobians, shape (k, m, n).

    Returns:
        Z, shape (k, r, n), with J Zᵀ = 0 and, at full rank, ZZᵀ = I; r is n less the least rank of all. A Jacobian of
        a higher rank has rows of zeros besides.
    """
    _, sigma, Vt = np.linalg.svd(J)
    lost = sigma <= RANK_TOLERANCE * sigma[:, :1]
    ranks = np.count_nonzero(~lost, axis=1)
    least = int(ranks.min(initial=min(J.shape[1:])))
    rows: Tensor = Vt[:, least:]
    if (ranks == least).all():
        return rows
    return rows * (np.arange(least, J.shape[2]) >= ranks[:, np.newaxis])[..., np.newaxis]


def null_space_part(Z: Tensor, values: Matrix) -> Matrix:
    """Return ZᵀZ x, the part of each vector in the null space of its Jacobian: θ̇_H of Eq. (15) for θ̇.

    Args:
        Z: `null_space_rows` of the Jacobians, shape (k, r, n).
        values: Vectors x, shape (k, n).

    Returns:
        Shape (k, n), in the unit of `values`.
    """
    return _combined(Z, _along(Z, values))


def maciejewski_product(Z: Tensor, M: Tensor, v: Matrix, tau: Matrix, acceleration: Matrix) -> Array:
    """Return θ̇_H·θ̈_H of Eq. (12), θ̈_H being what minimum torque of the same task acceleration adds to Eq. (7).

    With W = ZM it is (Zθ̇)·{Zθ̈ − (WWᵀ)⁻¹Wτ}: of τ minimum torque leaves τ − Wᵀ(WWᵀ)⁻¹Wτ, and Eq. (7) τ − WᵀZθ̈.

    Args:
        Z: `null_space_rows` of the Jacobians, shape (k, r, n).
        M: Joint-space inertia matrices, shape (k, n, n), kg m².
        v: Joint velocities θ̇, shape (k, n), rad/s.
        tau: Joint torques τ, shape (k, n), N m.
        acceleration: Joint accelerations θ̈ = M⁻¹(τ − N), shape (k, n), rad/s².

    Returns:
        The products, shape (k,), rad²/s³.
    """
    W = Z @ M
    gram = W @ W.swapaxes(1, 2)
    diagonal = np.einsum("kii->ki", gram)
    diagonal[diagonal == 0.0] = 1.0  # rows of zeros, which have nothing to take away
    least = np.linalg.solve(gram, _along(W, tau)[..., np.newaxis])[..., 0]
    product: Array = np.einsum("kr,kr->k", _along(Z, v), _along(Z, acceleration) - least)
    return product


def _along(Z: Tensor, values: Matrix) -> Matrix:
    return np.einsum("krn,kn->kr", Z, values)


def _combined(Z: Tensor, parts: Matrix) -> Matrix:
    return np.einsum("krn,kr->kn", Z, parts)
