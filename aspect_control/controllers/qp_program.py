"""The quadratic programs of one sample: the torques that a task leaves open and the limits on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..redundancy import Array
from ..redundancy.open_torques import open_torque
from .qp_solver import Program

SCALE_WEIGHT = 1e4
"""How much more the task counts than the torque, when it must be scaled back; see `controllers.QPTorque`."""


class Rows(NamedTuple):
    """Limits on the torques of the tasks s b: lower ≤ A η + s g ≤ upper."""

    A: Array
    g: Array
    lower: Array
    upper: Array

    def unit(self) -> Rows:
        """Return the same limits with rows of A of length 1, those aside that are as good as zero."""
        length = np.linalg.norm(self.A, axis=1)
        factor = 1.0 / np.maximum(length, 1e-3 * length.max()) if length.any() else np.ones(len(length))
        return Rows(self.A * factor[:, None], self.g * factor, self.lower * factor, self.upper * factor)

    @staticmethod
    def stack(rows: list[Rows], columns: int) -> Rows:
        """Return all rows as one."""
        if len(rows) == 1:
            return rows[0]
        empty = Rows(np.zeros((0, columns)), *np.zeros((3, 0)))
        return Rows(*(np.concatenate(parts) for parts in zip(empty, *rows, strict=True)))


class Torques(NamedTuple):
    """The torques of the tasks s b: τ = Q η + s c + d with Qᵀc = Qᵀd = 0, and the limits on them."""

    Q: Array
    c: Array
    d: Array
    rows: Rows

    @property
    def scale_unit(self) -> float:
        """What s is multiplied by to stand beside η in the rows, N m."""
        return max(1.0, float(np.abs(self.rows.g).max(initial=0.0)))

    def task_kept(self) -> Program:
        """Minimise ½‖η‖² at s = 1."""
        A, g, lower, upper = self.rows
        r = A.shape[1]
        return Program(np.ones(r), np.zeros(r), A, lower - g, upper - g)

    def task_scaled(self) -> Program:
        """Minimise ½‖η‖² − w σ over η and σ, which is s in N m."""
        A, g, lower, upper = self.rows
        r, unit = A.shape[1], self.scale_unit
        wide = np.block([[A, g[:, None] / unit], [np.zeros(r), 1.0]])
        finite = np.abs(np.concatenate((lower, upper)))
        weight = SCALE_WEIGHT * max(1.0, float(finite[np.isfinite(finite)].max(initial=0.0)))
        return Program(
            np.append(np.ones(r), 1e-3),
            np.append(np.zeros(r), -weight),
            wide,
            np.append(lower, 0.0),
            np.append(upper, unit),
        )

    def solution(self, x: Array) -> tuple[Array, float]:
        """Return τ and s of a solution of one of the two."""
        r = self.Q.shape[1]
        s = 1.0 if len(x) == r else min(max(float(x[r]) / self.scale_unit, 0.0), 1.0)
        if s > 1.0 - 1e-9:
            s = 1.0
        tau: Array = open_torque(self.Q, self.c, self.d, np.append(x[:r], s))
        return tau, s
