"""What the task is to do at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pinocchio as pin

from ..arm.tasks import TaskValue, task_of_value
from ..checks import finite_vector
from ..exceptions import ShapeError
from ..redundancy import Array

_new, _set = object.__new__, object.__setattr__


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """What the task is to do at one instant: copies of what is given, the arrays read-only.

    Attributes:
        x: Desired task value x_d: an array of shape (m,), m, or a `pin.SE3` for a task with rotations.
        dx: Desired velocity ẋ_d, shape (m,), m/s and rad/s; the rows of a frame's linear and angular velocity in the
            world frame.
        ddx: Desired acceleration ẍ_d, shape (m,), m/s² and rad/s²; the derivative of `dx`.

    Raises:
        ShapeError: If `dx` and `ddx`, and `x` where it is no pose, are not vectors of numbers of one length.
        NonFiniteError: If one holds NaN or infinity.
    """

    x: TaskValue
    dx: Array
    ddx: Array

    def __post_init__(self) -> None:
        """Check the three and keep copies."""
        is_pose = isinstance(self.x, pin.SE3)
        x = task_of_value(self.x).checked("target.x", self.x) if is_pose else finite_vector("target.x", self.x)
        dx, ddx = finite_vector("target.dx", self.dx), finite_vector("target.ddx", self.ddx)
        if dx.shape != ddx.shape or not (is_pose or x.shape == dx.shape):
            names, vectors = ("target.x, target.dx", (x, dx, ddx)) if not is_pose else ("target.dx", (dx, ddx))
            shapes = ", ".join(str(each.shape) for each in vectors)
            raise ShapeError(f"{names} and target.ddx must have one shape, got {shapes}")
        _set(self, "x", x)
        _set(self, "dx", dx)
        _set(self, "ddx", ddx)


def target_of_rows(rows: Array, pose: Any = None) -> Target:
    """Return the target of numbers that are known to be finite and belong to nobody else: nothing is copied.

    Args:
        rows: x_d, ẋ_d and ẍ_d, shape (3, m), float64; read-only from here on.
        pose: x_d of a task with rotations, a `pin.SE3`, in place of the first row.
    """
    rows.setflags(False)  # type: ignore[call-arg]  # as write=False in half the time
    target = _new(Target)
    _set(target, "x", rows[0] if pose is None else pose)
    _set(target, "dx", rows[1])
    _set(target, "ddx", rows[2])
    return target
