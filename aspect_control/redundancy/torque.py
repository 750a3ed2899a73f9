"""Joint torques that give one and the same task acceleration."""

from __future__ import annotations

from .array import Array
from .cholesky import cholesky, cholesky_solve, cholesky_solve_vector, forward_substitution
from .compiled import MATRIX, NUMBER, VECTOR, compiled
from .products import times
from .pseudoinverse import least_norm_solution


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
    return times(M, least_norm_solution(J, b)) + nle


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
    A = cholesky_solve(cholesky(M), J)
    return least_norm_solution(A, b + times(A, nle))


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
    L = cholesky(M)
    W = forward_substitution(L, J)
    return times(L, least_norm_solution(W, b)) + nle


@compiled(MATRIX, VECTOR, MATRIX, VECTOR, VECTOR)
def operational_space_torque(M: Array, nle: Array, J: Array, b: Array, tau_0: Array) -> Array:
    """Return JᵀΛb + N + (I − JᵀJ̄ᵀ)τ₀ with Λ = (J M⁻¹Jᵀ)⁺ and J̄ = M⁻¹JᵀΛ: a null-space torque besides the task's.

    τ₀ brings about no task acceleration. With M = L Lᵀ and W = J L⁻ᵀ the sum is L W⁺(b − W L⁻¹τ₀) + τ₀ + N.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).
        tau_0: Joint torque τ₀, shape (n,), N m.

    Returns:
        τ, shape (n,), N m.
    """
    L = cholesky(M)
    W = forward_substitution(L, J)
    of_tau_0 = times(W, forward_substitution(L, tau_0.reshape(1, -1))[0])
    return times(L, least_norm_solution(W, b - of_tau_0)) + tau_0 + nle


@compiled(MATRIX, VECTOR, MATRIX, VECTOR, VECTOR, NUMBER)
def damped_torque(M: Array, nle: Array, J: Array, b: Array, v: Array, damping: float) -> Array:
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
    return times(M, least_norm_solution(J, b + damping * times(J, v)) - damping * v) + nle


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
    return times(J, cholesky_solve_vector(cholesky(M), tau - nle))
