"""What follows from many samples of (q, v) at once."""

from __future__ import annotations

from typing import NamedTuple

from ..redundancy import Array


class StateSamples(NamedTuple):
    """The dynamics and kinematics of an arm at k samples of (q, v), as stacks.

    Attributes:
        M: Joint-space inertia matrices M(θ), shape (k, nv, nv), kg m².
        nle: Coriolis, centrifugal and gravity torques N(θ, θ̇), shape (k, nv), N m.
        J: Jacobians of the task coordinates, shape (k, m, nv).
        dJ: Their rates J̇ at θ̇, shape (k, m, nv), per s.
        x: Task values, shape (k, m), m; for a task with rotations (k, 7), position and quaternion.
    """

    M: Array
    nle: Array
    J: Array
    dJ: Array
    x: Array
