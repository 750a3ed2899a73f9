"""The smooth curve through several points."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import ArrayLike

from ..arm.tasks import AXES, POSITION_AXES, Task
from ..checks import finite_vector, positive, real_array, require_finite
from ..exceptions import ParameterError, ShapeError, shown
from ..redundancy import Array
from .path import PathTrajectory
from .profiles import SAME_INSTANT, Progress
from .rotation_vector import angular_motion

_ROTATION = slice(len(POSITION_AXES), len(AXES))
"""The rotations among the rows of a frame's motion."""


class Waypoints(PathTrajectory):
    """A cubic spline of the displacement through several points, from rest at the start to rest at the last.

    The rotation entries of the displacement, a rotation vector from the start's orientation, are interpolated as the
    others are: a rotation vector may be longer than π, and one that turns about a single axis keeps to it.
    """

    name = "waypoints"

    def __init__(self, points: ArrayLike, duration: float | None = None, times: ArrayLike | None = None) -> None:
        """Set the curve; either `duration` or `times`.

        Args:
            points: Displacements from the start, one entry a task coordinate, shape (k, m), m and rad; the rotation
                entries are a rotation vector in the world frame. The start itself is no part of them.
            duration: Time that the motion takes, s; each stretch takes a part of it in proportion to the distance
                between its two points (the norm of their difference, metres and radians alike), equal parts if all
                points are at the start.
            times: When each point is reached, increasing, shape (k,), s.

        Raises:
            ShapeError: If `points` is no matrix of at least one row and column, or `times` has not one entry a point.
            NonFiniteError: If one of them is not finite.
            ParameterError: If both or neither of `duration` and `times` are given, `duration` is not above zero, or
                two points would be reached at the same time.
        """
        self.points = _matrix("points", points)
        if (duration is None) == (times is None):
            raise ParameterError(
                f"give either duration or times, got duration={shown(duration)} and times={shown(times)}"
            )
        through = np.vstack([np.zeros(self.points.shape[1]), self.points])
        if times is None:
            self.times = None
            self.duration = positive("duration", duration, "s")
            distances = np.linalg.norm(np.diff(through, axis=0), axis=1)
            parts = distances if distances.any() else np.ones(len(self.points))
            knots = np.append(0.0, np.cumsum(parts) / np.cumsum(parts)[-1])
            if not (np.diff(knots) > SAME_INSTANT).all():
                raise ParameterError(
                    f"points that follow one another must differ for times in proportion to their distances, "
                    f"got the distances {distances.tolist()} from the start on: give times instead of duration"
                )
        else:
            self.times = finite_vector("times", times, len(self.points))
            self.duration = positive("the last of times", float(self.times[-1]), "s")
            knots = np.append(0.0, self.times / self.duration)
            if not (np.diff(knots) > SAME_INSTANT).all():
                raise ParameterError(f"times must be above 0 s and increasing, got {self.times.tolist()}")

        from scipy.interpolate import CubicSpline

        # What scipy evaluates in 15 µs, for it is made for many times at once: coefficients of h³, h², h and 1.
        self._cubics = np.ascontiguousarray(CubicSpline(knots, through, bc_type="clamped").c.swapaxes(0, 1))
        self._knots: list[float] = knots.tolist()
        self._inner_knots = self._knots[1:-1]

    @property
    def task_dim(self) -> int:
        """Number of task coordinates m."""
        return int(self.points.shape[1])

    def path(self, progress: Progress, task: Task) -> Array:
        """Return the curve; see `PathTrajectory.path`."""
        s, ds, dds = progress
        stretch = bisect_right(self._inner_knots, s)
        h = s - self._knots[stretch]
        slope = 3.0 * h**2, 2.0 * h, 1.0, 0.0
        powers = (
            (h**3, h**2, h, 1.0),
            [ds * each for each in slope],
            [ds**2 * bend + dds * each for bend, each in zip((6.0 * h, 2.0, 0.0, 0.0), slope, strict=True)],
        )
        curve: Array = np.array(powers).dot(self._cubics[stretch])
        if task.has_rotation:
            motion = np.zeros((3, len(AXES)))
            motion[:, task.rows] = curve
            motion[1:, _ROTATION] = angular_motion(*motion[:, _ROTATION])
            curve[1:] = motion[1:, task.rows]
        return curve

    def __repr__(self) -> str:
        """Show the curve as it was constructed."""
        when = f"duration={self.duration}" if self.times is None else f"times={self.times.tolist()}"
        return f"Waypoints({self.points.tolist()}, {when})"


def _matrix(name: str, value: ArrayLike) -> Array:
    matrix = real_array(name, value, "a matrix of numbers")
    if matrix.ndim != 2 or 0 in matrix.shape:
        raise ShapeError(f"{name} must have shape (k, m), one row a point, k and m at least 1, got {matrix.shape}")
    require_finite(name, matrix)
    return matrix
