"""What is drawn at random: where a motion starts and where its straight line leads."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from ...arm import Arm
from ...checks import positive, whole_number
from ...exceptions import (
    AspectBorderWarning,
    ParameterError,
    ScenarioError,
    ShapeError,
    UndefinedCriterionWarning,
    UnknownNameError,
)
from ...redundancy import Array
from ...scenario import Scenario, Setup
from ...scenario.sections import ControllerSection
from ...simulation import Diverged, Run, TrackingLost, WorkspaceLeft, completed, simulate
from ...trajectories import StraightLine

SHORTEST, LONGEST = 0.5, 1.5
"""Length of a drawn line over that of the scenario's own."""

ABLATION = "jmdc-without-minor-measure"
"""Label of JMDC with κ = 0, which is added to every scenario that runs JMDC."""

MOST_DRAWS = 10_000
"""Pairs of postures after which a line that fits is given up."""

ENDING = (Diverged, WorkspaceLeft, TrackingLost)
"""The events of the scenario that end a run."""


@dataclass(frozen=True)
class Draw:
    """One random motion.

    Attributes:
        q0: Joint configuration at the start, shape (nq,), rad.
        line: The straight line.
        on_border: Pairs of postures that were drawn again since the first lay on a border of its aspect.
        wrong_length: Pairs that were drawn again since they were too near to each other or too far apart.
    """

    q0: Array
    line: StraightLine
    on_border: int
    wrong_length: int


