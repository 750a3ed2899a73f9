"""The law that a guard brakes with: gravity compensated, joints damped, the posture held in the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arm import Arm, ArmState
from ..checks import restore_read_only
from ..redundancy import Array
from .bounds import GuardLimits, joint_index
from .viability import BRAKE_TIME, Viability

SLOWEST = 1.0
"""Least rate of a brake along a straight line in joint space, 1/s; below it the arm is braked by its energy alone."""

HANDOVER = 0.01
"""Time constant with which the torque goes over to that of the brake where there is time, s."""

STILL = 0.02
"""Joint speed up to which an arm counts as at rest, rad/s (m/s for prismatic joints)."""

_HURRY = 1.25
"""How much harder than just enough an arm is braked that comes near a position limit."""


class Brake:
    """θ̈ = −κθ̇: all joints come to rest together, on a straight line in joint space, after moving on by θ̇/κ.

    τ = N − κMθ̇ with κ = 1/T₀, or more where a joint would otherwise pass a position limit, and no more than the limits
    of torque and acceleration allow. Where that is less than `SLOWEST`, as in an arm so fast that its Coriolis torques
    are beyond its motors, τ = G − λMθ̇/T₀ with the largest λ ≤ 1 within the torque limits, which takes energy out of the
    arm as long as its motors can carry it. Once the arm is at rest a critically damped spring holds its posture.

    The torque goes over to it with the time constant `HANDOVER`, or at once where the arm could not be stopped inside
    its limits otherwise; never faster than the torque rate allows: all joints then go the same part of the way.
    """

    def __init__(self, arm: Arm, limits: GuardLimits, viability: Viability) -> None:
        """Set the arm, the limits and what knows whether there is time."""
        self._arm, self._limits, self._viability, self._index = arm, limits, viability, joint_index(arm)
        self._rest = np.zeros(arm.nv)

    __setstate__ = restore_read_only

    def torque(self, state: ArmState, last: Sequence[float], dt: float, held: Array | None = None) -> Array:
        """Return τ, shape (nv,), N m, within the limits of torque and, from `last`, of its rate.

        Args:
            state: The arm's state.
            last: The torque of the sample before, within its limits, N m.
            dt: Δt, s.
            held: Configuration to hold, shape (nq,), rad; None while braking.
        """
        limits, before, momentum = self._limits, np.array(last), state.M @ state.v
        kappa = min(self._wanted(state, dt), self._possible(state, momentum))
        wanted = state.nle - kappa * momentum if kappa >= SLOWEST else self._by_energy(state, momentum)
        if held is not None:
            wanted = wanted + (state.M @ self._arm.difference(state.q, held)) / (2.0 * BRAKE_TIME) ** 2
        way = np.clip(wanted, -limits.torque, limits.torque) - before
        part = 1.0 / float(np.max(np.abs(way) / (limits.rate * dt), initial=1.0))
        tau = self._on_the_way(before, way, min(part, dt / HANDOVER))
        if part > dt / HANDOVER and self._viability.plan(state, tau, dt).reason:
            tau = self._on_the_way(before, way, part)
        return tau

    def _on_the_way(self, before: Array, way: Array, part: float) -> Array:
        return np.clip(before + part * way, -self._limits.torque, self._limits.torque)

    def _wanted(self, state: ArmState, dt: float) -> float:
        """Return the κ that stops every joint before its position limit, and within T₀, 1/s."""
        limits, v = self._limits, state.v
        q = state.q if self._index is None else state.q[self._index]
        room = np.where(v > 0.0, limits.upper - q, q - limits.lower)
        needed = np.divide(np.abs(v), room, out=np.full(len(v), np.inf), where=room > 0.0)
        return min(max(1.0 / BRAKE_TIME, _HURRY * float(needed[v != 0.0].max(initial=0.0))), 0.25 / dt)

    def _possible(self, state: ArmState, momentum: Array) -> float:
        """Return the largest κ within the limits of torque and acceleration, 1/s."""
        limits, speed = self._limits, np.abs(state.v)
        room = limits.torque + np.where(momentum > 0.0, state.nle, -state.nle)
        ratios = room[momentum != 0.0] / np.abs(momentum[momentum != 0.0])
        slowing = limits.acceleration[speed > 0.0] / speed[speed > 0.0]
        return float(min(ratios.min(initial=np.inf), slowing.min(initial=np.inf)))

    def _by_energy(self, state: ArmState, momentum: Array) -> Array:
        """Return G − λMθ̇/T₀ with the largest λ ≤ 1 within the torque limits; G alone where even that is beyond them."""
        limits, push = self._limits, momentum / -BRAKE_TIME
        gravity = self._arm.state(state.q, self._rest).nle
        room, moving = limits.torque - np.sign(push) * gravity, push != 0.0
        part = min(1.0, float((room[moving] / np.abs(push[moving])).min(initial=1.0)))
        return gravity + max(part, 0.0) * push
