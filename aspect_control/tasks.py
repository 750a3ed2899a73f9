"""Task coordinates: which rows of a frame's motion the task is about."""

from __future__ import annotations

from collections.abc import Sequence

from .exceptions import TaskError

AXES = ("x", "y", "z")
"""The coordinates of a frame's position in the world frame, m."""

NAMED_TASKS = {"xy": ("x", "y"), "xz": ("x", "z"), "yz": ("y", "z"), "xyz": AXES}
"""Tasks that have a name of their own."""


def task_axes(task: str | Sequence[str]) -> tuple[str, ...]:
    """Return the task coordinates that `task` stands for.

    Args:
        task: A name of `NAMED_TASKS`, or a sequence of distinct coordinates from `AXES`.

    Returns:
        The coordinates, in the order in which the task's rows stand.

    Raises:
        TaskError: If it is neither.
    """
    if isinstance(task, str):
        if task in NAMED_TASKS:
            return NAMED_TASKS[task]
    elif isinstance(task, Sequence) and task and all(axis in AXES and list(task).count(axis) == 1 for axis in task):
        return tuple(task)
    raise TaskError(task, NAMED_TASKS, also="or a sequence of distinct coordinates from 'x', 'y', 'z'")
