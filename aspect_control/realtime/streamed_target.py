"""Targets that arrive at any time, made smooth: limited speed, acceleration and jerk."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.tasks import Task, TaskValue
from ..checks import read_only, real_array
from ..exceptions import ParameterError, ShapeError
from ..redundancy import Array
from ..trajectories import Target
from ..trajectories.rotation_vector import angular_motion
from ..trajectories.target import target_of_rows


class StreamedTarget:
    """The motion towards the newest target, as quick as the limits of each task coordinate allow.

    Ruckig (L. Berscheid and T. Kröger, "Jerk-limited real-time trajectory generation with arbitrary target states",
    Robotics: Science and Systems, 2021) plans from the present position, velocity and acceleration to rest at the
    target; a new target takes over wherever the motion is, without a step in any of the three. Orientations go along
    the rotation vector from the present orientation to that of the target, whose entries the limits hold for: the
    angular velocity and acceleration along it differ from these while the axis of rotation changes.
    """

    def __init__(
        self, task: Task, start: TaskValue, *, speed: ArrayLike, acceleration: ArrayLike, jerk: ArrayLike
    ) -> None:
        """Stand still at the start, at t = 0.

        Args:
            task: The task.
            start: Task value: shape (m,), m, or a `pin.SE3` for a task with rotations.
            speed: Largest |ẋ_d|, m/s and rad/s, a number or one a task coordinate.
            acceleration: Largest |ẍ_d|, m/s² and rad/s², likewise.
            jerk: Largest rate of ẍ_d, m/s³ and rad/s³, likewise.

        Raises:
            ParameterError: If a limit is not above zero and finite.
            ShapeError: If a limit is neither a number nor one a task coordinate, or the start no value of the task.
            NonFiniteError: If the start is not finite.
            ImportError: If ruckig is not installed.
        """
        ruckig = _ruckig()
        self._task = task
        self._input = ruckig.InputParameter(task.dim)
        self._input.max_velocity = _limit("speed", speed, task.dim)
        self._input.max_acceleration = _limit("acceleration", acceleration, task.dim)
        self._input.max_jerk = _limit("jerk", jerk, task.dim)
        self._planner, self._new_plan = ruckig.Ruckig(task.dim), ruckig.Trajectory
        self._base, self._begin = task.checked("start", start), 0.0
        self._plan = self._planned(np.zeros((3, task.dim)), np.zeros(task.dim))

    def go_to(self, t: float, x: TaskValue) -> None:
        """Head for another target from time t on, s; `x` is a task value.

        Raises:
            ShapeError: If x is no value of the task.
            NonFiniteError: If it is not finite.
        """
        x = self._task.checked("the streamed target", x)
        now = self.target(t)
        self._plan = self._planned(np.array([np.zeros_like(now.dx), now.dx, now.ddx]), self._task.error(x, now.x))
        self._base, self._begin = now.x, t

    def target(self, t: float) -> Target:
        """Return the target at a time, s, not before the last call of `go_to`."""
        rows = np.array(self._plan.at_time(t - self._begin))
        if not self._task.has_rotation:
            rows[0] += self._base
            return target_of_rows(rows)
        pose, turning = self._task.displaced(self._base, rows[0]), self._task.rotation_rows
        vectors = np.zeros((3, 3))
        vectors[:, [self._task.rows[row] - 3 for row in turning]] = rows[:, turning]
        angular = np.array(angular_motion(*vectors))
        rows[1:, turning] = angular[:, [self._task.rows[row] - 3 for row in turning]]
        return target_of_rows(rows, pose)

    def arrived(self, t: float) -> bool:
        """Tell whether the target stands still at a time, s."""
        return bool(t - self._begin >= self._plan.duration)

    def _planned(self, present: Array, displacement: Array) -> Any:
        given, plan = self._input, self._new_plan(self._task.dim)
        given.current_position, given.current_velocity, given.current_acceleration = present
        given.target_position = displacement
        if self._planner.calculate(given, plan).value < 0:
            raise ParameterError(f"no motion within the limits leads to a streamed target {displacement} away")
        return plan


def _limit(name: str, value: ArrayLike, size: int) -> Array:
    limit = np.atleast_1d(real_array(name, value, "a number or one a task coordinate"))
    if limit.ndim != 1 or len(limit) not in (1, size):
        raise ShapeError(f"{name} must be a number or one for each of {size} task coordinates, got {limit.shape}")
    if not (np.isfinite(limit) & (limit > 0.0)).all():
        raise ParameterError(f"{name} must be finite and above 0, got {limit.tolist()}")
    return read_only(np.array(np.broadcast_to(limit, (size,))))


def _ruckig() -> Any:
    try:
        import ruckig
    except ImportError as error:
        raise ImportError("streamed targets need ruckig: pip install 'aspect-control[realtime]'") from error
    return ruckig