@dataclass(frozen=True)
class Experiment:
    """Random motions of the arm of a scenario under its laws; each is a function of seed and index alone.

    A motion starts at rest in a posture that is drawn uniformly within the joint limits (a revolute joint that can make
    a whole turn: within [−π, π]); one with a minor on the border (`Arm.minors_on_border`) is drawn again. Its straight
    line leads to where a second posture, drawn in the same way, puts the task frame, so that both ends are within
    reach; pairs are drawn again until the length of the line is 0.5 to 1.5 times that of the scenario's own, and, if
    both turn, the angle too. The profile is the scenario's, and the duration grows with the square root of the length,
    so that the peak acceleration is the scenario's, too.

    Only divergence, a target beyond the reach and a lost target end a run: the scenario's limits of joints, torque and
    manipulability are left out, and so is saturation, for a torque that is cut off cannot show that it explodes.

    Attributes:
        name: Name of the scenario.
        scenario: The scenario; it is built as a whole, but its start is not used.
        seed: Seed of all draws.
        dt: Sampling time, s.
    """

    name: str
    scenario: Scenario
    seed: int
    dt: float

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone: a worker process makes the arm and the laws again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def of(
        cls, name: str, scenario: Scenario, *, seed: int = 0, dt: float = 1e-3, laws: Sequence[str] | None = None
    ) -> Experiment:
        """Set up the experiment and make sure that it fits the arm.

        Args:
            name: What the scenario is called.
            scenario: The arm, its line and its laws.
            seed: Seed of all draws, a whole number of at least 0.
            dt: Sampling time, s.
            laws: Labels of the laws to run; None for the scenario's, with JMDC at κ = 0 if it runs JMDC.

        Raises:
            ParameterError: If the seed is negative, dt is not above zero or longer than a motion, or no line fits.
            ScenarioError: If the scenario's trajectory is no straight line.
            UnknownNameError: If there is no law of a label.
            AspectControlError: If the scenario does not fit the robot.
        """
        seed = whole_number("seed", seed, 0)
        sections = {each.run_label: each for each in scenario.controllers}
        if any(each.name == "jmdc" for each in sections.values()):
            section = ControllerSection.model_validate({"name": "jmdc", "label": ABLATION, "kappa": 0.0})
            sections.setdefault(ABLATION, section)
        for label in laws or ():
            if label not in sections:
                raise UnknownNameError(label, sections, context=name, kind="law")
        chosen = [sections[label] for label in (sections if laws is None else dict.fromkeys(laws))]
        described = Scenario.model_validate({**dict(scenario), "controllers": chosen})
        experiment = cls(name, described, seed, positive("dt", dt, "s"))
        if not isinstance(experiment.setup.trajectory, StraightLine):
            raise ScenarioError(
                f"{name}: the trajectory is of kind {scenario.trajectory.kind!r}; straight lines are drawn after the "
                "scenario's own, so it must be of kind 'line'"
            )
        if experiment.own_line.task_dim != experiment.arm.task_dim:
            raise ShapeError(
                f"{name}: the line has {experiment.own_line.task_dim} task coordinates, the arm's task "
                f"{experiment.arm.task} has {experiment.arm.task_dim}: give one number for each"
            )
        shortest = experiment.own_line.duration * math.sqrt(SHORTEST)
        if experiment.dt > shortest:
            raise ParameterError(f"dt must not be longer than the shortest motion of {shortest:.3g} s, got {dt:g} s")
        experiment.draw(0)
        return experiment

    @cached_property
    def setup(self) -> Setup:
        """What the scenario describes, built once a process."""
        return self.scenario.build()

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self.setup.arm

    @property
    def laws(self) -> tuple[str, ...]:
        """Labels of the laws."""
        return tuple(each.run_label for each in self.scenario.controllers)

    @property
    def own_line(self) -> StraightLine:
        """The scenario's own line."""
        line = self.setup.trajectory
        assert isinstance(line, StraightLine)  # noqa: S101
        return line

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

    def draw(self, index: int) -> Draw:
        """Return the motion of an index, which depends on nothing but the seed and the index.

        Args:
            index: Number of the sample, from 0.

        Raises:
            ParameterError: If no pair of postures is as far apart as a line has to be long.
        """
        random = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(index,)))
        coordinates, own = self.arm.coordinates, self._sizes(self.own_line.displacement)
        on_border = wrong_length = 0
        while on_border + wrong_length < MOST_DRAWS:
            q0, q1 = (self.arm.configuration(random.uniform(*self.ranges)) for _ in range(2))
            start, end = self.arm.task_position(q0), self.arm.task_position(q1)
            displacement = coordinates.error(end, start)
            sizes = self._sizes(displacement)
            if not np.all((sizes >= SHORTEST * own) & (sizes <= LONGEST * own)):
                wrong_length += 1
            elif len(self.arm.minors_on_border(q0)):
                on_border += 1
            else:
                scale = sizes[sizes > 0.0][0] / own[own > 0.0][0]
                line = StraightLine(displacement, self.own_line.duration * math.sqrt(scale), self.own_line.profile)
                return Draw(q0, line, on_border, wrong_length)
        bounds = " and ".join(
            f"{SHORTEST * size:.3g} to {LONGEST * size:.3g} {unit}" for size, unit in zip(own, self._units, strict=True)
        )
        raise ParameterError(
            f"no line was found for {self.name} within {MOST_DRAWS:,} pairs of postures: {wrong_length:,} were not "
            f"{bounds} apart, {on_border:,} started on a border; the workspace is too small for such a line, "
            "change the displacement of the scenario"
        )

    def run(self, index: int, law: str, dt: float | None = None) -> Run:
        """Run one law on one motion; the same run whenever it is asked for.

        Args:
            index: Number of the sample.
            law: Label of the law.
            dt: Sampling time if it is not the experiment's own, s.

        Raises:
            UnknownNameError: If there is no such law.
            AspectControlError: As `simulate` does.
        """
        setup = self.setup
        if law not in setup.laws:
            raise UnknownNameError(law, setup.laws, context=self.name, kind="law")
        draw = self.draw(index)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AspectBorderWarning)
            warnings.simplefilter("ignore", UndefinedCriterionWarning)
            run = simulate(
                setup.laws[law],
                draw.line,
                q0=draw.q0,
                dt=dt or self.dt,
                plant=setup.plant,
                integrator=setup.integrator,
                events=[event for event in setup.events if isinstance(event, ENDING)],
            )
        return completed(run)

    @property
    def _units(self) -> list[str]:
        coordinates = self.arm.coordinates
        return ["m"] * bool(len(coordinates.position_rows)) + ["rad"] * bool(len(coordinates.rotation_rows))

    def _sizes(self, displacement: Array) -> Array:
        """Return the length of a displacement, m, and its angle, rad, as far as the task has them."""
        coordinates = self.arm.coordinates
        parts = (displacement[rows] for rows in (coordinates.position_rows, coordinates.rotation_rows) if len(rows))
        return np.array([np.linalg.norm(part) for part in parts])
