"""The motions of a study: each scenario's own, given ones, or lines drawn at random."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arm import Arm
from ..arm.tasks import TaskValue
from ..exceptions import AspectBorderWarning, ParameterError, ScenarioError, ShapeError, UndefinedCriterionWarning
from ..redundancy import Array
from ..scenario import Setup
from ..simulation import Run, Sample, simulate
from ..trajectories import StraightLine, Trajectory, Waypoints

SHORTEST, LONGEST = 0.5, 1.5
"""Length of a drawn line over that of the scenario's own."""

MOST_DRAWS = 10_000
"""Draws of postures after which a line that fits is given up."""


class Motion(NamedTuple):
    """Where a run starts and what its task is to do.

    Attributes:
        q0: Joint configuration at the start, shape (nq,), rad.
        v0: Joint velocity at the start, shape (nv,), rad/s.
        trajectory: What the task is to do.
        on_border: How often the postures were drawn again since the first lay on a border of its aspect; None if
            nothing was drawn.
        wrong_length: How often they were drawn again since a line was too short or too long; None if nothing was drawn.
    """

    q0: Array
    v0: Array
    trajectory: Trajectory
    on_border: int | None = None
    wrong_length: int | None = None

    def simulate(
        self, setup: Setup, law: str, dt: float | None = None, watch: Callable[[Sample], None] | None = None
    ) -> Run:
        """Run a law of a scenario on the motion.

        Args:
            setup: The scenario.
            law: Label of the law.
            dt: Sampling time if it is not to be that of the scenario, s.
            watch: Called with every sample, see `simulation.simulate`.

        Raises:
            AspectControlError: As `simulate` does.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AspectBorderWarning)
            warnings.simplefilter("ignore", UndefinedCriterionWarning)
            return simulate(
                setup.laws[law],
                self.trajectory,
                q0=self.q0,
                v0=self.v0,
                dt=setup.dt if dt is None else dt,
                plant=setup.plant,
                integrator=setup.integrator,
                saturation=setup.saturation,
                events=setup.events,
                watch=watch,
            )


@dataclass(frozen=True)
class RandomLines:
    """Random motions of an arm; each is a function of seed and index alone.

    A motion starts at rest in a posture that is drawn uniformly within the joint limits (a revolute joint that can make
    a whole turn: within [−π, π]); one with a minor on the border (`Arm.minors_on_border`) is drawn again. Its straight
    line leads to where a second posture, drawn in the same way, puts the task frame, so that both ends are within
    reach; the postures are drawn again until the length of the line is 0.5 to 1.5 times that of the model line, and, if
    both turn, the angle too. The profile is the model's, and the duration grows with the square root of the length, so
    that the peak acceleration is the model's, too.

    With more than one leg the motion goes on to where further postures put the frame, each drawn again until its leg is
    as long as a line may be; a cubic spline, `Waypoints`, leads through the points.

    Attributes:
        name: What the scenario is called.
        arm: The arm.
        model: The line after which the others are drawn.
        seed: Seed of all draws.
        legs: Number of points that a motion leads to.
    """

    name: str
    arm: Arm
    model: StraightLine
    seed: int
    legs: int = 1

    @classmethod
    def after(cls, name: str, arm: Arm, trajectory: Trajectory, seed: int, legs: int = 1) -> RandomLines:
        """Set up the draws after a scenario's own line and make sure that they are possible.

        Args:
            name: What the scenario is called.
            arm: The arm.
            trajectory: The scenario's own trajectory, a straight line.
            seed: Seed of all draws.
            legs: Number of points that a motion leads to.

        Raises:
            ScenarioError: If the trajectory is no straight line.
            ShapeError: If it has not one coordinate a task coordinate.
        """
        if not isinstance(trajectory, StraightLine):
            raise ScenarioError(
                f"{name}: the trajectory is of kind {trajectory.name!r}; straight lines are drawn after the "
                "scenario's own, so it must be of kind 'line'"
            )
        if trajectory.task_dim != arm.task_dim:
            raise ShapeError(
                f"{name}: the line has {trajectory.task_dim} task coordinates, the arm's task {arm.task} has "
                f"{arm.task_dim}: give one number for each"
            )
        return cls(name, arm, trajectory, seed, legs)

    @cached_property
    def ranges(self) -> tuple[Array, Array]:
        """Lower and upper ends of the ranges from which joint positions are drawn, shapes (nv,), rad (m).

        Raises:
            ParameterError: If a sliding joint has no limits.
        """
        lower, upper = self.arm.position_limits
        whole_turn = ~self.arm.prismatic & (lower <= -np.pi) & (upper >= np.pi)
        lower, upper = np.where(whole_turn, -np.pi, lower), np.where(whole_turn, np.pi, upper)
        for name, low, high in zip(self.arm.joint_names, lower, upper, strict=True):
            if not math.isfinite(high - low):
                raise ParameterError(f"joint {name!r} of {self.name} has no limits between which to draw a start")
        return lower, upper

    def draw(self, index: int) -> Motion:
        """Return the motion of an index, which depends on nothing but the seed and the index.

        Args:
            index: Number of the sample, from 0.

        Raises:
            ParameterError: If no postures are as far apart as a line has to be long.
        """
        random = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(index,)))
        coordinates, model = self.arm.coordinates, self._sizes(self.model.displacement)
        on_border = wrong_length = 0
        postures: list[Array] = []
        while len(postures) <= self.legs:
            if on_border + wrong_length == MOST_DRAWS:
                raise ParameterError(self._none_found(on_border, wrong_length))
            first = [] if postures else [self._posture(random)]
            drawn = [*postures, *first, self._posture(random)]
            before, end = (self.arm.task_position(q) for q in drawn[-2:])
            sizes = self._sizes(coordinates.error(end, before))
            if not np.all((sizes >= SHORTEST * model) & (sizes <= LONGEST * model)):
                wrong_length += 1
            elif first and len(self.arm.minors_on_border(first[0])):
                on_border += 1
            else:
                postures = drawn
        points = [self.arm.task_position(q) for q in postures]
        return Motion(postures[0], np.zeros(self.arm.nv), self._path(points), on_border, wrong_length)

    def _posture(self, random: np.random.Generator) -> Array:
        return self.arm.configuration(random.uniform(*self.ranges))

    def _path(self, points: list[TaskValue]) -> Trajectory:
        coordinates, model = self.arm.coordinates, self._sizes(self.model.displacement)
        measured = int(np.flatnonzero(model > 0.0)[0])
        lengths = [self._sizes(coordinates.error(end, start))[measured] for start, end in pairwise(points)]
        durations = [self.model.duration * math.sqrt(length / model[measured]) for length in lengths]
        displacements = [coordinates.error(point, points[0]) for point in points[1:]]
        if self.legs == 1:
            return StraightLine(displacements[0], durations[0], self.model.profile)
        return Waypoints(displacements, times=np.cumsum(durations))

    def _none_found(self, on_border: int, wrong_length: int) -> str:
        sizes, units = self._sizes(self.model.displacement), self._units
        bounds = " and ".join(
            f"{SHORTEST * size:.3g} to {LONGEST * size:.3g} {unit}" for size, unit in zip(sizes, units, strict=True)
        )
        return (
            f"no line was found for {self.name} in {MOST_DRAWS:,} draws of postures: {wrong_length:,} were not "
            f"{bounds} apart, {on_border:,} started on a border; the workspace is too small for such a line: "
            "change the displacement of the scenario"
        )

    @property
    def _units(self) -> list[str]:
        coordinates = self.arm.coordinates
        return ["m"] * bool(len(coordinates.position_rows)) + ["rad"] * bool(len(coordinates.rotation_rows))

    def _sizes(self, displacement: Array) -> Array:
        """Return the length of a displacement, m, and its angle, rad, as far as the task has them."""
        coordinates = self.arm.coordinates
        parts = (displacement[rows] for rows in (coordinates.position_rows, coordinates.rotation_rows) if len(rows))
        return np.array([np.linalg.norm(part) for part in parts])
