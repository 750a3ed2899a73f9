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
        self._arm, self._encoded = arm, arm.coordinates.encode
        k, m = len(t), arm.task_dim
        self._q, self._v, self._tau = (np.empty((k, size)) for size in (arm.nq, arm.nv, arm.nv))
        self._x = np.empty((k, arm.coordinates.encoded_size))
        self._dx, self._ddx = np.empty((k, m)), np.empty((k, m))
        self._shown_q, self._shown_v = read_only_view(self._q), read_only_view(self._v)

    @property
    def last(self) -> float:
        """Time of the last sample recorded, s."""
        return float(self.t[self.count - 1])

    def add(self, q: Array, v: Array, tau: Array, target: Target) -> tuple[Array, Array]:
        """Record one sample: q (nq,), v (nv,), tau (nv,) as applied, and the target.

        Returns:
            q and v as they were recorded, read-only.
        """
        i = self.count
        self._q[i], self._v[i], self._tau[i] = q, v, tau
        self._x[i] = self._encoded(target.x)
        self._dx[i], self._ddx[i] = target.dx, target.ddx
        self.count += 1
        return self._shown_q[i], self._shown_v[i]

    def run(self, info: RunInfo, error: BaseException | None = None) -> Run:
        """Return what was recorded as a run, with what was raised to end it, if anything."""
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
            error=error,
        )


def read_only_view(array: Array) -> Array:
    """Return a view of an array through which it cannot be changed."""
    view: Array = array[:]
    view.setflags(write=False)
    return view
