"""How the loop leaves a robot: at rest, with a last command that holds it there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..redundancy import Array
from .robot_protocol import Robot
from .samples import RobotSample

STIFFNESS = 20.0
"""Natural frequency of the feedback, rad/s, where the sampling time allows it."""

SLOWEST_SAMPLING = 0.2
"""Largest product of that frequency and the sampling time."""

FASTEST, SLOWEST = 10.0, 2.0
"""Rates at which the joints are slowed down, 1/s: the fastest that the torque limits allow, between these two."""

PART_OF_TORQUE = 0.9
"""Part of a torque limit that slowing down may take."""

AT_REST = 0.01
"""Joint speed that counts as rest, rad/s or m/s, if it lasts for `FADING`."""

LONGEST = 3.0
"""Time after which braking is given up, s."""

FADING = 0.05
"""Time over which the last torque of the law fades out, s, so that the torque makes no step."""


def brake(arm: Arm, robot: Robot, readings: Iterator[RobotSample], dt: float, last: Array) -> bool:
    """Bring a moving arm to rest and leave it with a torque that holds it.

    The joints follow θ̇_r = θ̇_0 exp(−ρt) by computed torque,

    τ = M{θ̈_r + 2ω(θ̇_r − θ̇) + ω²(θ_r − θ)} + N

    within the torque limits of the robot's description, and the last torque of the law fades out over `FADING`. The
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
    omega, limit = min(STIFFNESS, SLOWEST_SAMPLING / dt), arm.torque_limit
    began = resting_since = 0.0
    for t, _, q, v in readings:
        state = arm.state(q, v)
        if t == began:
            start, rate = state, _rate(state, limit)
        if np.abs(state.v).max() > AT_REST:
            resting_since = t
        at_rest = t - resting_since >= FADING
        if ended := at_rest or t >= LONGEST:
            state = arm.state(q, np.zeros(arm.nv))
        v_r = np.exp(-rate * t) * start.v
        ahead = arm.difference(state.q, arm.integrate(start.q, (start.v - v_r) / rate))
        slowing = 0.0 if ended else 2.0 * omega * (v_r - state.v) - rate * v_r
        tau = state.M @ (omega**2 * ahead + slowing) + state.nle
        if t == began:
            step = last - tau
        robot.write(np.clip(tau + max(0.0, 1.0 - t / FADING) * step, -limit, limit))
        if ended:
            break
    return at_rest


def gravity_compensation(arm: Arm, q: ArrayLike) -> Array:
    """Return the torque that carries the arm at q, within the torque limits of its description, shape (nv,), N m."""
    torque: Array = np.clip(arm.state(q, np.zeros(arm.nv)).nle, -arm.torque_limit, arm.torque_limit)
    return torque


def _rate(state: ArmState, limit: Array) -> float:
    """Return the largest ρ at which −ρ M θ̇ + N leaves something of every torque limit."""
    push = -(state.M @ state.v)
    room, moving = PART_OF_TORQUE * limit - np.sign(push) * state.nle, np.abs(push) > 0.0
    return float(np.clip((room[moving] / np.abs(push[moving])).min(initial=FASTEST), SLOWEST, FASTEST))
