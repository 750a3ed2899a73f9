"""What is likely wrong with the first sample, in plain words."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arm import Arm, ArmState
from ..redundancy import Array
from ..trajectories import Target
from .bounds import GuardLimits
from .monitor import Monitor

NOT_MOVED = 0.05
"""How far the joints may be from where `reset` was told that they are, rad."""

NEAR = 0.1
"""How far from its target a posture may be that q and v, read in another way, stand for, m and rad."""

REACHES_A_SECOND = 10.0
"""How fast a target may be that is meant in metres, in reaches of the arm a second."""


AS_TOLD, DEGREES, SWAPPED = "as told", "degrees", "swapped"
"""How q and v are to be read."""


class Doubt(NamedTuple):
    """What is likely wrong.

    Attributes:
        reason: It, in plain words; empty if nothing is.
        reading: How q and v are to be read, as far as that can be told.
    """

    reason: str
    reading: str = AS_TOLD


class Plausibility:
    """Holds the first sample of a motion against the limits, the posture of `reset` and the target."""

    def __init__(self, arm: Arm, limits: GuardLimits, monitor: Monitor) -> None:
        """Set the arm, the limits and what knows whether a target is near."""
        self._arm, self._limits, self._monitor = arm, limits, monitor

    def doubt(self, state: ArmState, target: Target, start: Array) -> Doubt:
        """Return what is likely wrong.

        Args:
            state: The arm's state at the first sample.
            target: What the task is to do there.
            start: The configuration that `reset` was given, shape (nq,), rad.
        """
        arm, limits = self._arm, self._limits
        q, v = arm.positions(state.q), state.v
        outside, fast = self._outside(q), self._too_fast(v)
        away, far = self._monitor.too_far(target), self._monitor.not_tracked(state, target)
        found = outside or fast or away or far
        if found and self._belongs(v, target) and (np.abs(q) <= limits.speed).all():
            return Doubt(f"q and v are swapped: v is a posture at the target, and {found}", SWAPPED)
        in_radians = np.where(arm.prismatic, q, np.deg2rad(q))
        turned = outside and bool((np.abs(q) > 2.0 * np.pi).any()) and self._fits(in_radians)
        if turned or (far and self._belongs(in_radians, target)):
            return Doubt(f"q is in degrees, angles are in radians: {found}", DEGREES)
        if outside:
            return Doubt(outside)
        if (away or far) and self._in_millimetres(state, target):
            return Doubt(f"the target is in millimetres, positions are in metres: {away or far}")
        if fast:
            return Doubt(fast)
        moved = float(np.abs(arm.difference(start, state.q)).max())
        if moved > NOT_MOVED:
            return Doubt(f"the law was not reset here: a joint is {moved:.3g} rad from where reset(q, v, dt) was told")
        if away or far:
            return Doubt(away or f"the posture does not belong to the target: {far}")
        speed = float(np.linalg.norm(target.dx))
        if speed > REACHES_A_SECOND * arm.reach:
            return Doubt(f"the target moves at {speed:.3g} m/s, too fast for any arm: is it in millimetres?")
        return Doubt("")

    def read(self, state: ArmState, reading: str) -> ArmState:
        """Return the state that a sample stands for if q and v are to be read in another way."""
        arm = self._arm
        if reading == SWAPPED:
            return arm.state(arm.configuration(state.v), arm.positions(state.q))
        if reading == DEGREES:
            q, v = (np.where(arm.prismatic, each, np.deg2rad(each)) for each in (arm.positions(state.q), state.v))
            return arm.state(arm.configuration(q), v)
        return state

    def fits(self, state: ArmState) -> bool:
        """Return whether a posture is inside the position limits."""
        return self._fits(self._arm.positions(state.q))

    def _outside(self, q: Array) -> str:
        limits = self._limits
        for i in np.flatnonzero((q < limits.lower) | (q > limits.upper)):
            span = f"[{limits.lower[i]:.4g}, {limits.upper[i]:.4g}]"
            return f"joint {limits.names[i]!r} starts at {q[i]:.4g}, outside its limits {span}"
        return ""

    def _too_fast(self, v: Array) -> str:
        limits = self._limits
        for i in np.flatnonzero(np.abs(v) > limits.speed):
            hint = "; is v in degrees a second?" if np.deg2rad(abs(v[i])) <= limits.speed[i] < 0.1 * abs(v[i]) else ""
            return (
                f"joint {limits.names[i]!r} starts at {v[i]:.4g} rad/s, its speed limit is {limits.speed[i]:.4g}{hint}"
            )
        return ""

    def _fits(self, positions: Array) -> bool:
        return bool(((positions >= self._limits.lower) & (positions <= self._limits.upper)).all())

    def _belongs(self, positions: Array, target: Target) -> bool:
        """Return whether a posture is within the limits and at the target."""
        if not self._fits(positions):
            return False
        state = self._arm.state(self._arm.configuration(positions), np.zeros(self._arm.nv))
        return not self._monitor.not_tracked(state, target, NEAR)

    def _in_millimetres(self, state: ArmState, target: Target) -> bool:
        task = self._arm.coordinates
        x, x_d = (each.translation if task.has_rotation else each for each in (state.x, target.x))
        return float(np.linalg.norm(x_d / 1000.0 - x)) <= 0.1 * self._arm.reach
