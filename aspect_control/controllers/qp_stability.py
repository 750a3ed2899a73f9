"""What the quadratic program may ask of the self-motion, as a row of its inequalities."""

from __future__ import annotations

import numpy as np

from ..exceptions import NotResetError
from ..redundancy import Array
from .qp_program import Rows

STABILITIES = ("none", "maciejewski", "dead-beat")
"""What may be asked of the self-motion."""

_AT_REST = 1e-12
"""Part of the joint speed below which self-motion is rounding."""


def stability_row(
    stability: str, v: Array, Q: Array, M_inv_Q: Array, c_tilde: Array, nle: Array, dt: float | None
) -> Rows:
    """Return θ̇_H·θ̈_H ≤ 0 with θ̈_H = M⁻¹Q (η − Qᵀτ̃), τ̃ = s M J⁺b + N.

    Args:
        stability: `"maciejewski"`, or `"dead-beat"` for −‖θ̇_H‖²/Δt ≤ θ̇_H·θ̈_H as well.
        v: Joint velocity θ̇, shape (n,), rad/s.
        Q: Basis of the torques that the task leaves open, shape (n, r).
        M_inv_Q: M⁻¹Q, shape (n, r).
        c_tilde: M J⁺b, shape (n,), N m.
        nle: N, shape (n,), N m.
        dt: Δt, s; None if it is not known.

    Raises:
        NotResetError: If `"dead-beat"` is asked for without Δt.
    """
    if stability == "dead-beat" and dt is None:
        raise NotResetError('qp with stability = "dead-beat" needs Δt: call reset(q, v, dt) before the first torque')
    Z = np.linalg.qr(M_inv_Q)[0]
    theta_dot_H = Z @ (Z.T @ v)
    speed = float(np.linalg.norm(theta_dot_H))
    row = M_inv_Q.T @ theta_dot_H
    if speed <= _AT_REST * (1.0 + float(np.linalg.norm(v))):
        row, speed = -(Q.T @ (c_tilde + nle)), 0.0
    origin = float(row @ (Q.T @ nle))
    lower = -np.inf if dt is None or stability == "maciejewski" else origin - speed**2 / dt
    g = -float(row @ (Q.T @ c_tilde))
    return Rows(row[None], np.array([g]), np.array([lower]), np.array([origin])).unit()
