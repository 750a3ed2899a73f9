"""Maciejewski's condition: does the null-space acceleration feed the self-motion or brake it?"""

from __future__ import annotations

import numpy as np

from .array import Array, Matrix, Vector
from .generalized_inverse import RANK_TOLERANCE, least_norm_solution
from .kernels import kernel


def homogeneous_velocity(J: Array, v: Array) -> Array:
    """Return θ̇_H = (I − J⁺J)θ̇, Eq. (15): the part of the joint velocity that does not move the task.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        v: Joint velocity θ̇, shape (..., n), rad/s.

    Returns:
        θ̇_H, shape (..., n), rad/s.
    """
    theta_dot = v[..., np.newaxis]
    theta_dot_H: Array = theta_dot - np.linalg.pinv(J, RANK_TOLERANCE) @ (J @ theta_dot)
    return theta_dot_H[..., 0]


@kernel
def homogeneous_acceleration(M: Matrix, tau: Vector, tau_tilde: Vector) -> Vector:
    """Return θ̈_H = M⁻¹(τ − τ̃): the null-space acceleration that a torque adds to the pseudoinverse law's.

    For the minimum torque of Eq. (11) this is Eq. (16), θ̈_H = −[M(I − J⁺J)]⁺τ̃.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        tau: Joint torque τ, shape (n,), N m.
        tau_tilde: Torque τ̃ of Eq. (7) for the same task acceleration, shape (n,), N m.

    Returns:
        θ̈_H, shape (n,), rad/s².
    """
    return np.linalg.solve(M, tau - tau_tilde)


@kernel
def _both_torques(M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector) -> tuple[Vector, Vector, float]:
    """Return τ̃ of Eq. (7), the minimum torque of Eq. (11) and θ̇_H·θ̈_H of Eq. (12).

    J θ̈_H = 0, so that θ̇_H·θ̈_H is the same as θ̇·θ̈_H = θ̇·M⁻¹(τ − τ̃).
    """
    M_inv = np.linalg.inv(M)
    A = J @ M_inv
    tau_tilde = M @ least_norm_solution(J, b) + nle
    tau_minimum = least_norm_solution(A, b + A @ nle)
    return tau_tilde, tau_minimum, v @ (M_inv @ (tau_minimum - tau_tilde))


@kernel
def switched_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector) -> Vector:
    """Return the torque of the modified null space vector method, Eqs. (12)–(16).

    τ̃ of Eq. (7) if θ̇_H·θ̈_H ≥ 0, Eq. (13), and the minimum torque of Eq. (11) otherwise, Eq. (14).

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).
        v: Joint velocity θ̇, shape (n,), rad/s.

    Returns:
        τ, shape (n,), N m.
    """
    tau_tilde, tau_minimum, product = _both_torques(M, nle, J, b, v)
    return tau_minimum if product < 0.0 else tau_tilde


@kernel
def dead_beat_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, dt: float) -> Vector:
    """Return the torque of `switched_torque` with its null-space term scaled by min(1, ‖θ̇_H‖² / (−θ̇_H·θ̈_H Δt)).

    Args:
        M: As for `switched_torque`.
        nle: As for `switched_torque`.
        J: As for `switched_torque`.
        b: As for `switched_torque`.
        v: As for `switched_torque`.
        dt: Sampling time Δt, s.

    Returns:
        τ, shape (n,), N m.
    """
    tau_tilde, tau_minimum, product = _both_torques(M, nle, J, b, v)
    if product >= 0.0:
        return tau_tilde
    theta_dot_H = v - least_norm_solution(J, J @ v)
    speed_squared = float(theta_dot_H @ theta_dot_H)
    if speed_squared == 0.0:
        return tau_tilde
    return tau_tilde + min(1.0, speed_squared / (-product * dt)) * (tau_minimum - tau_tilde)


@kernel
def brake_torque(M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, dt: float) -> Vector:
    """Return τ̃ + max(θ̇_H·θ̈_H / ‖θ̇_H‖², −1/Δt) M θ̇_H if θ̇_H·θ̈_H < 0, and τ̃ otherwise.

    Args:
        M: As for `switched_torque`.
        nle: As for `switched_torque`.
        J: As for `switched_torque`.
        b: As for `switched_torque`.
        v: As for `switched_torque`.
        dt: Sampling time Δt, s.

    Returns:
        τ, shape (n,), N m.
    """
    tau_tilde, _, product = _both_torques(M, nle, J, b, v)
    if product >= 0.0:
        return tau_tilde
    theta_dot_H = v - least_norm_solution(J, J @ v)
    speed_squared = float(theta_dot_H @ theta_dot_H)
    if speed_squared == 0.0:
        return tau_tilde
    return tau_tilde + max(product / speed_squared, -1.0 / dt) * (M @ theta_dot_H)


def null_vector_derivative(J: Array, drift: Array) -> Array:
    """Return z′ = −J⁺(J̇θ̇ at θ̇ = z): how the unit null vector turns along the self-motion.

    From J z = 0 and zᵀz = 1 along the curve: J z′ = −J′z and zᵀz′ = 0. Its length is the curvature of the self-motion
    in joint space; it is the same for both directions of travel.

    Args:
        J: Jacobian, shape (n − 1, n).
        drift: J̇θ̇ at the velocity θ̇ = z, shape (n − 1,).

    Returns:
        z′ = dz/ds, shape (n,), 1/rad.
    """
    derivative: Array = -least_norm_solution(J, drift)
    return derivative


def stability_coefficient(M: Array, coriolis: Array, z: Array, dz: Array) -> float:
    """Return c of s̈ = −c ṡ²: how fast minimum torque brakes a pure self-motion θ̇ = ṡ z, or feeds it if c < 0.

    c = (Mz)·(Mz′ + N(θ, z)) / ‖Mz‖². Eq. (12) becomes θ̇_H·θ̈_H = −c ṡ³ there, and c changes sign with z: whether the
    self-motion grows depends on the configuration and on the direction of travel.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        coriolis: Coriolis and centrifugal torques N at the velocity z, without gravity, shape (n,), N m s²/rad².
        z: Unit null vector of J in the direction of travel, shape (n,).
        dz: Its derivative by arc length, shape (n,), 1/rad; see `null_vector_derivative`.

    Returns:
        c, 1/rad.
    """
    Mz = M @ z
    return float(Mz @ (M @ dz + coriolis) / (Mz @ Mz))
