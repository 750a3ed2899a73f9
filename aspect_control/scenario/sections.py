"""What a scenario file holds, section by section."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails

from .. import trajectories
from ..arm import Arm
from ..controllers import Controller
from ..exceptions import AspectControlError, UnknownNameError
from ..guard import Guard
from ..simulation import (
    Diverged,
    Event,
    JointLimit,
    Singular,
    TorqueLimit,
    TrackingLost,
    WorkspaceLeft,
)
from ..simulation.events.registry import EVENTS
from ..trajectories import StraightLine, Trajectory

SHORT_KINDS = {"line": StraightLine.name}
"""Other names that the trajectories have in scenario files."""

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Limit = Annotated[float, Field(gt=0.0)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


class Section(BaseModel):
    """A table of the file; a key that it does not know is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class RobotSection(Section):
    """`[robot]`: which arm, and what its task is.

    Attributes:
        example: Name of an example robot; either this or `urdf`.
        urdf: Path of a URDF, relative to the scenario file.
        package_dirs: Folders of `package://` meshes, relative to the scenario file.
        frame: The task frame.
        task: A task name or a list of coordinates.
        gravity: Gravitational acceleration, m/s²; left out for (0, 0, −9.81).
        locked: Positions of locked joints, rad or m.
    """

    example: str | None = None
    urdf: str | None = None
    package_dirs: list[str] = []
    frame: str
    task: str | list[str]
    gravity: Annotated[list[Finite], Field(min_length=3, max_length=3)] | None = None
    locked: dict[str, Finite] = {}

    @model_validator(mode="after")
    def _one_source(self) -> RobotSection:
        if (self.example is None) == (self.urdf is None):
            raise ValueError("give either 'example' or 'urdf'")
        return self


class StartSection(Section):
    """`[start]`: where the joints are at t = 0, one number a joint of the arm.

    Attributes:
        positions: In rad (m for prismatic joints); either this or `degrees`.
        degrees: In degrees (m for prismatic joints).
        velocities: In rad/s; left out for rest.
    """

    positions: list[Finite] | None = None
    degrees: list[Finite] | None = None
    velocities: list[Finite] | None = None

    @model_validator(mode="after")
    def _one_unit(self) -> StartSection:
        if (self.positions is None) == (self.degrees is None):
            raise ValueError("give either 'positions' (rad) or 'degrees'")
        return self


