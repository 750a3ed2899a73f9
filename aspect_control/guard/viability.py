"""Whether the arm could still be stopped inside its limits if the law's torque were applied for one more sample."""

from __future__ import annotations

from math import hypot
from operator import gt, sub
from typing import NamedTuple

import numpy as np

from ..arm import Arm, ArmState
from ..checks import restore_read_only
from ..redundancy import Array
from .bounds import GuardLimits, joint_index

BRAKE_TIME = 0.1
"""Time constant T₀ with which the joints are brought to rest where the limits allow it, s."""

RESERVE = 0.7
"""Part of the torque left over by gravity and Coriolis torques that a stop is planned with."""

CARRIED = 0.9
"""Largest part of a torque limit that gravity and Coriolis torques may take up: elsewhere they may be larger."""

NEIGHBOURHOOD = 0.05
"""How far the joints may go until a stop is planned anew, rad."""

_FASTER, _SLACK = 1.5, 0.5
"""How much faster than now the arm may become until a stop is planned anew: a factor, and rad/s."""


class Certificate(NamedTuple):
    """A neighbourhood of the last plan in which the arm can be stopped without a plan of its own.

    Attributes:
        q: Joint configuration in its middle, rad.
        tau: Torque in its middle, N m.
        radii: How far each torque may be from there, N m; at most to its limit.
        speed: Largest speed of the joints, as a vector, rad/s.
    """

    q: list[float]
    tau: list[float]
    radii: list[float]
    speed: float

    def covers(self, v: list[float], tau: list[float]) -> bool:
        """Return whether no plan is needed for a posture that is in the neighbourhood."""
        return hypot(*v) <= self.speed and not any(map(gt, map(abs, map(sub, tau, self.tau)), self.radii))


class Plan(NamedTuple):
    """What came of planning a stop.

    Attributes:
        reason: Why the arm has to be braked now; empty if it need not.
        certificate: Where no further plan is needed; None if everywhere.
    """

    reason: str
    certificate: Certificate | None


