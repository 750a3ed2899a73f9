"""The arms that are timed, and states of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from aspect_control import controllers
from aspect_control.arm import Arm, ArmState
from aspect_control.redundancy import Array
from aspect_control.resources import model_path
from aspect_control.simulation import simulate
from aspect_control.trajectories import StraightLine, Target

STATES = 16
"""Random states that a call goes round."""


class Sample(NamedTuple):
    """A state of an arm and what the task is to do there."""

    q: Array
    v: Array
    target: Target
    state: ArmState


def planar() -> Arm:
    """Return the paper's arm in its horizontal plane."""
    return Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0.0, 0.0, 0.0))


def panda(task: str = "xyz") -> Arm:
    """Return Panda with the position, or the pose, of its tool as the task."""
    return Arm.from_example("panda", frame="panda_hand_tcp", task=task)


def chain(joints: int) -> Arm:
    """Return a chain of revolute joints about alternating axes, with the position of its end as the task."""
    model, placement = pin.Model(), pin.SE3(np.eye(3), np.array([0.03, 0.01, 0.1]))
    model.name = f"chain of {joints}"
    turns = (pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelRX())
    for i in range(joints):
        joint = model.addJoint(i, turns[i % 3], placement, f"joint{i + 1}")
        model.appendBodyToJoint(joint, pin.Inertia.FromSphere(1.0, 0.1), placement)
    model.addFrame(pin.Frame("tip", joints, 0, placement, pin.FrameType.OP_FRAME))
    return Arm.from_pinocchio(model, frame="tip", task="xyz")


def samples(arm: Arm, count: int = STATES) -> list[Sample]:
    """Return random states with targets near them."""
    rng = np.random.default_rng(0)
    lower, upper = np.clip(arm.position_limits, -2.0, 2.0)
    m, found = arm.task_dim, []
    for _ in range(count):
        q = arm.configuration(rng.uniform(lower, upper))
        v = rng.uniform(-1.0, 1.0, arm.nv)
        target = Target(arm.task_position(q), rng.uniform(-0.1, 0.1, m), rng.uniform(-0.1, 0.1, m))
        found.append(Sample(q, v, target, arm.state(q, v)))
    return found


def motion(arm: Arm, distance: float = 0.1) -> list[Sample]:
    """Return every sample of a straight line of 0.25 s of Panda at 1 kHz, under the law with damped self-motion.

    Args:
        arm: Panda with the position of its tool as the task.
        distance: How far the tool is moved along each axis, m.
    """
    q0 = arm.configuration([0.3, 0.4, 0.2, -1.8, 0.1, 1.9, 0.5])
    run = simulate(controllers.create("damped-null-space", arm), StraightLine([distance] * 3, 0.25), q0=q0)
    return [
        Sample(q, v, Target(*desired), arm.state(q, v))
        for q, v, *desired in zip(run.q, run.v, run.x_desired, run.dx_desired, run.ddx_desired, strict=True)
    ]
