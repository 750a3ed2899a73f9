"""What a scenario file holds, as a whole."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from .. import controllers
from ..checks import known_name
from ..limits import joint_limit
from ..plants.registry import PLANTS
from ..simulation.integrators.registry import INTEGRATORS
from .sections import (
    ControllerSection,
    EventSection,
    GuardSection,
    LimitsSection,
    RobotSection,
    Section,
    SimulationSection,
    StartSection,
    TrajectorySection,
)
from .setup import Setup, build_arm, start_configuration, start_velocity

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
        guard: The guard around every law; None for bare laws.
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
    guard: GuardSection | None = None
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

    def build(self, *, laws: Collection[str] | None = None) -> Setup:
        """Build what the file describes, once: the arm, the start, the trajectory, the laws and what they run on.

        Args:
            laws: Labels of the laws to build; None for all.

        Raises:
            UnknownNameError: If there is no law of a label.
            AspectControlError: If the scenario does not fit the robot.
        """
        labels = [each.run_label for each in self.controllers]
        wanted = labels if laws is None else [known_name(label, labels, "law") for label in laws]
        arm = build_arm(self.robot, self.folder)
        simulation, saturation, guard = self.simulation, self.simulation.saturation, self.guard
        made = {
            each.run_label: controllers.create(each.name, arm, **each.parameters)
            for each in self.controllers
            if each.run_label in wanted
        }
        return Setup(
            arm=arm,
            q0=start_configuration(self.start, arm),
            v0=start_velocity(self.start, arm),
            trajectory=self.trajectory.build(),
            laws=made if guard is None else {label: guard.around(law) for label, law in made.items()},
            events=tuple(self.limits.events(arm, self.events)),
            plant=PLANTS.make(simulation.plant, arm),
            dt=simulation.dt,
            integrator=INTEGRATORS.make(simulation.integrator, arm),
            saturation=None if saturation is None else joint_limit("saturation", saturation, arm.nv, arm.torque_limit),
            description=self.description,
        )
