"""Task coordinates: which coordinates of a frame's pose the task is about, and how they are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import pinocchio as pin

from ..checks import finite_vector
from ..exceptions import NonFiniteError, ShapeError, TaskError
from ..redundancy import Array

POSITION_AXES = ("x", "y", "z")
"""The coordinates of a frame's position in the world frame, m."""

ROTATION_AXES = ("rx", "ry", "rz")
"""Rotations of a frame about the axes of the world frame, rad."""

AXES = POSITION_AXES + ROTATION_AXES
"""All task coordinates, in the order of the rows of Pinocchio's frame Jacobian."""

NAMED_TASKS = {
    "xy": ("x", "y"),
    "xz": ("x", "z"),
    "yz": ("y", "z"),
    "xyz": POSITION_AXES,
    "pose": AXES,
}
"""Tasks that have a name of their own."""

TaskChoice: TypeAlias = str | Sequence[str]
"""A name of `NAMED_TASKS`, or distinct coordinates from `AXES`."""

TaskValue: TypeAlias = Any
"""Where the task frame is: an array of shape (m,), m, for a task of positions; a `pin.SE3` for one with rotations."""


@dataclass(frozen=True)
class Task:
    """A choice of task coordinates.

    Attributes:
        axes: The coordinates, from `AXES`, in the order of the task's rows.
    """

    axes: tuple[str, ...]

    @classmethod
    def parse(cls, task: TaskChoice) -> Task:
        """Return the task that a name or a sequence of coordinates stands for.

        Args:
            task: A name of `NAMED_TASKS`, or a sequence of distinct coordinates from `AXES`.

        Raises:
            TaskError: If it is neither.
        """
        if isinstance(task, str):
            if task in NAMED_TASKS:
                return cls(NAMED_TASKS[task])
        elif isinstance(task, Sequence):
            axes = tuple(axis for axis in task if isinstance(axis, str) and axis in AXES)
            if 0 < len(set(axes)) == len(task):
                return cls(axes)
        also = f"or a sequence of distinct coordinates from {', '.join(map(repr, AXES))}"
        raise TaskError(task, NAMED_TASKS, also=also)

    @cached_property
    def rows(self) -> list[int]:
        """Which rows of a frame's six-dimensional motion (linear, then angular, world frame) belong to the task."""
        return [AXES.index(axis) for axis in self.axes]

    @cached_property
    def selection(self) -> slice | list[int]:
        """The same rows as an index: a slice where they follow one another, which is faster."""
        first, last = self.rows[0], self.rows[-1] + 1
        return slice(first, last) if self.rows == list(range(first, last)) else self.rows

    @cached_property
    def has_rotation(self) -> bool:
        """Whether a rotation is among the coordinates, so that the task's values are poses."""
        return any(axis in ROTATION_AXES for axis in self.axes)

    @cached_property
    def position_rows(self) -> list[int]:
        """Which of the task's own rows are positions."""
        return [row for row, axis in enumerate(self.axes) if axis in POSITION_AXES]

    @cached_property
    def position_axes(self) -> list[int]:
        """Which of the axes x, y and z, counted from 0, those are."""
        return [self.rows[row] for row in self.position_rows]

    @cached_property
    def rotation_rows(self) -> list[int]:
        """Which of the task's own rows are rotations."""
        return [row for row, axis in enumerate(self.axes) if axis in ROTATION_AXES]

    @cached_property
    def dim(self) -> int:
        """Number of task coordinates m."""
        return len(self.axes)

    def value(self, pose: Any) -> TaskValue:
        """Return the task value of a frame's pose, a `pin.SE3` in the world frame; the result is a copy."""
        return pose.copy() if self.has_rotation else pose.translation[self.selection].copy()

    def error(self, desired: TaskValue, actual: TaskValue) -> Array:
        """Return x_d − x, shape (m,), m and rad.

        The rotation rows are those of the rotation vector log(R_d Rᵀ) in the world frame: the shortest rotation from
        the actual to the desired orientation.

        Args:
            desired: Task value x_d.
            actual: Task value x.
        """
        if not self.has_rotation:
            difference: Array = desired - actual
            return difference
        rotation = pin.log3(desired.rotation @ actual.rotation.T)
        return np.concatenate([desired.translation - actual.translation, rotation])[self.selection]

    def displaced(self, start: TaskValue, displacement: Array) -> TaskValue:
        """Return the task value that `displacement` leads to from `start`: the inverse of `error`.

        Args:
            start: Task value.
            displacement: Shape (m,), m and rad; the rotation rows are a rotation vector in the world frame.
        """
        if not self.has_rotation:
            return start + displacement
        motion = np.zeros(6)
        motion[self.rows] = displacement
        return pin.SE3(pin.exp3(motion[3:]) @ start.rotation, start.translation + motion[:3])

    @cached_property
    def encoded_size(self) -> int:
        """Length of an encoded task value: m, or 7 for a task with rotations."""
        return 7 if self.has_rotation else self.dim

    def encode(self, value: TaskValue) -> Array:
        """Return a task value as numbers: positions as they are, a pose as x, y, z and a unit quaternion x, y, z, w."""
        numbers: Array = pin.SE3ToXYZQUAT(value) if self.has_rotation else value
        return numbers

    def decode(self, numbers: Array) -> TaskValue:
        """Return the task value that `encode` turned into numbers."""
        return pin.XYZQUATToSE3(numbers) if self.has_rotation else numbers

    def checked(self, name: str, value: TaskValue) -> TaskValue:
        """Return a copy of a task value after checking its kind.

        Args:
            name: What the value is called in the error.
            value: The value.

        Raises:
            ShapeError: If it is no array of shape (m,), or no `pin.SE3` for a task with rotations.
            NonFiniteError: If it is not finite.
        """
        if not self.has_rotation:
            return finite_vector(name, value, self.dim)
        if not isinstance(value, pin.SE3):
            raise ShapeError(f"{name} must be a pin.SE3 for the task {self.axes}, got {type(value).__name__}")
        if not np.isfinite(value.homogeneous).all():
            raise NonFiniteError(f"{name} must be finite, got {value.homogeneous.tolist()}")
        return value.copy()


def task_of_value(value: TaskValue) -> Task:
    """Return the task that a bare value suggests: `pose` for a `pin.SE3`, the first position axes for an array."""
    if isinstance(value, pin.SE3):
        return Task(AXES)
    return Task(POSITION_AXES[: len(value)])
