"""Redundancy resolved in velocities, with the computed torque that follows them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from .array import Array
from .compiled import MATRIX, NUMBER, STACK, VECTOR, Compiled, compiled
from .feedback import require_finite
from .products import add_times, times
from .pseudoinverse import least_norm_solution


@compiled(MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, MATRIX, MATRIX, VECTOR)
def computed_torque(
    M: Array, nle: Array, v: Array, v_d: Array, v_d_before: Array, dt: float, kv: Array, kp: Array, error: Array
) -> Array:
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
    acceleration = (v_d - v_d_before) / dt
    add_times(acceleration, kv, v_d - v)
    add_times(acceleration, kp, error)
    return times(M, acceleration) + nle


@compiled(MATRIX, VECTOR, NUMBER, VECTOR)
def resolved_velocity(J: Array, dx: Array, kappa: float, gradient: Array) -> Array:
    """Return θ̇ = J⁺ẋ + κ(I − J⁺J)∇H, Eqs. (2) and (17).

    Args:
        J: Jacobian, shape (m, n).
        dx: Task velocity ẋ, shape (m,), m/s and rad/s.
        kappa: κ, rad² per s and unit of H.
        gradient: ∇H, shape (n,), unit of H per rad.

    Returns:
        θ̇, shape (n,), rad/s.
    """
    return least_norm_solution(J, dx - kappa * times(J, gradient)) + kappa * gradient


@lru_cache
def resolved_motion_law(gradient: Compiled) -> Any:
    """Make one sample of Eqs. (2) and (17)–(21) one compiled function, the gradient of the criterion included.

    Its arguments are M, N, J, θ̇, `Target.rows`, K_p and K_v as a stack, θ_d − θ, the memory, κ, Δt, τ and a tuple. The
    memory, shape (3, n), holds θ̇_d^i and θ̇_d^{i−1}, rad/s, which it moves on by one sample, and the displacement
    θ̇_d^i Δt, rad, that it leads to. τ, shape (n,), N m, is written to. The tuple holds what the gradient takes besides
    J. If τ or the next θ̇_d is not finite, it raises FloatingPointError and the memory stays as it was.

    Args:
        gradient: Function that `compiled` made, of J and other arguments: ∇H, shape (n,).
    """
    further = f"Tuple(({', '.join(gradient.argument_types[1:])},))"

    def sample(M, nle, J, v, desired, gains, error, memory, kappa, dt, tau, arguments):  # type: ignore[no-untyped-def]
        v_d, v_d_before = memory[0], memory[1]
        now = require_finite(computed_torque(M, nle, v, v_d, v_d_before, dt, gains[1], gains[0], error))
        v_d_after = require_finite(resolved_velocity(J, desired[1], kappa, gradient(J, *arguments)))
        tau[:] = now
        memory[2] = v_d * dt
        memory[1] = v_d
        memory[0] = v_d_after

    state = MATRIX, VECTOR, MATRIX, VECTOR
    return compiled(*state, MATRIX, STACK, VECTOR, MATRIX, NUMBER, NUMBER, VECTOR, further)(sample)
