"""Joint torques that give one and the same task acceleration."""

from __future__ import annotations

import eigenpy

from .array import Array
from .pseudoinverse import pseudoinverse


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
    tau: Array = M @ (pseudoinverse(J) @ b) + nle
    return tau


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
    A = _torque_to_task(M, J)
    tau: Array = pseudoinverse(A) @ (b + A @ nle)
    return tau


def inertia_weighted_torque(M: Array, nle: Array, J: Array, b: Array) -> Array:
    """Return τ = Jᵀ(J M⁻¹Jᵀ)⁺b + N: the torque of the least θ̈ᵀMθ̈ that gives the task acceleration.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ, shape (n,), N m.
    """
    A = _torque_to_task(M, J)
    tau: Array = J.T @ (pseudoinverse(A @ J.T) @ b) + nle
    return tau


def dynamically_consistent_null_torque(M: Array, J: Array, tau: Array) -> Array:
    """Return (I − JᵀJ̄ᵀ)τ with J̄ = M⁻¹Jᵀ(J M⁻¹Jᵀ)⁺: the part of a torque that does not accelerate the task.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        J: Jacobian, shape (m, n).
        tau: Joint torque, shape (n,), N m.

    Returns:
        The null-space torque, shape (n,), N m.
    """
    A = _torque_to_task(M, J)
    null_torque: Array = tau - J.T @ (pseudoinverse(A @ J.T) @ (A @ tau))
    return null_torque


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
    b: Array = J @ eigenpy.LLT(M).solve(tau - nle)
    return b


def _torque_to_task(M: Array, J: Array) -> Array:
    """Return A = J M⁻¹, shape (m, n); eigenpy hands a single column back as a vector."""
    return eigenpy.LLT(M).solve(J.T).reshape(J.T.shape).T  # type: ignore[no-any-return]
