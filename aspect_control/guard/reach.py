"""Whether an arm can reach all of a path, and where the path leaves what it can reach."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.inverse_kinematics import REACHED, Box, Nearest, damped_least_squares, joint_in_the_way, nearest_posture
from ..arm.tasks import TaskValue
from ..exceptions import ParameterError, ShapeError, shown
from ..redundancy import Array
from ..trajectories import Trajectory

STEP = 0.04
"""Distance between the points of a path that are looked at, as a part of the arm's reach, and in rad."""

MOST_POINTS = 1000
"""The most points of a path that are looked at."""

_SPEEDS = 25
"""Times at which the speed is looked at for the length of the path."""

_STARTS = 40
"""Random postures from which one is looked for, before a point counts as out of reach."""

_STARTS_AGAIN = 10
"""The same for a point next to which one is known already to be out of reach."""

_TIME = 1e-7
"""How exactly the time is found at which a path leaves, as a part of the duration."""


@dataclass(frozen=True, eq=False)
class Reach:
    """Whether an arm can reach all of a path.

    Attributes:
        reachable: Whether it can.
        t: When the path leaves what the arm can reach, s; None if it does not.
        s: How much of the path's length lies before that, 0 to 1; None if it does not leave.
        point: Where it leaves, a task value; None if it does not.
        distance: How far the arm stays short of the points of the path that were looked at, at the worst, m.
        angle: The same of the rotations, rad.
        joint: Name of the joint whose limit is in the way; None if none is, and without joint limits.
        message: All of it in words.
    """

    reachable: bool
    t: float | None
    s: float | None
    point: TaskValue | None
    distance: float
    angle: float
    joint: str | None
    message: str

    def __str__(self) -> str:
        """Say it in words."""
        return self.message


def check_reach(arm: Arm, trajectory: Trajectory, q0: ArrayLike, *, joint_limits: bool = True) -> Reach:
    """Look along a path for where it leaves what an arm can reach.

    At points of the path that are `STEP` apart a posture is looked for by inverse kinematics: damped least squares from
    the posture at the point before, and from random ones where that does not lead there. A point is out of reach if
    none of them does. Each point is looked at for itself: whether the arm can go from one to the next in one motion is
    not said. A path that leaves for less than the distance between two points may be missed.

    Args:
        arm: The arm.
        trajectory: What the task is to do; it starts where q0 puts the task frame.
        q0: Joint configuration at the start, shape (nq,), rad.
        joint_limits: Whether the joints must stay inside the limits of the robot's description; if not, prismatic
            joints too are free.

    Raises:
        ShapeError: If q0 has the wrong shape, or the trajectory another number of task coordinates than the arm.
        NonFiniteError: If q0 is not finite.
        ParameterError: If the arm or the trajectory is none, or the task lacks a coordinate that the trajectory needs.
    """
    if not isinstance(arm, Arm) or not isinstance(trajectory, Trajectory):
        raise ParameterError(f"reach is checked of an Arm and a Trajectory, got {shown(arm)} and {shown(trajectory)}")
    q = arm.joints.checked_configuration(q0)
    if trajectory.task_dim not in (None, arm.task_dim):
        raise ShapeError(
            f"the trajectory has {trajectory.task_dim} task coordinates, the arm's task {arm.task} has {arm.task_dim}"
        )
    search, path = _Search.of(arm, joint_limits), _Path.of(arm, trajectory, q)
    posture = np.clip(arm.positions(q), *search.box)
    for i, t in enumerate(path.times):
        nearest = search.anywhere(path.at(t), posture)
        if not nearest.reached:
            return _left(search, path, i, posture, nearest.positions)
        posture = nearest.positions
    return Reach(True, None, None, None, 0.0, 0.0, None, f"{arm.name!r} can reach all of the path")


class _Path(NamedTuple):
    """A path and the times at which it is looked at, evenly along its length.

    Attributes:
        arm: The arm.
        trajectory: What the task is to do.
        start: The task value at t = 0.
        scale: What a distance is measured in, one a task coordinate: the arm's reach, m, or 1 rad.
        times: When it is looked at, s.
    """

    arm: Arm
    trajectory: Trajectory
    start: TaskValue
    scale: Array
    times: list[float]

    @classmethod
    def of(cls, arm: Arm, trajectory: Trajectory, q: Array) -> _Path:
        start, duration = arm.task_position(q), trajectory.duration
        scale = np.ones(arm.task_dim)
        if 0.0 < arm.reach < np.inf:
            scale[arm.coordinates.position_rows] = arm.reach
        sampled = np.linspace(0.0, duration, _SPEEDS)
        targets = [trajectory.target(t, start, arm.coordinates) for t in sampled.tolist()]
        speeds = np.linalg.norm([target.dx / scale for target in targets], axis=1)
        lengths = np.append(0.0, np.cumsum((speeds[1:] + speeds[:-1]) / 2.0 * np.diff(sampled)))
        count = int(np.ceil(min(lengths[-1] / STEP, MOST_POINTS)))
        times = np.interp(np.linspace(0.0, lengths[-1], count + 1), lengths, sampled)
        return cls(arm, trajectory, start, scale, [*times[:-1].tolist(), duration])

    def at(self, t: float) -> TaskValue:
        return self.trajectory.target(t, self.start, self.arm.coordinates).x

    def share(self, t: float) -> float:
        """Return how much of the length lies before a time, 0 to 1."""
        times = sorted({*self.times, t})
        steps = [self.arm.coordinates.error(b, a) / self.scale for a, b in pairwise(map(self.at, times))]
        lengths = np.linalg.norm(steps, axis=1)
        return float(lengths[: times.index(t)].sum() / lengths.sum())


