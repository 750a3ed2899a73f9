"""What the task is to do at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..checks import finite_vector
from ..exceptions import ShapeError
from ..redundancy import Array
from ..tasks import TaskValue, task_of_value

_NAMES = ("target.x", "target.dx", "target.ddx")
_set = object.__setattr__


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
        x = task_of_value(self.x).checked("target.x", self.x) if is_pose else _read_only("target.x", self.x)
        vectors = [_read_only("target.dx", self.dx), _read_only("target.ddx", self.ddx)]
        compared = dict(zip(_NAMES[is_pose:], vectors if is_pose else [x, *vectors], strict=True))
        if len({each.shape for each in compared.values()}) > 1:
            *first, last = compared
            shapes = ", ".join(str(each.shape) for each in compared.values())
            raise ShapeError(f"{', '.join(first)} and {last} must have one shape, got {shapes}")
        _set(self, "x", x)
        _set(self, "dx", vectors[0])
        _set(self, "ddx", vectors[1])

    @property
    def rows(self) -> Array:
        """The three in one array, shape (3, m); zeros in place of a pose."""
        return np.array((np.zeros(len(self.dx)) if self.is_pose else self.x, self.dx, self.ddx))

    @property
    def is_pose(self) -> bool:
        """Whether `x` is a pose."""
        return isinstance(self.x, pin.SE3)


def target_of_rows(rows: Array, pose: Any = None) -> Target:
    """Return the target of numbers that are known to be finite and belong to nobody else: nothing is copied.

    Args:
        rows: x_d, ẋ_d and ẍ_d, shape (3, m), float64; read-only from here on.
        pose: x_d of a task with rotations, a `pin.SE3`, in place of the first row.
    """
    rows.setflags(write=False)
    target = object.__new__(Target)
    _set(target, "x", rows[0] if pose is None else pose)
    _set(target, "dx", rows[1])
    _set(target, "ddx", rows[2])
    return target


def _read_only(name: str, value: ArrayLike) -> Array:
    vector = finite_vector(name, value)
    vector.setflags(write=False)
    return vector
