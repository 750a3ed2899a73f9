"""What is likely wrong with the first sample, in plain words."""

from __future__ import annotations

import numpy as np

from ..arm import Arm, ArmState
from ..arm.chain import unit_hint
from ..redundancy import Array
from ..trajectories import Target
from .bounds import GuardLimits
from .monitor import Monitor

NOT_MOVED = 0.05
"""How far the joints may be from where `reset` was told that they are, rad."""

REACHES_A_SECOND = 10.0
"""How fast a target may be that is meant in metres, in reaches of the arm a second."""


class Plausibility:
    """Holds the first sample of a motion against the limits, the posture of `reset` and the target."""

    def __init__(self, arm: Arm, limits: GuardLimits, monitor: Monitor) -> None:
        """Set the arm, the limits and what knows whether a target is near."""
        self._arm, self._limits, self._monitor = arm, limits, monitor

    def doubt(self, state: ArmState, target: Target, start: Array) -> str:
        """Return what is likely wrong; empty if nothing is.

        Args:
            state: The arm's state at the first sample.
            target: What the task is to do there.
            start: The configuration that `reset` was given, shape (nq,), rad.
        """
        arm, limits = self._arm, self._limits
        q, v = arm.positions(state.q), state.v
        outside, fast = self._outside(q), np.abs(v) > limits.speed
        target_reason = self._monitor.too_far(target) or self._monitor.not_tracked(state, target)
        found = outside or self._too_fast(v, fast) or target_reason
        if found and self._belongs(v, target) and (np.abs(q) <= limits.speed).all():
            return f"q and v are swapped: v is a posture of the target, and {found}"
        if found and (np.abs(q) > 2.0 * np.pi).any() and self._fits(np.where(arm.prismatic, q, np.deg2rad(q))):
            return f"q is in degrees: angles are in radians, and {found}"
        if outside:
            return outside
        if target_reason and self._in_millimetres(state, target):
            return f"the target is in millimetres: positions are in metres, and {target_reason}"
        if target_reason and self._belongs(np.where(arm.prismatic, q, np.deg2rad(q)), target):
            return f"q is in degrees: angles are in radians, and {target_reason}"
        if fast.any():
            return self._too_fast(v, fast)
        moved = float(np.abs(arm.difference(start, state.q)).max())
        if moved > NOT_MOVED:
            return f"the law was not reset here: a joint is {moved:.3g} rad from where reset(q, v, dt) was told it is"
        if target_reason:
            return f"the posture does not belong to the target: {target_reason}"
        speed = float(np.linalg.norm(target.dx))
        if speed > REACHES_A_SECOND * arm.reach:
            return f"the target moves at {speed:.3g} m/s, too fast for any arm: is it in millimetres?"
        return ""

    def fits(self, state: ArmState) -> bool:
        """Return whether a posture is inside the position limits."""
        return self._fits(self._arm.positions(state.q))

    def _outside(self, q: Array) -> str:
        limits = self._limits
        for i in np.flatnonzero((q < limits.lower) | (q > limits.upper)):
            prismatic = bool(self._arm.prismatic[i])
            hint = unit_hint(float(q[i]), float(limits.lower[i]), float(limits.upper[i]), prismatic=prismatic)
            span = f"[{limits.lower[i]:.4g}, {limits.upper[i]:.4g}]"
            return f"joint {limits.names[i]!r} starts at {q[i]:.4g}, outside its limits {span}{hint}"
        return ""

    def _too_fast(self, v: Array, fast: Array) -> str:
        for i in np.flatnonzero(fast):
            limit = self._limits.speed[i]
            hint = "; is v in degrees a second?" if np.deg2rad(abs(v[i])) <= limit and abs(v[i]) > 10.0 else ""
            return f"joint {self._limits.names[i]!r} starts at {v[i]:.4g} rad/s, its speed limit is {limit:.4g}{hint}"
        return ""

    def _fits(self, positions: Array) -> bool:
        return bool(((positions >= self._limits.lower) & (positions <= self._limits.upper)).all())

    def _belongs(self, positions: Array, target: Target) -> bool:
        """Return whether a posture is within the limits and at the target."""
        if not self._fits(positions):
            return False
        state = self._arm.state(self._arm.configuration(positions), np.zeros(self._arm.nv))
        return not self._monitor.not_tracked(state, target)

    def _in_millimetres(self, state: ArmState, target: Target) -> bool:
        task = self._arm.coordinates
        x, x_d = (each.translation if task.has_rotation else each for each in (state.x, target.x))
        return float(np.linalg.norm(x_d / 1000.0 - x)) <= max(self._limits.tracking, 0.1 * self._arm.reach)
