"""Whether an arm can reach all of a path, and where the path leaves what it can reach."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.inverse_kinematics import Nearest, PostureSearch
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

_STARTS_AT_BORDER = 10
"""Random postures that are tried for a point next to one out of reach."""

_TIME = 1e-6
"""How exactly the time is found at which a path leaves, as a part of the duration."""


@dataclass(frozen=True, eq=False)
class Reach:
    """Whether an arm can reach all of a path.

    Attributes:
        reachable: Whether it can.
        t: When the path leaves what the arm can reach, s; None if it does not.
        s: How much of the path's length lies before that, 0 to 1; None if it does not leave.
        point: Where it leaves, a task value; None if it does not.
        distance: How far the arm stays short of the path where it stays shortest, m; 0 if the path does not leave.
        angle: The rotation that it stays short of there, rad.
        joint: Name of the joint whose limit is in the way where the path leaves; None if none is.
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
    search, path = PostureSearch(arm, joint_limits=joint_limits), _Path.of(arm, trajectory, q)
    posture = np.clip(arm.positions(q), *search.box)
    for i, t in enumerate(path.times):
        nearest, limited = search.decide(path.at(t), posture)
        if not nearest.reached:
            return _left(search, path, i, posture, nearest, limited)
        posture = nearest.positions
    return Reach(True, None, None, None, 0.0, 0.0, None, f"{arm.name!r} can reach all of the path")


def out_of_reach(arm: Arm, x: TaskValue, q: ArrayLike, *, joint_limits: bool = True) -> str | None:
    """Return in words that a task value is beyond what an arm can reach, or None if it is not.

    Args:
        arm: The arm.
        x: Task value: shape (m,), m, or a `pin.SE3` for a task with rotations.
        q: Joint configuration to look from first, shape (nq,), rad; the nearer, the faster.
        joint_limits: As for `check_reach`.

    Raises:
        ShapeError: If x or q has the wrong shape.
        NonFiniteError: If x or q is not finite.
    """
    search, x = PostureSearch(arm, joint_limits=joint_limits), arm.coordinates.checked("x", x)
    nearest, limited = search.decide(x, np.clip(arm.positions(q), *search.box))
    if nearest.reached:
        return None
    nearest = search.settle(x, nearest)
    joint = search.joint_in_the_way(nearest) if limited else None
    return f"the target {_shown(arm, x)} is {_beyond(arm, *_short(arm, nearest), limited)}{_at_limit(joint)}"


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
        between = np.interp(np.linspace(0.0, lengths[-1], count + 1)[1:-1], lengths, sampled)
        return cls(arm, trajectory, start, scale, [0.0, *between.tolist(), duration])

    def at(self, t: float) -> TaskValue:
        return self.trajectory.target(t, self.start, self.arm.coordinates).x

    def share(self, t: float) -> float:
        """Return how much of the length lies before a time, 0 to 1."""
        times = sorted({*self.times, t})
        steps = [self.arm.coordinates.error(b, a) / self.scale for a, b in pairwise(map(self.at, times))]
        lengths = np.linalg.norm(steps, axis=1)
        before = float(lengths[: times.index(t)].sum())
        return before / float(lengths.sum()) if before else 0.0


def _left(search: PostureSearch, path: _Path, first: int, inside: Array, beyond: Nearest, limited: bool) -> Reach:
    """Say where and how far a path leaves.

    Args:
        search: How postures are looked for.
        path: The path.
        first: Index of the first time at which it is out of reach.
        inside: A posture at the time before, shape (nv,), rad.
        beyond: The nearest posture at the first time.
        limited: Whether joint limits alone are in the way then.
    """
    arm, times = path.arm, path.times
    joint = search.joint_in_the_way(beyond) if limited else None
    t = _last_reachable(search, path, (times[first - 1], times[first]), inside, beyond.positions) if first else 0.0
    point, share = path.at(t), path.share(t)
    distance, angle = _short(arm, _farthest(search, path, times[first:], beyond))
    message = (
        f"the path leaves the workspace at t = {t:.6g} s, {100.0 * share:.3g} % along it, at {_shown(arm, point)}"
        f"{_at_limit(joint)}; at the worst it is {_beyond(arm, distance, angle, limited)}"
    )
    return Reach(False, t, share, point, distance, angle, joint, message)


def _last_reachable(
    search: PostureSearch, path: _Path, times: tuple[float, float], inside: Array, beyond: Array
) -> float:
    """Return the last time at which a path can be reached, between one at which it can and one at which it cannot.

    Postures close by are enough to go by until the time is found; that there is none after it is then looked at again.
    """
    earlier, end = times
    shortest = _TIME * path.trajectory.duration
    while True:
        later, nearest = end, None
        while later - earlier > shortest:
            middle = (earlier + later) / 2.0
            nearest = search.near(path.at(middle), inside, beyond)
            if nearest.reached:
                earlier, inside = middle, nearest.positions
            else:
                later, beyond = middle, nearest.positions
        nearest = search.anywhere(path.at(later), inside, _STARTS_AT_BORDER)
        if later == end or not nearest.reached:
            return earlier
        earlier, inside = later, nearest.positions


def _farthest(search: PostureSearch, path: _Path, times: list[float], beyond: Nearest) -> Nearest:
    """Return the nearest posture to the path at that of some times at which it is farthest.

    Args:
        search: How postures are looked for.
        path: The path.
        times: When, s.
        beyond: The nearest posture at the first of them.
    """
    found = {times[0]: beyond}
    for time in times[1:]:
        found[time] = beyond = search.near(path.at(time), beyond.positions)
    while True:
        time = max(found, key=lambda each: found[each].distance)
        settled = search.settle(path.at(time), found[time])
        if settled.distance >= 0.99 * found[time].distance:
            return settled
        found[time] = settled


def _short(arm: Arm, nearest: Nearest) -> tuple[float, float]:
    """Return how far a posture is from the task value, m and rad."""
    rows = arm.coordinates.position_rows, arm.coordinates.rotation_rows
    distance, angle = (float(np.linalg.norm(nearest.error[each])) for each in rows)
    return distance, angle


def _beyond(arm: Arm, distance: float, angle: float, limited: bool) -> str:
    """Say how far a target is out of reach."""
    parts = [f"{part:.3g} {unit}" for part, unit in ((distance, "m"), (angle, "rad")) if part > 0.0]
    limits = " inside its joint limits" if limited else ""
    return f"{' and '.join(parts)} beyond what {arm.name!r} can reach{limits}"


def _at_limit(joint: str | None) -> str:
    """Say which joint is in the way."""
    return f", with joint {joint!r} at its limit" if joint else ""


def _shown(arm: Arm, x: TaskValue) -> str:
    """Return where a task value is, in its position coordinates, m."""
    position = x.translation if arm.coordinates.has_rotation else x
    return f"({', '.join(f'{each:.4g}' for each in position)})"
