"""Redundancy resolved in velocities, with the computed torque that follows them."""

from __future__ import annotations

from .array import Matrix, Vector
from .generalized_inverse import least_norm_solution
from .kernels import kernel


@kernel
def computed_torque(
    M: Matrix, nle: Vector, v: Vector, v_d: Vector, v_d_before: Vector, dt: float, kv: Matrix, kp: Matrix, error: Vector
) -> Vector:
    """Return τ = M{θ̈_d + K_v(θ̇_d − θ̇) + K_p(θ_d − θ)} + N, Eq. (21), with θ̈_d = (θ̇_d^i − θ̇_d^{i−1}) / Δt, Eq. (20).

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        v: Joint velocity θ̇, shape (n,), rad/s.
        v_d: Desired joint velocity θ̇_d, shape (n,), rad/s.
        v_d_before: The one of the sample before, shape (n,), rad/s.
        dt: Sampling time Δt, s.
        kv: Velocity gain K_v, shape (n, n), 1/s.
        kp: Position gain K_p, shape (n, n), 1/s².
        error: θ_d − θ, shape (n,), rad.

    Returns:
        τ, shape (n,), N m.
    """
    return M @ ((v_d - v_d_before) / dt + kv @ (v_d - v) + kp @ error) + nle


@kernel
def resolved_velocity(J: Matrix, dx: Vector, kappa: float, gradient: Vector) -> Vector:
    """Return θ̇ = J⁺ẋ + κ(I − J⁺J)∇H, Eqs. (2) and (17).

    Args:
        J: Jacobian, shape (m, n).
        dx: Task velocity ẋ, shape (m,), m/s and rad/s.
        kappa: κ, rad² per s and unit of H.
        gradient: ∇H, shape (n,), unit of H per rad.

    Returns:
        θ̇, shape (n,), rad/s.
    """
    return least_norm_solution(J, dx - kappa * (J @ gradient)) + kappa * gradient
