"""The joint torques that a task leaves open, and the joint accelerations that they bring about."""

from __future__ import annotations

import numpy as np

from .array import Array
from .cholesky import cholesky, cholesky_solve, cholesky_solve_vector
from .compiled import MATRIX, NUMBER, VECTOR, compiled
from .feedback import require_finite
from .products import times, transpose_times
from .pseudoinverse import least_norm_solution


@compiled(MATRIX, VECTOR, MATRIX, VECTOR)
def open_torques(M: Array, nle: Array, J: Array, b: Array) -> tuple[Array, Array, Array]:
    """Return Q, c and d: the torques of the task accelerations s b are τ = Q η + s c + d, whatever η is.

    They are the solutions of A τ = s b + A N with A = J M⁻¹. Q is an orthonormal basis of what A does not see, and c
    and d are what is left of M J⁺b and of N without it, so that η = 0 is the torque of Eq. (11). Q is the end of the
    square factor of Aᵀ = Q̄ R̄, which has n − m columns at the loss of rank as well.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).

    Returns:
        Q, shape (n, n − m), with QᵀQ = I and J M⁻¹Q = 0; c and d, shapes (n,), N m, with Qᵀc = Qᵀd = 0.
    """
    m, n = J.shape
    A = cholesky_solve(cholesky(M), J)
    # Columns of zeros make the factor square: a reflection that has nothing to remove is the identity.
    wide = np.zeros((n, n))
    wide[:, :m] = A.T
    Q = np.ascontiguousarray(np.linalg.qr(wide)[0][:, m:])
    return Q, _without(Q, times(M, least_norm_solution(J, b))), _without(Q, nle)


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
    M_inv_c = cholesky_solve_vector(L, c)
    return M_inv_Q, M_inv_c, cholesky_solve_vector(L, d - nle)


@compiled(MATRIX, VECTOR, VECTOR, VECTOR, NUMBER, VECTOR)
def open_torque(Q: Array, c: Array, d: Array, eta: Array, s: float, limit: Array) -> Array:
    """Return τ = Q η + s c + d, cut off at the limits, which rounding may pass.

    Args:
        Q: As `open_torques` returns it, shape (n, r).
        c: As `open_torques` returns it, shape (n,), N m.
        d: As `open_torques` returns it, shape (n,), N m.
        eta: η, shape (r,), N m.
        s: The part of the task acceleration.
        limit: Torque limits, shape (n,), N m; infinite where there is none.

    Returns:
        τ, shape (n,), N m.

    Raises:
        FloatingPointError: If τ is not finite.
    """
    tau = require_finite(times(Q, eta) + s * c + d)
    return np.minimum(np.maximum(tau, -limit), limit)
