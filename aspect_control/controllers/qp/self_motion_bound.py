"""What the quadratic program may ask of the self-motion, as a row of its inequalities."""

from __future__ import annotations

import numpy as np

from ...exceptions import NotResetError
from ...redundancy import Array

STABILITIES = ("none", "maciejewski", "dead-beat")
"""What may be asked of the self-motion."""


def self_motion_bound(stability: str, v: Array, M_inv_B: Array, free: Array, dt: float | None) -> tuple[Array, float]:
    """Return u and the least u·θ̈ of the demand on the self-motion, (that) ≤ u·θ̈ ≤ 0.

    u is θ̇_H, the part of θ̇ in the null space of J; θ̇_H·θ̈_H = θ̇_H·θ̈, for J⁺b is orthogonal to that space. Without
    self-motion it is θ̈_H of the torque that the cost asks for, so that none is started: Eq. (13).

    Args:
        stability: `"maciejewski"`, or `"dead-beat"` for −‖θ̇_H‖²/Δt ≤ θ̇_H·θ̈_H as well.
        v: Joint velocity θ̇, shape (n,), rad/s.
        M_inv_B: Basis of the null space of J, shape (n, r).
        free: θ̈ of the torque that the cost asks for, shape (n,), rad/s².
        dt: Δt, s; None if it is not known.

    Raises:
        NotResetError: If `"dead-beat"` is asked for without Δt.
    """
    if stability == "dead-beat" and dt is None:
        raise NotResetError('qp with stability = "dead-beat" needs Δt: call reset(q, v, dt) before the first torque')
    Z = np.linalg.qr(M_inv_B)[0]
    u: Array = Z @ (Z.T @ v)
    speed = float(np.linalg.norm(u))
    if speed <= 1e-12 * (1.0 + float(np.linalg.norm(v))):  # rounding
        u, speed = Z @ (Z.T @ free), 0.0
    return u, -np.inf if dt is None or stability == "maciejewski" else -(speed**2) / dt
