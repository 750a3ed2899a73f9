"""What the task is to do at one instant."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..checks import finite_vector
from ..exceptions import ShapeError
from ..redundancy import Array
from ..tasks import TaskValue, task_of_value


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """What the task is to do at one instant.

    Attributes:
        x: Desired task value x_d: an array of shape (m,), m, or a `pin.SE3` for a task with rotations.
        dx: Desired velocity ẋ_d, shape (m,), m/s and rad/s; the rows of a frame's linear and angular velocity in the
            world frame.
        ddx: Desired acceleration ẍ_d, shape (m,), m/s² and rad/s²; the derivative of `dx`.
        rows: The three in one array, shape (3, m), of which `dx`, `ddx` and an `x` that is no pose are the rows; zeros
            in place of a pose.
        is_pose: Whether `x` is a pose.

    Raises:
        ShapeError: If `dx` and `ddx`, and `x` where it is no pose, are not vectors of one length.
        NonFiniteError: If one holds NaN or infinity.
    """

    x: TaskValue
    dx: Array
    ddx: Array
    rows: Array = field(init=False, repr=False)
    is_pose: bool = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the three and turn them into copies: arrays, or a pose."""
        is_pose = isinstance(self.x, pin.SE3)
        rows = None if is_pose else _usual_rows(self.x, self.dx, self.ddx)
        x, rows = (None, rows) if rows is not None else _checked(self.x, self.dx, self.ddx, is_pose)
        object.__setattr__(self, "rows", rows)
        object.__setattr__(self, "is_pose", is_pose)
        object.__setattr__(self, "x", x if is_pose else rows[0])
        object.__setattr__(self, "dx", rows[1])
        object.__setattr__(self, "ddx", rows[2])


def _usual_rows(*vectors: ArrayLike) -> Array | None:
    """Return three vectors of one length and finite entries as one array; None for anything else."""
    try:
        rows = np.array(vectors, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return rows if rows.ndim == 2 and isfinite(sum(rows.ravel().tolist())) else None


def _checked(x: TaskValue, dx: ArrayLike, ddx: ArrayLike, is_pose: bool) -> tuple[TaskValue, Array]:
    """Return x, and the rows of `Target.rows`, after checking one after the other."""
    x = task_of_value(x).checked("target.x", x) if is_pose else finite_vector("target.x", x)
    dx, ddx = finite_vector("target.dx", dx), finite_vector("target.ddx", ddx)
    if dx.shape != ddx.shape or not (is_pose or x.shape == dx.shape):
        vectors = {"target.x": x, "target.dx": dx, "target.ddx": ddx}
        *first, last = [name for name in vectors if not (is_pose and name == "target.x")]
        shapes = ", ".join(str(vectors[name].shape) for name in (*first, last))
        raise ShapeError(f"{', '.join(first)} and {last} must have one shape, got {shapes}")
    return x, np.array((np.zeros(len(dx)) if is_pose else x, dx, ddx))
