"""What a torque law needs to know of an arm at one state."""

from __future__ import annotations

from typing import NamedTuple

from ..redundancy import Array
from .tasks import TaskValue


class ArmState(NamedTuple):
    """Everything that a torque law needs at (q, v). Its arrays are read-only.

    Rows of J, drift and dx are the task coordinates: positions in m, rotations in rad, world frame.

    Attributes:
        q: Joint configuration θ, shape (nq,), rad (m for prismatic joints, cosine and sine for continuous ones).
        v: Joint velocity θ̇, shape (nv,), rad/s.
        M: Joint-space inertia matrix M(θ), shape (nv, nv), kg m².
        nle: Coriolis, centrifugal and gravity torques N(θ, θ̇), shape (nv,), N m.
        J: Jacobian of the task coordinates, shape (m, nv).
        drift: J̇θ̇, the task acceleration at θ̈ = 0, shape (m,), m/s² and rad/s².
        x: Task value: shape (m,), m, for a task of positions; a `pin.SE3` for one with rotations.
    """

    q: Array
    v: Array
    M: Array
    nle: Array
    J: Array
    drift: Array
    x: TaskValue

    @property
    def dx(self) -> Array:
        """Task velocity ẋ = Jθ̇, shape (m,), m/s and rad/s."""
        velocity: Array = self.J @ self.v
        return velocity
