"""What a scenario file holds, section by section."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from ..arm import Arm
from ..limits import joint_limit
from ..simulation import (
    Diverged,
    Event,
    JointLimit,
    Singular,
    TorqueLimit,
    TrackingLost,
    WorkspaceLeft,
)
from ..trajectories import Circle, Hold, StraightLine, Trajectory, Waypoints

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
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


class LineSection(Section):
    """`[trajectory]` with kind = "line"; see `StraightLine`."""

    kind: Literal["line"]
    displacement: list[Finite]
    duration: Positive
    profile: str = "bang-bang"

    def build(self) -> Trajectory:
        """Return the trajectory."""
        return StraightLine(self.displacement, self.duration, self.profile)


class CircleSection(Section):
    """`[trajectory]` with kind = "circle"; see `Circle`."""

    kind: Literal["circle"]
    radius: Positive
    duration: Positive
    plane: str = "xy"
    turns: Finite = 1.0
    profile: str = "quintic"

    def build(self) -> Trajectory:
        """Return the trajectory."""
        return Circle(self.radius, self.duration, self.plane, self.turns, self.profile)


class HoldSection(Section):
    """`[trajectory]` with kind = "hold"; see `Hold`."""

    kind: Literal["hold"]
    duration: Positive

    def build(self) -> Trajectory:
        """Return the trajectory."""
        return Hold(self.duration)


class WaypointsSection(Section):
    """`[trajectory]` with kind = "waypoints"; see `Waypoints`."""

    kind: Literal["waypoints"]
    points: list[list[Finite]]
    duration: Positive | None = None
    times: list[Positive] | None = None

    def build(self) -> Trajectory:
        """Return the trajectory."""
        return Waypoints(self.points, duration=self.duration, times=self.times)


class ControllerSection(BaseModel):
    """`[[controllers]]`: one law; all other keys are its parameters.

    Attributes:
        name: Registry name.
        label: What its run is called, also in file names; the registry name unless given.
    """

    model_config = ConfigDict(extra="allow", frozen=True, strict=True)

    name: str
    label: Annotated[str, Field(pattern=r"^[A-Za-z0-9][\w.-]*$")] = ""

    @property
    def run_label(self) -> str:
        """What its run is called."""
        return self.label or self.name

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters."""
        return dict(self.model_extra or {})


class SimulationSection(Section):
    """`[simulation]`: sampling and plant; see `simulate`.

    Attributes:
        dt: Sampling time, s.
        integrator: Name of the integrator.
        saturation: Largest |τ|, N m: a number, one a joint, or "urdf" for the robot's own; left out for none.
    """

    dt: Positive = 1e-3
    integrator: str = "rk4"
    saturation: Literal["urdf"] | Positive | list[Positive] | None = None


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

    def events(self, arm: Arm) -> list[Event]:
        """Return the events that end a run."""
        events: list[Event] = [Diverged(self.speed), WorkspaceLeft(), TrackingLost(self.tracking)]
        if self.manipulability is not None:
            events.append(Singular(self.manipulability))
        if self.torque is not None:
            events.append(TorqueLimit(joint_limit("limit", self.torque, arm.nv, arm.torque_limit)))
        if self.joints:
            events.append(JointLimit())
        return events
