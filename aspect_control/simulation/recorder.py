"""The arrays that a run fills sample by sample."""

from __future__ import annotations

import numpy as np

from ..arm import Arm
from ..redundancy import Array
from ..trajectories import Target
from .run import Run
from .run_file import RunInfo


class Recorder:
    """A recording in the making.

    Attributes:
        t: Times of all samples that the motion has, shape (k,), s.
        count: Number of samples recorded so far.
    """

    def __init__(self, arm: Arm, t: Array) -> None:
        """Make room for the samples at the times t."""
        self.t = t
        self.count = 0
        self._arm = arm
        samples, m = len(t), arm.task_dim
        self._q, self._v, self._tau = (
            np.empty((samples, arm.nq)),
            np.empty((samples, arm.nv)),
            np.empty((samples, arm.nv)),
        )
        self._x = np.empty((samples, arm.coordinates.encoded_size))
        self._dx, self._ddx = np.empty((samples, m)), np.empty((samples, m))

    def add(self, q: Array, v: Array, tau: Array, target: Target) -> None:
        """Record one sample: q (nq,), v (nv,), tau (nv,) as applied, and the target."""
        i = self.count
        self._q[i], self._v[i], self._tau[i] = q, v, tau
        self._x[i] = self._arm.coordinates.encode(target.x)
        self._dx[i], self._ddx[i] = target.dx, target.ddx
        self.count += 1

    def run(self, info: RunInfo) -> Run:
        """Return what was recorded as a run."""
        done = slice(self.count)
        return Run(
            t=self.t[done],
            q=self._q[done],
            v=self._v[done],
            tau=self._tau[done],
            x_desired=self._x[done],
            dx_desired=self._dx[done],
            ddx_desired=self._ddx[done],
            arm=self._arm,
            info=info,
        )
