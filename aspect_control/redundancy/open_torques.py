"""The joint torques that a task leaves open, and the joint accelerations that they bring about."""

from __future__ import annotations

import numpy as np

from .array import Array
from .cholesky import cholesky, cholesky_solve
from .compiled import MATRIX, VECTOR, compiled
from .products import times, transpose_times
from .pseudoinverse import pseudoinverse


@compiled(MATRIX, VECTOR, MATRIX, VECTOR)
def open_torques(M: Array, nle: Array, J: Array, b: Array) -> tuple[Array, Array, Array, Array]:
    """Return Q, c, d and M J⁺b: the torques of the task accelerations s b are τ = Q η + s c + d, whatever η is.

    They are the solutions of A τ = s b + A N with A = J M⁻¹. Q is an orthonormal basis of what A does not see, and c
    and d are what is left of M J⁺b and of N without it, so that η = 0 is the torque of Eq. (11). Q is the end of the
    square factor of Aᵀ = Q̄ R̄, which has n − m columns at the loss of rank as well.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        Q, shape (n, n − m), with QᵀQ = I and J M⁻¹Q = 0; c, d and M J⁺b, shapes (n,), N m, with Qᵀc = Qᵀd = 0.
    """
    m, n = J.shape
    A = cholesky_solve(cholesky(M), J)
    # Columns of zeros make the factor square: a reflection that has nothing to remove is the identity.
    wide = np.zeros((n, n))
    wide[:, :m] = A.T
    Q = np.ascontiguousarray(np.linalg.qr(wide)[0][:, m:])
    c_tilde = times(M, times(pseudoinverse(J), b))
    return Q, _without(Q, c_tilde), _without(Q, nle), c_tilde


@compiled(MATRIX, VECTOR)
def _without(Q: Array, tau: Array) -> Array:
    """Return (I − QQᵀ)τ."""
    return tau - times(Q, transpose_times(Q, tau.reshape(-1, 1))[:, 0].copy())


@compiled(MATRIX, VECTOR, MATRIX, VECTOR, VECTOR)
def open_accelerations(M: Array, nle: Array, Q: Array, c: Array, d: Array) -> tuple[Array, Array, Array]:
    """Return M⁻¹Q, M⁻¹c and M⁻¹(d − N): the joint accelerations of those torques are θ̈ = M⁻¹Q η + s M⁻¹c + M⁻¹(d − N).

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        Q: As `open_torques` returns it, shape (n, r).
        c: As `open_torques` returns it, shape (n,), N m.
        d: As `open_torques` returns it, shape (n,), N m.

    Returns:
        M⁻¹Q, shape (n, r); M⁻¹c and M⁻¹(d − N), shapes (n,), rad/s².
    """
    L = cholesky(M)
    M_inv_Q = np.ascontiguousarray(cholesky_solve(L, np.ascontiguousarray(Q.T)).T)
    M_inv_c = cholesky_solve(L, c.reshape(1, -1))[0]
    return M_inv_Q, M_inv_c, cholesky_solve(L, (d - nle).reshape(1, -1))[0]


@compiled(MATRIX, VECTOR, VECTOR, VECTOR)
def open_torque(Q: Array, c: Array, d: Array, x: Array) -> Array:
    """Return τ = Q η + s c + d.

    Args:
        Q: As `open_torques` returns it, shape (n, r).
        c: As `open_torques` returns it, shape (n,), N m.
        d: As `open_torques` returns it, shape (n,), N m.
        x: η and s, shape (r + 1,).

    Returns:
        τ, shape (n,), N m.
    """
    r = Q.shape[1]
    return times(Q, x[:r].copy()) + x[r] * c + d
