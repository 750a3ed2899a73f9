"""The quadratic programs of one sample: the torques that a task leaves open and the limits on them."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from ..redundancy import Array
from ..redundancy.compiled import MATRIX, NUMBER, VECTOR, compiled
from .qp_solver import Program

SCALE_WEIGHT = 1e4
"""How much more the task counts than the torque, when it must be scaled back; see `controllers.QPTorque`."""


SCALE_CURVATURE = 1e-3
"""Curvature of the cost in the scale, which makes it strictly convex."""


@compiled(VECTOR)
def _scale_unit(g: Array) -> float:
    """Return what s is multiplied by to stand beside η in the rows, N m."""
    unit = 1.0
    for entry in g:
        unit = max(unit, abs(entry))
    return unit


@compiled(MATRIX, VECTOR, VECTOR, VECTOR)
def task_scaled(A: Array, g: Array, lower: Array, upper: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return p, q, A, lower and upper of `Torques.task_scaled`."""
    rows, r = A.shape
    unit, largest = _scale_unit(g), 1.0
    wide, below, above = np.zeros((rows + 1, r + 1)), np.zeros(rows + 1), np.zeros(rows + 1)
    wide[:rows, :r], wide[:rows, r], wide[rows, r] = A, g / unit, 1.0
    below[:rows], above[:rows], above[rows] = lower, upper, unit
    for bounds in (lower, upper):
        for bound in bounds:
            if np.isfinite(bound):
                largest = max(largest, abs(bound))
    p, q = np.ones(r + 1), np.zeros(r + 1)
    p[r], q[r] = SCALE_CURVATURE, -SCALE_WEIGHT * largest
    return p, q, wide, below, above


@compiled(VECTOR, NUMBER)
def scale_of(g: Array, sigma: float) -> float:
    """Return s, the part of the task that is kept, of σ, which is s in N m."""
    s = min(max(sigma / _scale_unit(g), 0.0), 1.0)
    return 1.0 if s > 1.0 - 1e-9 else s


@compiled(VECTOR, VECTOR, VECTOR, VECTOR)
def no_torque_keeps_the_task(q: Array, upper: Array, x: Array, torque_limit: Array) -> bool:
    """Return whether the solution of `Torques.task_scaled` tells that `Torques.task_kept` has none.

    An η that kept the task would stand beside σ at its upper bound among the points of the scaled program. Its cost is
    no less than that of the solution, which bounds what σ lacks by ½‖η‖² / w, and ‖η‖ ≤ ‖τ‖ ≤ ‖τ_max‖.

    Args:
        q: Linear cost of the scaled program.
        upper: Its upper bounds.
        x: Its solution.
        torque_limit: τ_max, shape (n,), N m; infinite where there is none.
    """
    unit, weight = upper[-1], -q[-1]
    largest = 0.5 * np.sum(torque_limit**2)
    lacking = unit - x[-1]
    return bool(lacking > 1e-6 * unit and lacking * (weight - SCALE_CURVATURE * unit) > largest)


@cache
def _plain_cost(size: int) -> tuple[Array, Array]:
    return np.ones(size), np.zeros(size)


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

    @classmethod
    def in_buffer(cls, n: int, r: int) -> tuple[Torques, Array]:
        """Return torques of n joints that only the torque limits bound, and the buffer, one vector, that holds them."""
        buffer = np.zeros(n * (r + 4))
        Q, (c, d, lower, upper) = buffer[: n * r].reshape(n, r), buffer[n * r :].reshape(4, n)
        return cls(Q, c, d, Rows(Q, c, lower, upper)), buffer

    def task_kept(self) -> Program:
        """Minimise ½‖η‖² at s = 1."""
        A, g, lower, upper = self.rows
        p, q = _plain_cost(A.shape[1])
        return Program(p, q, A, lower - g, upper - g)

    def task_scaled(self) -> Program:
        """Minimise ½‖η‖² − w σ over η and σ, which is s in N m."""
        return Program(*task_scaled(*self.rows))

    def solution(self, x: Array) -> tuple[Array, float]:
        """Return η and s of a solution of one of the two."""
        r = self.Q.shape[1]
        if len(x) == r:
            return x, 1.0
        return x[:r], scale_of(self.rows.g, float(x[r]))
