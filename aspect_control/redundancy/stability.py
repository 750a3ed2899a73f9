"""Maciejewski's condition: does the null-space acceleration feed the self-motion or brake it?"""

from __future__ import annotations

import eigenpy

from .array import Array
from .pseudoinverse import pseudoinverse


def homogeneous_velocity(J: Array, v: Array) -> Array:
    """Return θ̇_H = (I − J⁺J)θ̇, Eq. (15): the part of the joint velocity that does not move the task.

    Args:
        J: Jacobian, shape (m, n).
        v: Joint velocity θ̇, shape (n,), rad/s.

    Returns:
        θ̇_H, shape (n,), rad/s.
    """
    velocity: Array = v - pseudoinverse(J) @ (J @ v)
    return velocity


def homogeneous_acceleration(M: Array, tau: Array, tau_tilde: Array) -> Array:
    """Return θ̈_H = M⁻¹(τ − τ̃): the null-space acceleration that a torque adds to the pseudoinverse law's.

    For the minimum torque of Eq. (11) this is Eq. (16), θ̈_H = −[M(I − J⁺J)]⁺τ̃.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        tau: Joint torque τ, shape (n,), N m.
        tau_tilde: Torque τ̃ of Eq. (7) for the same task acceleration, shape (n,), N m.

    Returns:
        θ̈_H, shape (n,), rad/s².
    """
    acceleration: Array = eigenpy.LLT(M).solve(tau - tau_tilde)
    return acceleration


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
    derivative: Array = -pseudoinverse(J) @ drift
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
