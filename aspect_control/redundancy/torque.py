"""Joint torques that give one and the same task acceleration."""

from __future__ import annotations

import numpy as np

from .array import Array
from .cholesky import cholesky_solve, forward_substitution
from .compiled import MATRIX, VECTOR, compiled
from .products import times
from .pseudoinverse import pseudoinverse


@compiled(MATRIX, VECTOR, MATRIX, VECTOR)
def pseudoinverse_torque(M: Array, nle: Array, J: Array, b: Array) -> Array:
    """Return τ̃ = M J⁺ b + N, Eq. (7): the torque of the minimum-norm joint acceleration.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ̃, shape (n,), N m.
    """
    return times(M, times(pseudoinverse(J), b)) + nle


@compiled(MATRIX, VECTOR, MATRIX, VECTOR)
def minimum_torque(M: Array, nle: Array, J: Array, b: Array) -> Array:
    """Return the torque of least norm that gives the task acceleration: Eq. (11) without a projector.

    The torques that give it are the solutions of A τ = b + A N with A = J M⁻¹; the shortest one is
    τ = A⁺(b + A N). It equals τ̃ − M[M(I − J⁺J)]⁺τ̃ and takes one m × m factorisation instead of two
    n × n singular value decompositions.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ, shape (n,), N m.
    """
    A = cholesky_solve(np.linalg.cholesky(M), J)
    return times(pseudoinverse(A), b + times(A, nle))


@compiled(MATRIX, VECTOR, MATRIX, VECTOR)
def inertia_weighted_torque(M: Array, nle: Array, J: Array, b: Array) -> Array:
    """Return τ = Jᵀ(J M⁻¹Jᵀ)⁺b + N: the torque of the least θ̈ᵀMθ̈ that gives the task acceleration.

    With M = L Lᵀ and W = J L⁻ᵀ, in whose coordinates that is the plain norm, it is L W⁺b + N.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ, shape (n,), N m.
    """
    L = np.linalg.cholesky(M)
    W = forward_substitution(L, J)
    return times(L, times(pseudoinverse(W), b)) + nle


@compiled(MATRIX, MATRIX, VECTOR)
def dynamically_consistent_null_torque(M: Array, J: Array, tau: Array) -> Array:
    """Return (I − JᵀJ̄ᵀ)τ with J̄ = M⁻¹Jᵀ(J M⁻¹Jᵀ)⁺: the part of a torque that does not accelerate the task.

    With M = L Lᵀ and W = J L⁻ᵀ it is L(I − W⁺W)L⁻¹τ.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        J: Jacobian, shape (m, n).
        tau: Joint torque, shape (n,), N m.

    Returns:
        The null-space torque, shape (n,), N m.
    """
    L = np.linalg.cholesky(M)
    W = forward_substitution(L, J)
    y = forward_substitution(L, tau.reshape(1, -1))[0]
    return tau - times(L, times(pseudoinverse(W), times(W, y)))


@compiled(MATRIX, VECTOR, MATRIX, VECTOR)
def task_acceleration(M: Array, nle: Array, J: Array, tau: Array) -> Array:
    """Return b = J M⁻¹(τ − N): the task acceleration, less J̇θ̇, that a torque brings about.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        tau: Joint torque, shape (n,), N m.

    Returns:
        b = ẍ − J̇θ̇, shape (m,).
    """
    force = (tau - nle).reshape(1, -1)
    return times(J, cholesky_solve(np.linalg.cholesky(M), force)[0])