class _Search(NamedTuple):
    """How postures are looked for.

    Attributes:
        arm: The arm.
        box: Where the joints may be.
        rng: Where random starts come from.
        limited: Whether that is inside the joint limits.
    """

    arm: Arm
    box: Box
    rng: Any
    limited: bool

    @classmethod
    def of(cls, arm: Arm, joint_limits: bool) -> _Search:
        free = np.full(arm.nv, np.inf)
        box = arm.position_limits if joint_limits else (-free, free)
        return cls(arm, box, np.random.default_rng(0), joint_limits)

    def near(self, x: TaskValue, *postures: Array) -> Nearest:
        """Return the nearest posture to a task value on the way from some that are close already."""
        found = [damped_least_squares(self.arm, x, each, self.box) for each in postures]
        return min(found, key=lambda each: each.distance)

    def anywhere(self, x: TaskValue, posture: Array, starts: int = _STARTS) -> Nearest:
        """Return the nearest posture on the way from one, or from random ones if that does not lead there."""
        nearest = self.near(x, posture)
        if nearest.reached or self._is_too_far(x):
            return nearest
        return min(nearest, nearest_posture(self.arm, x, self.box, self.rng, starts), key=lambda each: each.distance)

    def _is_too_far(self, x: TaskValue) -> bool:
        """Return whether all links in a straight line are too short, so that no search is needed."""
        task = self.arm.coordinates
        position = x.translation[task.position_axes] if task.has_rotation else x
        distance = np.linalg.norm(position - np.array(self.arm.kinematics.first_joint_in_task))
        return bool(distance > self.arm.reach + 2.0 * REACHED) and (self.limited or not self.arm.prismatic.any())


def _left(search: _Search, path: _Path, first: int, inside: Array, beyond: Array) -> Reach:
    """Say where and how far a path leaves.

    Args:
        search: How postures are looked for.
        path: The path.
        first: Index of the first time at which it is out of reach.
        inside: A posture at the time before, shape (nv,), rad.
        beyond: The nearest posture at the first time, shape (nv,), rad.
    """
    arm, coordinates, times = path.arm, path.arm.coordinates, path.times
    x = path.at(times[first])
    limited = search.limited and _Search.of(arm, joint_limits=False).anywhere(x, beyond).reached
    joint = joint_in_the_way(arm, x, beyond, search.box) if limited else None
    t = _last_reachable(search, path, (times[first - 1], times[first]), inside, beyond) if first else 0.0
    point, share, distance, angle, posture = path.at(t), path.share(t), 0.0, 0.0, beyond
    for time in times[first:]:
        nearest = search.near(path.at(time), posture)
        posture = nearest.positions
        if not nearest.reached:
            distance = max(distance, float(np.linalg.norm(nearest.error[coordinates.position_rows])))
            angle = max(angle, float(np.linalg.norm(nearest.error[coordinates.rotation_rows])))
    where = point.translation if coordinates.has_rotation else point
    short = [f"{distance:.3g} m"] * (distance > 0.0) + [f"{angle:.3g} rad"] * (angle > 0.0)
    limits = "" if not limited else " inside its joint limits" + (f": joint {joint!r} is in the way" if joint else "")
    message = (
        f"the path leaves the workspace at t = {t:.6g} s, {100.0 * share:.3g} % along it, at "
        f"({', '.join(f'{each:.4g}' for each in where)}), and goes on to up to {' and '.join(short)} beyond what "
        f"{arm.name!r} can reach{limits}"
    )
    return Reach(False, t, share, point, distance, angle, joint, message)


def _last_reachable(search: _Search, path: _Path, times: tuple[float, float], inside: Array, beyond: Array) -> float:
    """Return the last time at which a path can be reached, between one at which it can and one at which it cannot.

    Postures close to both are enough to go by, until they say that there is none any more; then all are looked at.
    """
    earlier, later = times
    first_beyond = later
    while later - earlier > _TIME * path.trajectory.duration:
        middle = (earlier + later) / 2.0
        nearest = search.near(path.at(middle), inside, beyond)
        if nearest.reached:
            earlier, inside = middle, nearest.positions
        else:
            later, beyond = middle, nearest.positions
        if later - earlier <= _TIME * path.trajectory.duration and later < first_beyond:
            nearest = search.anywhere(path.at(later), inside, _STARTS_AGAIN)
            if nearest.reached:
                earlier, later, inside = later, first_beyond, nearest.positions
    return earlier
