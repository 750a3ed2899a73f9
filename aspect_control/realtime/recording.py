"""The recording of a loop whose end is not known beforehand."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..redundancy import Array
from ..simulation import Run, RunInfo
from ..simulation.recorder import Recorder
from ..simulation.run_file import ARRAYS
from ..trajectories import Target

BLOCK = 10_000
"""Samples that room is made for at a time."""


class Recording:
    """A recording in the making, in blocks: nothing is copied while the loop runs.

    Attributes:
        count: Number of samples recorded so far.
        last: Configuration, shape (nq,), rad, and torque, shape (nv,), N m, that were last sent to the robot, whether
            or not they came to be recorded; None before.
    """

    def __init__(self, arm: Arm) -> None:
        """Make room for the first block."""
        self.count = 0
        self.last: tuple[ArrayLike, Array] | None = None
        self._arm = arm
        self._blocks = [self._block()]

    def add(self, t: float, q: ArrayLike, v: ArrayLike, tau: Array, target: Target) -> tuple[Array, Array]:
        """Record one sample: its time, s, q (nq,), v (nv,), tau (nv,) as written, and the target.

        Returns:
            q and v as they were recorded, read-only.
        """
        block = self._blocks[-1]
        if block.count == BLOCK:
            block = self._block()
            self._blocks.append(block)
        block.t[block.count] = t
        self.count += 1
        return block.add(np.asarray(q), np.asarray(v), tau, target)

    def run(self, info: RunInfo, error: BaseException | None) -> Run:
        """Return what was recorded as a run, with what was raised to end it, if anything."""
        parts = [block.run(info) for block in self._blocks]
        arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ARRAYS}
        return Run(**arrays, arm=self._arm, info=info, error=error)

    def _block(self) -> Recorder:
        return Recorder(self._arm, np.empty(BLOCK))
