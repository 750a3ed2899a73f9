"""What a scenario file holds, as a whole, and how it is run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from .. import controllers
from ..arm import Arm
from ..checks import finite_vector
from ..controllers import Controller
from ..redundancy import Array
from ..simulation import Moment, Run, completed, simulate
from .sections import (
    ControllerSection,
    EventSection,
    LimitsSection,
    RobotSection,
    Section,
    SimulationSection,
    StartSection,
    TrajectorySection,
)

RESERVED_LABEL = "comparison"
"""The name of the figure that shows all runs of a scenario."""


class Scenario(Section):
    """A whole scenario file.

    Attributes:
        description: What it shows, in a sentence.
        robot: Which arm and what its task is.
        start: Where it starts.
        trajectory: What the task is to do.
        controllers: The laws to run.
        simulation: Sampling and plant.
        limits: What ends a run early.
        events: What else ends a run early, by name.
        folder: Where the file is, for paths relative to it.
    """

    description: str = ""
    robot: RobotSection
    start: StartSection
    trajectory: TrajectorySection
    controllers: Annotated[list[ControllerSection], Field(min_length=1)]
    simulation: SimulationSection = SimulationSection()
    limits: LimitsSection = LimitsSection()
    events: Annotated[list[EventSection], Field(default_factory=list)]
    folder: Path = Path()

    @model_validator(mode="after")
    def _distinct_labels(self) -> Scenario:
        labels = [section.run_label for section in self.controllers]
        twice = sorted({label for label in labels if labels.count(label) > 1})
        if twice:
            raise ValueError(f"controllers: {', '.join(twice)} more than once; give each a 'label' of its own")
        if RESERVED_LABEL in labels:
            raise ValueError(f"controllers: {RESERVED_LABEL!r} names the figure of all runs; take another label")
        return self

    def arm(self) -> Arm:
        """Return the arm.

        Raises:
            AspectControlError: As `Arm.from_urdf` does.
        """
        robot = self.robot
        if robot.example is not None:
            return Arm.from_example(
                robot.example, frame=robot.frame, task=robot.task, gravity=robot.gravity, locked=robot.locked
            )
        return Arm.from_urdf(
            self.folder / str(robot.urdf),
            frame=robot.frame,
            task=robot.task,
            gravity=robot.gravity,
            locked=robot.locked,
            package_dirs=[self.folder / each for each in robot.package_dirs],
        )

    def start_configuration(self, arm: Arm) -> Array:
        """Return the configuration at t = 0, shape (nq,), rad.

        Raises:
            ShapeError: If there is not one position a joint.
            ParameterError: If a joint is outside its limits.
        """
        if self.start.degrees is not None:
            degrees = finite_vector("start.degrees", self.start.degrees, arm.nv)
            positions = np.where(arm.prismatic, degrees, np.deg2rad(degrees))
        else:
            positions = finite_vector("start.positions", self.start.positions or [], arm.nv)
        q = arm.configuration(positions)
        arm.require_within_limits(q)
        return q

    def laws(self, arm: Arm) -> dict[str, Controller]:
        """Return the laws by their labels.

        Raises:
            AspectControlError: As `controllers.create` does.
        """
        return {each.run_label: controllers.create(each.name, arm, **each.parameters) for each in self.controllers}

    def require_fits(self) -> None:
        """Make sure, before anything is written, that robot, start, laws and trajectory can be made.

        Raises:
            AspectControlError: If the scenario does not fit the robot.
        """
        arm = self.arm()
        self.start_configuration(arm)
        self.laws(arm)
        self.trajectory.build()

    def run(self, progress: Callable[[str, float], None] | None = None) -> dict[str, Run]:
        """Run every law and return the runs by their labels.

        Args:
            progress: Called with the label of the law and the part of all work that is done, 0 to 1.

        Raises:
            AspectControlError: If the scenario does not fit the robot.
        """
        runs: dict[str, Run] = {}
        self.run_each(runs.__setitem__, progress)
        return runs

    def run_each(
        self,
        keep: Callable[[str, Run], None],
        progress: Callable[[str, float], None] | None = None,
        before: Callable[[str, Controller], None] | None = None,
        watch: Callable[[str], Callable[[Moment], None]] | None = None,
    ) -> None:
        """Run every law and hand each run over as soon as it is there.

        One that Ctrl-C or an exception in `watch` or `progress` interrupts is handed over too, and is the last.

        Args:
            keep: Called with label and run.
            progress: As for `run`.
            before: Called with the label and the law before each run.
            watch: Called with each label; what it returns is called with every sample of that law, see `simulate`.

        Raises:
            AspectControlError: If the scenario does not fit the robot.
            BaseException: What interrupted the last run: `run.error`.
        """
        arm = self.arm()
        q0, laws, trajectory = self.start_configuration(arm), self.laws(arm), self.trajectory.build()
        for i, (label, law) in enumerate(laws.items()):
            if before is not None:
                before(label, law)
            run = simulate(
                law,
                trajectory,
                q0=q0,
                v0=self.start.velocities,
                dt=self.simulation.dt,
                integrator=self.simulation.integrator,
                saturation=self.simulation.saturation,
                events=self.limits.events(arm, self.events),
                plant=self.simulation.plant,
                progress=_share(progress, label, i, len(laws)),
                watch=None if watch is None else watch(label),
            )
            keep(label, run)
            completed(run)


def _share(
    progress: Callable[[str, float], None] | None, label: str, index: int, count: int
) -> Callable[[float], None] | None:
    return None if progress is None else lambda part: progress(label, (index + part) / count)
