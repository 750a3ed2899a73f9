"""The circle in a plane of two position coordinates."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np

from ..arm.tasks import POSITION_AXES, Task
from ..checks import finite_number, known_name, positive
from ..exceptions import ParameterError
from ..redundancy import Array
from .path import PathTrajectory
from .profiles import Progress, find_profile

PLANES = tuple("".join(axes) for axes in permutations(POSITION_AXES, 2))
"""The planes that a circle may lie in; the order of the two coordinates says where on the circle the start is."""


class Circle(PathTrajectory):
    """A circle through the start, from rest to rest; the other coordinates and the orientation stand still.

    The start is the point of the circle with the smallest value of the plane's first coordinate: the centre is one
    radius further along it. The motion sets off along the second coordinate, for negative turns against it.
    """

    name = "circle"

    def __init__(
        self, radius: float, duration: float, plane: str = "xy", turns: float = 1.0, profile: str = "quintic"
    ) -> None:
        """Set the circle.

        Args:
            radius: Its radius, m.
            duration: Time that the motion takes, s.
            plane: Two different letters of x, y and z.
            turns: How often it goes round; not 0, need not be whole.
            profile: How the angle grows with time; a name of `PROFILES`.

        Raises:
            ParameterError: If `radius` or `duration` is not above zero, `turns` is zero or not finite, or there are so
                many that no finite acceleration would do.
            UnknownNameError: If there is no such plane or profile.
        """
        self.radius = positive("radius", radius, "m")
        self.duration = positive("duration", duration, "s")
        self.plane = known_name(plane, PLANES, "plane")
        self.turns = finite_number("turns", turns)
        if self.turns == 0.0:
            raise ParameterError("turns must not be 0: a trajectory that stands still is a Hold")
        angle = 2.0 * math.pi * self.turns
        if not math.isfinite(self.radius * angle * angle):
            raise ParameterError(
                f"a circle must have a finite acceleration, got turns={self.turns:g} of radius={self.radius:g} m"
            )
        self._profile = find_profile(profile)
        self.profile = profile

    @property
    def task_dim(self) -> None:
        """None: a circle suits any task that has its plane's coordinates."""
        return None

    def path(self, progress: Progress, task: Task) -> Array:
        """Return the circle; see `PathTrajectory.path`."""
        missing = [axis for axis in self.plane if axis not in task.axes]
        if missing:
            raise ParameterError(
                f"a circle in the plane {self.plane!r} needs the task coordinates {_listed(self.plane)}, "
                f"the task {task.axes} has no {_listed(missing)}"
            )
        s, ds, dds = progress
        full = 2.0 * math.pi * self.turns
        angle, rate, acceleration = full * s, full * ds, full * dds
        sine, cosine = math.sin(angle), math.cos(angle)
        first, second = (task.axes.index(axis) for axis in self.plane)
        rows = np.zeros((3, task.dim))
        rows[:, first] = (
            self.radius * (1.0 - cosine),
            self.radius * rate * sine,
            self.radius * (rate**2 * cosine + acceleration * sine),
        )
        rows[:, second] = (
            self.radius * sine,
            self.radius * rate * cosine,
            self.radius * (acceleration * cosine - rate**2 * sine),
        )
        return rows

    def __repr__(self) -> str:
        """Show the circle as it was constructed."""
        return (
            f"Circle({self.radius}, duration={self.duration}, plane={self.plane!r}, turns={self.turns}, "
            f"profile={self.profile!r})"
        )


def _listed(axes: str | list[str]) -> str:
    return " and ".join(map(repr, axes))
