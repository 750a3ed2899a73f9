"""Which measured samples are believed while the arm is braked, and what stands in for the others."""

from __future__ import annotations

from math import dist, hypot

import numpy as np

from ..arm import Arm, ArmState
from .plausibility import Plausibility
from .status import GuardMemory

TRUSTED = 10
"""Samples after one another that have to agree with each other before a measurement is believed again."""

LEAP = 0.05
"""How much farther than three samples' motion a measured configuration may be from the one before, rad."""


class Belief:
    """Believes a measured sample, or else what the arm's model predicts.

    One that is near the state that was believed last is believed at once, unless it repeats the one before while the
    arm moves; others have to follow from one another, inside the position limits, for `TRUSTED` samples.
    """

    def __init__(self, arm: Arm, plausibility: Plausibility) -> None:
        """Set the arm and what knows how q and v are to be read."""
        self._arm, self._plausibility = arm, plausibility

    def believed(self, state: ArmState | None, memory: GuardMemory) -> tuple[ArmState, list[float], list[float], int]:
        """Return the state that is believed, the measured q and v, and how many samples have agreed with each other.

        Args:
            state: The state as it was measured; None if it was not.
            memory: What the guard remembers.
        """
        if state is None:
            return self._predicted(memory), memory.positions, memory.speeds, 0
        state = self._plausibility.read(state, memory.stage.reading)
        q, v = state.q.tolist(), state.v.tolist()
        if memory.state is None:
            return state, q, v, TRUSTED
        agreeing = self._agreeing(state, q, v, memory)
        return (state if agreeing >= TRUSTED else self._predicted(memory)), q, v, agreeing

    def _agreeing(self, state: ArmState, q: list[float], v: list[float], memory: GuardMemory) -> int:
        if memory.state is None or (q == memory.positions and v == memory.speeds and any(v)):
            return 0
        way = memory.stage.dt * max(hypot(*v), hypot(*memory.speeds))
        if dist(q, memory.state.q.tolist()) <= LEAP + 3.0 * way:
            return TRUSTED
        follows = dist(q, memory.positions) <= 2.0 * way and self._plausibility.fits(state)
        return memory.agreeing + 1 if follows else 0

    def _predicted(self, memory: GuardMemory) -> ArmState:
        """Return the state that follows from the last one; the one that `reset` was told if there was none."""
        state, dt = memory.state, memory.stage.dt
        if state is None:
            return self._arm.state(memory.stage.start, np.zeros(self._arm.nv))
        v = state.v + dt * np.linalg.solve(state.M, np.array(memory.tau) - state.nle)
        return self._arm.state(self._arm.integrate(state.q, (dt / 2.0) * (state.v + v)), v)
