"""Events that end a run: each says how it ended and why."""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import dist
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.tasks import TaskValue
from ..checks import positive
from ..exceptions import ParameterError
from ..limits import joint_limit
from ..redundancy import Array, manipulability
from ..trajectories import Target


class Moment(NamedTuple):
    """One sample of a run in the making; its arrays are read-only.

    Attributes:
        arm: The arm.
        t: Time, s.
        q: Joint configuration, shape (nq,), rad.
        v: Joint velocity, shape (nv,), rad/s.
        tau: Joint torque that the law asks for, before any saturation, shape (nv,), N m.
        target: What the task is to do.
    """

    arm: Arm
    t: float
    q: Array
    v: Array
    tau: Array
    target: Target

    @property
    def x(self) -> TaskValue:
        """Task value at q, computed when asked for: shape (m,), m, or a `pin.SE3` for a task with rotations."""
        return self.arm.task_position(self.q)


class Event(ABC):
    """A condition that ends a run.

    Attributes:
        status: How a run ended that it has ended.
    """

    status: str

    def require_fits(self, arm: Arm) -> None:  # noqa: B027
        """Raise an error of ours if the event does not fit the arm; called before the run starts."""

    @abstractmethod
    def check(self, moment: Moment) -> str | None:
        """Return why the run ends at this moment, without the time, or None if it goes on."""


class Diverged(Event):
    """The joints have become faster than any arm."""

    status = "diverged"

    def __init__(self, speed: float = 1e3) -> None:
        """Set the limit.

        Args:
            speed: Largest joint speed, rad/s (m/s for prismatic joints).

        Raises:
            ParameterError: If it is not above zero.
        """
        self.speed = positive("speed", speed, "rad/s")

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        speeds = list(map(abs, moment.v.tolist()))
        speed = max(speeds)
        if speed <= self.speed:
            return None
        joint = speeds.index(speed)
        return f"joint {moment.arm.joint_names[joint]!r} at {speed:.3g} rad/s, limit {self.speed:g} rad/s"


class WorkspaceLeft(Event):
    """The target is farther from the first joint than the arm can possibly reach."""

    status = "tracking lost"

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        arm, coordinates = moment.arm, moment.arm.coordinates
        x = moment.target.x.translation[coordinates.position_axes] if coordinates.has_rotation else moment.target.x
        distance = dist(x.tolist(), arm.kinematics.first_joint_in_task)
        if distance <= arm.reach * (1.0 + 1e-9):
            return None
        return (
            f"the path leaves the workspace: the target is {distance:.6g} m from the first joint, "
            f"{distance - arm.reach:.3g} m beyond the reach of {arm.reach:.6g} m"
        )


class TrackingLost(Event):
    """The task frame is too far from its target."""

    status = "tracking lost"

    def __init__(self, distance: float = 0.5) -> None:
        """Set the limit.

        Args:
            distance: Largest distance between the desired and the actual position, m.

        Raises:
            ParameterError: If it is not above zero.
        """
        self.distance = positive("distance", distance, "m")

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        arm, x_d, x = moment.arm, moment.target.x, moment.x
        if arm.coordinates.has_rotation:
            axes = arm.coordinates.position_axes
            x_d, x = x_d.translation[axes], x.translation[axes]
        distance = dist(x_d.tolist(), x.tolist())
        if distance <= self.distance:
            return None
        return (
            f"{arm.frame!r} is {distance:.3g} m from its target, limit {self.distance:g} m; "
            f"the manipulability there is {float(manipulability(arm.jacobian(moment.q))):.3g}"
        )


class Singular(Event):
    """The manipulability of Eq. (25) has fallen below a threshold."""

    status = "singular"

    def __init__(self, manipulability: float) -> None:
        """Set the threshold.

        Args:
            manipulability: Smallest w, in the unit of the minors.

        Raises:
            ParameterError: If it is not above zero.
        """
        self.manipulability = positive("manipulability", manipulability)

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        w = float(manipulability(moment.arm.jacobian(moment.q)))
        return None if w >= self.manipulability else f"manipulability {w:.3g}, limit {self.manipulability:g}"


class TorqueLimit(Event):
    """The law asks for more torque than a joint has."""

    status = "torque limit"

    def __init__(self, limit: ArrayLike) -> None:
        """Set the limit.

        Args:
            limit: Largest |τ|, N m: a number, or one a joint; `arm.torque_limit` is the URDF's.

        Raises:
            ParameterError: If it is not above zero.
        """
        self.limit = joint_limit("limit", limit)

    def require_fits(self, arm: Arm) -> None:
        """Make sure that there is one limit a joint, or one for all.

        Raises:
            ShapeError: If there is not.
        """
        joint_limit("limit", self.limit, arm.nv)

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        share = np.abs(moment.tau) / self.limit
        joint = int(share.argmax())
        if share[joint] <= 1.0:
            return None
        limit = np.broadcast_to(self.limit, moment.tau.shape)[joint]
        return f"{moment.tau[joint]:.6g} N m at joint {moment.arm.joint_names[joint]!r}, limit {limit:.6g} N m"


class JointLimit(Event):
    """A joint has left its range in the robot's description."""

    status = "joint limit"

    def check(self, moment: Moment) -> str | None:
        """Return why the run ends, or None."""
        try:
            moment.arm.require_within_limits(moment.q)
        except ParameterError as error:
            return str(error)
        return None


DEFAULT_EVENTS: tuple[Event, ...] = (Diverged(), WorkspaceLeft(), TrackingLost())
"""What ends a run unless told otherwise."""
