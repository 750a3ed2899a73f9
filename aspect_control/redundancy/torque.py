"""Joint torques that give one and the same task acceleration."""

from __future__ import annotations

import numpy as np

from .array import Matrix, Vector
from .generalized_inverse import least_norm_solution
from .kernels import kernel


@kernel
def pseudoinverse_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector) -> Vector:
    """Return τ̃ = M J⁺ b + N, Eq. (7): the torque of the minimum-norm joint acceleration.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ̃, shape (n,), N m.
    """
    return M @ least_norm_solution(J, b) + nle


@kernel
def minimum_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector) -> Vector:
    """Return the torque of least norm that gives the task acceleration: Eq. (11) without a projector.

    The torques that give it are the solutions of A τ = b + A N with A = J M⁻¹; the shortest one is
    τ = A⁺(b + A N). It equals τ̃ − M[M(I − J⁺J)]⁺τ̃ without the n × n projector and its pseudoinverse.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ, shape (n,), N m.
    """
    A = np.linalg.solve(M, J.T).T
    return least_norm_solution(A, b + A @ nle)


@kernel
def inertia_weighted_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector) -> Vector:
    """Return τ = JᵀΛb + N with Λ = (J M⁻¹Jᵀ)⁺: the torque of the least θ̈ᵀMθ̈ that gives the task acceleration.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        τ, shape (n,), N m.
    """
    A = np.linalg.solve(M, J.T).T
    return J.T @ least_norm_solution(A @ J.T, b) + nle


@kernel
def operational_space_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector, tau_0: Vector) -> Vector:
    """Return JᵀΛb + N + (I − JᵀJ̄ᵀ)τ₀ with Λ = (J M⁻¹Jᵀ)⁺ and J̄ = M⁻¹JᵀΛ: a null-space torque besides the task's.

    τ₀ brings about no task acceleration: the sum is JᵀΛ(b − J M⁻¹τ₀) + τ₀ + N.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).
        tau_0: Joint torque τ₀, shape (n,), N m.

    Returns:
        τ, shape (n,), N m.
    """
    A = np.linalg.solve(M, J.T).T
    return J.T @ least_norm_solution(A @ J.T, b - A @ tau_0) + tau_0 + nle


@kernel
def damped_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, damping: float) -> Vector:
    """Return τ̃ − D M θ̇_H, Eqs. (7) and (15): with θ̇_H = θ̇ − J⁺Jθ̇ it is M{J⁺(b + D Jθ̇) − D θ̇} + N.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).
        v: Joint velocity θ̇, shape (n,), rad/s.
        damping: D, 1/s.

    Returns:
        τ, shape (n,), N m.
    """
    return M @ (least_norm_solution(J, b + damping * (J @ v)) - damping * v) + nle


@kernel
def task_acceleration(M: Matrix, nle: Vector, J: Matrix, tau: Vector) -> Vector:
    """Return b = J M⁻¹(τ − N): the task acceleration, less J̇θ̇, that a torque brings about.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        tau: Joint torque, shape (n,), N m.

    Returns:
        b = ẍ − J̇θ̇, shape (m,).
    """
    return J @ np.linalg.solve(M, tau - nle)
