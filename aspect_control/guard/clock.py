"""Whether the samples come as they should: none lost, none twice, and as far apart as the law was told."""

from __future__ import annotations

from math import dist, hypot, inf
from typing import NamedTuple

from ..arm import Arm, ArmState

LOOKS = 2
"""How many looks after one another have to disagree."""

SHARE, NOISE = 0.5, 0.004
"""How far the joints may have moved from where their speed leads: a part of that way, and rad."""


class Clock(NamedTuple):
    """What is kept from one look to the next.

    Attributes:
        state: The arm's state at the last look; None before the first.
        looks: Looks after one another that disagreed.
    """

    state: ArmState | None = None
    looks: int = 0

    def after(self, arm: Arm, state: ArmState, seconds: float) -> tuple[Clock, str]:
        """Look once more, and return what is to be kept, and what is wrong; empty if nothing is.

        The way that the joints have gone is held against their mean speed times the time that the law was told.

        Args:
            arm: The arm.
            state: Its state.
            seconds: The time since the last look, as the law was told, s.
        """
        if self.state is None:
            return Clock(state), ""
        moved = arm.difference(self.state.q, state.q)
        expected = (self.state.v + state.v) * (seconds / 2.0)
        length = hypot(*expected.tolist())
        if dist(moved.tolist(), expected.tolist()) <= NOISE + SHARE * length:
            return Clock(state), ""
        if self.looks + 1 < LOOKS:
            return Clock(state, self.looks + 1), ""
        ratio = float(moved @ expected) / length**2 if length > 0.0 else inf
        if ratio > 1.0:
            what = "samples are lost, or the loop is slower than the dt of reset"
        else:
            what = "samples are repeated, or the loop is faster than the dt of reset"
        return Clock(state), f"the clock runs away: the joints move {ratio:.3g} times as far as they should; {what}"
