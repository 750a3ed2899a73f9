"""The floor: the bare calls of Pinocchio that any of the laws needs at a state, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from aspect_control.arm import Arm

from .arms import Sample


def floor(arm: Arm) -> Callable[[Sample], Any]:
    """Return a call that computes M, N, J, J̇θ̇ and x of one state, by the cheapest calls that were found."""
    crba, nonlinear, kinematics = pin.crba, pin.nonLinearEffects, pin.forwardKinematics
    place, jacobian, acceleration = (
        pin.updateFramePlacement,
        pin.getFrameJacobian,
        pin.getFrameClassicalAcceleration,
    )
    model, data, frame = arm.model, arm.model.createData(), arm.model.getFrameId(arm.frame)
    world, aligned, zero = pin.Convention.WORLD, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, np.zeros(arm.nv)

    def call(sample: Sample) -> Any:
        q, v = sample.q, sample.v
        M = crba(model, data, q, world)
        nle = nonlinear(model, data, q, v)
        kinematics(model, data, q, v, zero)
        x = place(model, data, frame).translation
        J = jacobian(model, data, frame, aligned)
        drift = acceleration(model, data, frame, aligned).linear
        return M, nle, x, J, drift

    return call