class Viability:
    """Plans a stop from where one more sample of a torque leads.

    The torque τ acts for Δt, then changes to the braking torque at the torque rate, in the time t_r, or at once; from
    there the joints come to rest along θ̈ = −θ̇/T. With θ̈ = M⁻¹(τ − N) until the middle of the change, the largest
    outward speed of a joint is

    u = max(0, θ̇, θ̇ + θ̈(Δt + t_r/2))

    and it moves outward by no more than u(Δt + t_r + T). That must be inside its position limits, and u inside its
    speed limit. 1/T is 1/T₀, or what `RESERVE` of the torque that N leaves over gives for the momentum
    Mθ̇ + (τ − N)(Δt + t_r/2) if that is less: M and N change along the way. N itself must leave a part of the torque
    limits free; see `CARRIED`.

    A plan costs several control ticks. One that leaves room makes a `Certificate`, and as long as the arm stays in its
    neighbourhood a few comparisons tell so; near a limit every sample is planned.
    """

    def __init__(self, arm: Arm, limits: GuardLimits) -> None:
        """Set the arm and the limits."""
        self._limits, self._index = limits, joint_index(arm)
        self._slowest_limit = float(limits.speed.min())

    __setstate__ = restore_read_only

    def plan(self, state: ArmState, tau: Array, dt: float) -> Plan:
        """Plan a stop from one sample of a torque on.

        Args:
            state: The arm's state.
            tau: Torque τ of this sample, shape (n,), N m, within its limits.
            dt: Δt, s.
        """
        limits, v = self._limits, state.v
        q = state.q if self._index is None else state.q[self._index]
        push, momentum = tau - state.nle, state.M @ v
        M_inv: Array = np.asarray(np.linalg.inv(state.M), dtype=np.float64)
        acceleration = M_inv @ push
        handover = self._handover(push, momentum)
        acting = dt + handover / 2.0
        later: Array = v + acceleration * acting
        up, down = np.maximum(np.maximum(v, later), 0.0), np.maximum(np.maximum(-v, -later), 0.0)
        peak = np.maximum(up, down)
        if (peak > limits.speed).any():
            return Plan(self._too_fast(v, peak), None)
        times = self._stopping_times(state.nle, momentum + push * acting, peak)
        load = np.abs(state.nle) / limits.torque
        if load.max() > CARRIED:
            return Plan(self._too_weak(state.nle, int(np.argmax(load))), None)
        way = dt + handover + float(times.max())
        highest, lowest = q + up * way, q - down * way
        if (highest > limits.upper).any() or (lowest < limits.lower).any():
            return Plan(self._too_far(q, highest, lowest), None)
        return Plan("", self._certificate(state, q, tau, M_inv, dt))

    def _handover(self, push: Array, momentum: Array) -> float:
        """Return t_r, s: how long it takes from a torque N + push to that of the brake, N − Mθ̇/T₀."""
        return float(np.max((np.abs(push) + np.abs(momentum) / BRAKE_TIME) / self._limits.rate))

    def _stopping_times(self, nle: Array, momentum: Array, peak: Array) -> Array:
        """Return the T that each joint's limits of torque and acceleration ask for, shape (n,), s; T is the longest."""
        limits = self._limits
        room = RESERVE * np.maximum(limits.torque + np.where(momentum > 0.0, nle, -nle), 0.0)
        needed = np.divide(np.abs(momentum), room, out=np.full(len(room), np.inf), where=room > 0.0)
        times: Array = np.maximum(np.maximum(needed, peak / limits.acceleration), BRAKE_TIME)
        return times

    def _certificate(self, state: ArmState, q: Array, tau: Array, M_inv: Array, dt: float) -> Certificate | None:
        """Return a neighbourhood in which any joint may be as fast as all together, in any direction."""
        limits, now, push = self._limits, hypot(*state.v.tolist()), tau - state.nle
        radii = np.minimum(0.1 * np.minimum(limits.torque, 10.0 * (np.abs(tau) + 1.0)), limits.torque - np.abs(tau))
        wanted = _FASTER * now + _SLACK
        momentum = np.linalg.norm(state.M, axis=1) * (wanted + _SLACK)
        handover = self._handover(np.abs(push) + radii, momentum)
        acting = dt + handover / 2.0
        added = acting * float((np.abs(M_inv) @ radii).max())
        radii *= _SLACK / max(added, _SLACK)
        gained = acting * float(np.abs(M_inv @ push).max()) + min(added, _SLACK)
        speed = min(wanted, self._slowest_limit - gained)
        if speed < now:
            return None
        peak = np.full(len(q), speed + gained)
        stop = float(self._stopping_times(-np.abs(state.nle) - radii, momentum, peak).max())
        margin = NEIGHBOURHOOD + peak[0] * (dt + handover + stop)
        if gained > wanted or (q - margin < limits.lower).any() or (q + margin > limits.upper).any():
            return None
        return Certificate(state.q.tolist(), tau.tolist(), radii.tolist(), speed)

    def _too_fast(self, v: Array, peak: Array) -> str:
        limits = self._limits
        i = int(np.argmax(peak / limits.speed))
        what = "moves at" if abs(v[i]) >= peak[i] else "would reach"
        return f"joint {limits.names[i]!r} {what} {peak[i]:.4g} rad/s, its speed limit is {limits.speed[i]:.4g} rad/s"

    def _too_weak(self, nle: Array, i: int) -> str:
        limit = self._limits.torque[i]
        return (
            f"joint {self._limits.names[i]!r} has hardly any torque left to be braked with: {abs(nle[i]):.4g} N m "
            f"carry it, its torque limit is {limit:.4g} N m"
        )

    def _too_far(self, q: Array, highest: Array, lowest: Array) -> str:
        limits = self._limits
        beyond = np.maximum(highest - limits.upper, limits.lower - lowest)
        i = int(np.argmax(beyond))
        end, limit = (highest[i], limits.upper[i]) if highest[i] > limits.upper[i] else (lowest[i], limits.lower[i])
        return (
            f"joint {limits.names[i]!r} at {q[i]:.4g} rad could not be stopped before {end:.6g} rad, "
            f"its position limit is {limit:.4g} rad"
        )
