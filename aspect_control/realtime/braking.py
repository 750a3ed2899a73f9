"""How the loop leaves a robot: at rest, with a last command that holds it there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..redundancy import Array
from .robot_protocol import Robot
from .samples import RobotSample

RATE = 20.0
"""Rate at which joints are slowed down and held, 1/s, where the sampling time allows it."""

SLOWEST_SAMPLING = 0.2
"""Largest product of that rate and the sampling time."""

AT_REST = 0.02
"""Joint speed that counts as rest, rad/s or m/s."""

LONGEST = 1.0
"""Time after which braking is given up, s."""

BLENDING = 0.05
"""Time over which the last torque of the law fades out, s, so that the torque makes no step."""


def brake(arm: Arm, robot: Robot, readings: Iterator[RobotSample], dt: float, last: Array) -> bool:
    """Bring a moving arm to rest and leave it with a torque that holds it.

    The joints follow θ̇_r = θ̇_0 exp(−ωt) by computed torque,

    τ = M{θ̈_r + 2ω(θ̇_r − θ̇) + ω²(θ_r − θ)} + N

    within the torque limits of the robot's description, and the last torque of the law fades out over `BLENDING`. The
    last command is the same torque for θ̇ = 0: gravity, and what the arm needed to be held besides it, such as for a
    payload that nobody told of.

    Args:
        arm: The arm.
        robot: The robot.
        readings: Its samples, from now on.
        dt: The sampling time, s.
        last: The torque that was written last, shape (nv,), N m.

    Returns:
        Whether the arm is at rest.

    Raises:
        Exception: What reading or writing the robot raises.
    """
    rate, limit = min(RATE, SLOWEST_SAMPLING / dt), arm.torque_limit
    bump, at_rest = np.zeros(arm.nv), False
    for t, _, q, v in readings:
        state = arm.state(q, v)
        if t == 0.0:
            q0, v0 = state.q, state.v
        at_rest = t >= BLENDING and bool(np.abs(state.v).max() <= AT_REST)
        if ended := at_rest or t >= LONGEST:
            state = arm.state(q, np.zeros(arm.nv))
        decay = float(np.exp(-rate * t))
        pull = rate**2 * arm.difference(state.q, arm.integrate(q0, v0 * ((1.0 - decay) / rate)))
        slowing = 0.0 if ended else 2.0 * rate * (decay * v0 - state.v) - rate * decay * v0
        brakes = state.M @ (slowing + pull) + state.nle
        if t == 0.0:
            bump = last - brakes
        robot.write(np.clip(brakes + max(0.0, 1.0 - t / BLENDING) * bump, -limit, limit))
        if ended:
            break
    return at_rest


def gravity_compensation(arm: Arm, q: ArrayLike) -> Array:
    """Return the torque that carries the arm at q, within the torque limits of its description, shape (nv,), N m."""
    torque: Array = np.clip(arm.state(q, np.zeros(arm.nv)).nle, -arm.torque_limit, arm.torque_limit)
    return torque
