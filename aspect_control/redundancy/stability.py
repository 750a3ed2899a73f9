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
