"""What a guard looks at every 25 ms, for it changes slowly or is seen only over a while."""

from __future__ import annotations

from math import dist, hypot, isfinite
from typing import NamedTuple

import numpy as np

from ..arm import Arm, ArmState
from ..redundancy import Array
from ..trajectories import Target
from .bounds import GuardLimits
from .clock import Clock
from .divergence import Growth
from .viability import BRAKE_TIME

PERIOD = 0.025
"""Time between two looks, s."""

RANK = 0.01
"""Smallest singular value of J, in parts of the largest one, that a law is left alone with."""


class Watch(NamedTuple):
    """What is kept from one look to the next.

    Attributes:
        growth: Of the self-motion and of the energy.
        clock: Where the arm was.
        smallest: Smallest singular value of J, in parts of the largest one; infinite before the first look.
    """

    growth: Growth = Growth()
    clock: Clock = Clock()
    smallest: float = np.inf


class Monitor:
    """Looks at the rank of J, at what the target asks of the joints, at the self-motion and at the clock."""

    def __init__(self, arm: Arm, limits: GuardLimits) -> None:
        """Set the arm and the limits."""
        self._arm, self._limits = arm, limits

    @staticmethod
    def samples(dt: float) -> int:
        """Return how many samples of Δt there are from one look to the next."""
        return max(1, round(PERIOD / dt))

    def look(self, watch: Watch, state: ArmState, target: Target, dt: float) -> tuple[Watch, str]:
        """Return what is to be kept, and what is wrong; empty if nothing is.

        Args:
            watch: What the last look kept.
            state: The arm's state.
            target: What the task is to do.
            dt: Δt, s.
        """
        seconds = self.samples(dt) * dt
        U, sigma, Vt = np.linalg.svd(state.J, full_matrices=False)
        smallest = float(sigma[-1] / sigma[0])
        rank = self._of_rank(smallest, watch.smallest, seconds)
        of_task = Vt.T @ ((U.T @ target.dx) / np.maximum(sigma, RANK * sigma[0]))
        growth, divergence = watch.growth.after(state.v, state.M, Vt, of_task)
        clock, lost = watch.clock.after(self._arm, state, seconds)
        turned = self.not_tracked(state, target) if self._arm.coordinates.has_rotation else ""
        reason = self.too_far(target) or turned or divergence or lost or rank or self._too_fast(of_task)
        return Watch(growth, clock, smallest), reason

    def too_far(self, target: Target) -> str:
        """Return that a target is farther from the first joint than the limit; empty if it is not."""
        task, first = self._arm.coordinates, self._arm.kinematics.first_joint_in_task
        x = target.x.translation[task.position_axes] if task.has_rotation else target.x
        distance = dist(x.tolist(), first)
        if distance <= self._limits.distance * (1.0 + 1e-9):
            return ""
        return (
            f"the target is out of reach: it is {distance:.4g} m from the first joint, "
            f"{self._limits.distance:.4g} m are possible"
        )

    def not_tracked(self, state: ArmState, target: Target, most: float | None = None) -> str:
        """Return that the task frame is farther from its target than `most`, or the limit; empty if it is not."""
        task, most = self._arm.coordinates, self._limits.tracking if most is None else most
        error = task.error(target.x, state.x)
        for rows, unit in ((task.position_rows, "m"), (task.rotation_rows, "rad")):
            distance = hypot(*error[rows].tolist())
            if distance > most:
                return f"{self._arm.frame!r} is {distance:.3g} {unit} from its target, {most:.3g} {unit} are allowed"
        return ""

    def _too_fast(self, of_task: Array) -> str:
        """Return that the target asks a joint for more than its speed; empty if it does not."""
        names, speeds = self._limits.names, of_task.tolist()
        for name, speed, limit in zip(names, speeds, self._limits.speed.tolist(), strict=True):
            if abs(speed) > limit:
                return (
                    f"the target cannot be followed from here: joint {name!r} would have to move at "
                    f"{abs(speed):.3g} rad/s, its speed limit is {limit:.4g} rad/s"
                )
        return ""

    def _of_rank(self, smallest: float, before: float, seconds: float) -> str:
        """Return that J loses its rank before the arm could be stopped, at the pace of the last look."""
        pace = max(0.0, before - smallest) / seconds if isfinite(before) else 0.0
        if smallest - pace * BRAKE_TIME >= RANK:
            return ""
        return (
            f"the Jacobian is losing its rank: its smallest singular value is {smallest:.3g} of its largest, and "
            f"{RANK:g} is reached within {BRAKE_TIME:g} s: the arm is stretched out, or its axes line up, and the "
            "target leads out of its reach"
        )
