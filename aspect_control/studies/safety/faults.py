"""What can go wrong between a robot, a law and whoever calls it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...arm import Arm, ArmState
from ...arm.tasks import TaskValue
from ...controllers import Controller
from ...redundancy import Array
from ...trajectories import Target


class Call(NamedTuple):
    """What a law is called with at one sample.

    Attributes:
        q: Joint configuration, shape (nq,), rad, or what is taken for one.
        v: Joint velocity, shape (nv,), rad/s, or what is taken for one.
        target: What the task is to do, or what is taken for one.
    """

    q: Array
    v: Array
    target: Target


class Stubborn(Controller):
    """A law that raises an exception once it is told to.

    Attributes:
        law: What it is until then.
        told: Whether it has been told.
    """

    told = False

    def __init__(self, law: Controller) -> None:
        """Set the law."""
        self.law, self.arm, self.kp, self.kv = law, law.arm, law.kp, law.kv
        self.name = law.name  # type: ignore[misc]

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Reset the law."""
        self.law.reset(q, v, dt)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return the law's torque, shape (nv,), N m, unless told to raise."""
        if self.told:
            raise ZeroDivisionError("a mistake in the law")
        return self.law.torque_at(state, target)


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong.

    Attributes:
        name: What it is, in a few words.
        change: What it makes of the call that would be right, and of the one at which it began; None if that is right.
        from_start: Whether it is there from the first sample, and otherwise begins in the middle of the motion.
        reset: Whether the law is reset.
        raises: Whether the law itself raises an exception.
        pace: Samples of the arm's motion for each one that the law sees.
        beyond_limits: Whether the motion starts with a joint beyond its limits.
        hides: Whether the law no longer sees where the arm is.
    """

    name: str
    change: Callable[[Arm, Call, Call], Call] | None = None
    from_start: bool = True
    reset: bool = True
    raises: bool = False
    pace: int = 1
    beyond_limits: bool = False
    hides: bool = False


def _in_degrees(arm: Arm, call: Call, _: Call) -> Call:
    positions = np.where(arm.prismatic, arm.positions(call.q), np.rad2deg(arm.positions(call.q)))
    return call._replace(q=arm.configuration(positions), v=np.where(arm.prismatic, call.v, np.rad2deg(call.v)))


def _in_millimetres(arm: Arm, call: Call, _: Call) -> Call:
    x, dx, ddx = call.target.x, call.target.dx.copy(), call.target.ddx.copy()
    rows = arm.coordinates.position_rows
    dx[rows] *= 1000.0
    ddx[rows] *= 1000.0
    scaled = pin.SE3(x.rotation, 1000.0 * x.translation) if arm.coordinates.has_rotation else 1000.0 * x
    return call._replace(target=Target(scaled, dx, ddx))


def _swapped(arm: Arm, call: Call, _: Call) -> Call:
    return call._replace(q=arm.configuration(call.v), v=arm.positions(call.q))


def _moved(distance: float, reaches: float = 0.0) -> Callable[[Arm, Call, Call], Call]:
    """Return a fault that moves the target away from the arm's first joint, by m and by reaches of the arm."""

    def change(arm: Arm, call: Call, _: Call) -> Call:
        x, rows = call.target.x, arm.coordinates.position_rows
        position: TaskValue = x.translation[arm.coordinates.position_axes] if arm.coordinates.has_rotation else x[rows]
        outward = position - np.array(arm.kinematics.first_joint_in_task)
        displacement = np.zeros(arm.task_dim)
        displacement[rows] = (distance + reaches * arm.reach) * outward / np.linalg.norm(outward)
        moved = arm.coordinates.displaced(x, displacement)
        return call._replace(target=Target(moved, call.target.dx, call.target.ddx))

    return change


def _far_path(arm: Arm, call: Call, first: Call) -> Call:
    """Go on three times as far as is meant, in the same time."""
    start, target = first.target.x, call.target
    displacement = 3.0 * arm.coordinates.error(target.x, start)
    return call._replace(
        target=Target(arm.coordinates.displaced(start, displacement), 3.0 * target.dx, 3.0 * target.ddx)
    )


def _not_a_number(arm: Arm, call: Call, _: Call) -> Call:
    return call._replace(q=np.where(np.arange(arm.nq) == 0, np.nan, call.q))


def _repeated(arm: Arm, call: Call, first: Call) -> Call:
    return call._replace(q=first.q, v=first.v)


def _no_target(arm: Arm, call: Call, _: Call) -> Call:
    wrong: object = (call.target.x, call.target.dx, call.target.ddx)
    return call._replace(target=wrong)  # type: ignore[arg-type]


FAULTS = (
    Fault("q and v in degrees", _in_degrees),
    Fault("target in millimetres", _in_millimetres),
    Fault("q and v swapped", _swapped),
    Fault("start beyond a joint limit", beyond_limits=True),
    Fault("posture of another target", _moved(-0.3)),
    Fault("target out of reach", _moved(0.0, 1.0)),
    Fault("path out of reach", _far_path),
    Fault("never reset", reset=False),
    Fault("target jumps by 0.5 m", _moved(-0.5), from_start=False),
    Fault("q in degrees from the middle on", _in_degrees, from_start=False, hides=True),
    Fault("q and v swapped from the middle on", _swapped, from_start=False, hides=True),
    Fault("q is not a number", _not_a_number, from_start=False, hides=True),
    Fault("target is none", _no_target, from_start=False),
    Fault("samples repeated", _repeated, from_start=False, hides=True),
    Fault("four of five samples lost", pace=5, from_start=False, hides=True),
    Fault("the law raises an exception", raises=True, from_start=False),
)
"""What is tried, in the order of the table."""