class NamedSection(BaseModel):
    """A table that names something registered; all its other keys are the parameters of that."""

    model_config = ConfigDict(extra="allow", frozen=True, strict=True)

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters."""
        return dict(self.model_extra or {})


class TrajectorySection(NamedSection):
    """`[trajectory]`: what the task is to do; see `trajectories`.

    Attributes:
        kind: Registry name of the trajectory; `"line"` is short for `"straight-line"`.
    """

    kind: str

    @model_validator(mode="after")
    def _can_be_built(self) -> TrajectorySection:
        with _named_fields("kind", self.kind, self.parameters):
            self.build()
        return self

    def build(self) -> Trajectory:
        """Return the trajectory.

        Raises:
            AspectControlError: As `trajectories.create` does.
        """
        return trajectories.create(SHORT_KINDS.get(self.kind, self.kind), **self.parameters)


class ControllerSection(NamedSection):
    """`[[controllers]]`: one law.

    Attributes:
        name: Registry name.
        label: What its run is called, also in file names; the registry name unless given.
    """

    name: str
    label: Annotated[str, Field(pattern=r"^[A-Za-z0-9][\w.-]*$")] = ""

    @property
    def run_label(self) -> str:
        """What its run is called."""
        return self.label or self.name


class EventSection(NamedSection):
    """`[[events]]`: one event that ends a run early, besides those of `[limits]`; see `simulation.events`.

    Attributes:
        name: Registry name.
    """

    name: str

    @model_validator(mode="after")
    def _is_registered(self) -> EventSection:
        with _named_fields("name", self.name, self.parameters):
            EVENTS.require_parameters(self.name, self.parameters)
        return self


class SimulationSection(Section):
    """`[simulation]`: sampling and plant; see `simulate`.

    Attributes:
        dt: Sampling time, s.
        integrator: Name of the integrator, or a table of its name and parameters.
        plant: Name of the plant, or a table of its name and parameters.
        saturation: Largest |τ|, N m: a number, one a joint, or "urdf" for the robot's own; left out for none.
    """

    dt: Positive = 1e-3
    integrator: str | dict[str, Any] = "rk4"
    plant: str | dict[str, Any] = "rigid-body"
    saturation: Literal["urdf"] | Positive | list[Positive] | None = None


class GuardSection(Section):
    """`[guard]`: a guard around every law; see `Guard`. A number may be infinite, for no limit.

    Attributes:
        torque: Largest |τ|, N m: a number, one a joint, or "urdf" for the robot's own.
        torque_rate: Largest |dτ/dt|, N m/s; left out for any.
        speed: Largest |θ̇|, rad/s: a number, one a joint, or "urdf".
        position: Lower and upper limit, rad, each a number or one a joint, or "urdf".
        acceleration: Largest |θ̈|, rad/s²; left out for any.
        tracking: Largest distance of the task frame from its target, m (rad for rotations).
        jump: Largest jump of the target in one sample beyond the motion that it announces, m.
        distance: Largest distance of the target from the first joint, m; left out for the arm's reach.
    """

    torque: Literal["urdf"] | Limit | list[Limit] = "urdf"
    torque_rate: Limit | list[Limit] | None = None
    speed: Literal["urdf"] | Limit | list[Limit] = "urdf"
    position: Literal["urdf"] | Annotated[list[float | list[float]], Field(min_length=2, max_length=2)] = "urdf"
    acceleration: Limit | list[Limit] | None = None
    tracking: Positive = 0.1
    jump: Positive = 0.02
    distance: Positive | None = None

    def around(self, law: Controller) -> Guard:
        """Return a guard around a law.

        Raises:
            AspectControlError: As `Guard` does.
        """
        return Guard(law, **dict(self))


class LimitsSection(Section):
    """`[limits]`: what ends a run early.

    Attributes:
        speed: Largest joint speed, rad/s.
        tracking: Largest distance from the target, m.
        manipulability: Smallest manipulability; left out for any.
        torque: Largest |τ|, N m: a number, one a joint, or "urdf"; left out for any.
        joints: Whether the joints must stay inside the robot's position limits.
    """

    speed: Positive = 1e3
    tracking: Positive = 0.5
    manipulability: Positive | None = None
    torque: Literal["urdf"] | Positive | list[Positive] | None = None
    joints: bool = False

    def events(self, arm: Arm, named: Sequence[EventSection] = ()) -> list[Event]:
        """Return the events that end a run.

        Args:
            arm: The arm.
            named: What `[[events]]` names; such an event stands in the place of one of the same name here.

        Raises:
            AspectControlError: As `simulation.events.create` does, or if an event does not fit the arm.
        """
        events: list[Event] = [WorkspaceLeft(), Diverged(self.speed), TrackingLost(self.tracking)]
        if self.manipulability is not None:
            events.append(Singular(self.manipulability))
        if self.torque is not None:
            events.append(TorqueLimit(self.torque))
        if self.joints:
            events.append(JointLimit())
        taken = {each.name for each in named}
        added = [EVENTS.create(each.name, arm, **each.parameters) for each in named]
        chosen = [each for each in events if each.name not in taken] + added
        for event in chosen:
            event.require_fits(arm)
        return chosen


@contextmanager
def _named_fields(key: str, name: str, parameters: Mapping[str, Any]) -> Iterator[None]:
    """Turn an error of ours into one of a field: `key` if there is no such name, else the parameter it begins with."""
    try:
        yield
    except AspectControlError as error:
        field: str | None = str(error).split(" ")[0]
        if isinstance(error, UnknownNameError) and error.name == name:
            field = key
        elif field not in parameters:
            field = None
        detail = InitErrorDetails(
            type="value_error",
            loc=(field,) if field else (),
            input=parameters,
            ctx={"error": ValueError(str(error))},
        )
        raise ValidationError.from_exception_data("", [detail]) from None
