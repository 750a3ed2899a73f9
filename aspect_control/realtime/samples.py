"""Whose clock a loop lives on: the robot's own if it has one, else the computer's."""

from __future__ import annotations

import time
from collections.abc import Iterator
from math import floor
from time import perf_counter
from typing import NamedTuple

from numpy.typing import ArrayLike

from .robot_protocol import ClockedRobot, Robot

SPIN = 2e-4
"""The last part of a wait that is spent awake, s: what the operating system may oversleep."""


class RobotSample(NamedTuple):
    """What was read of a robot, and when.

    Attributes:
        t: Time since the first sample on the clock that the loop lives on, s.
        due: When the sample was due, by `time.perf_counter`, s.
        q: Joint configuration, shape (nq,), rad.
        v: Joint velocity, shape (nv,), rad/s.
    """

    t: float
    due: float
    q: ArrayLike
    v: ArrayLike


def samples(robot: Robot, dt: float) -> Iterator[RobotSample]:
    """Read a robot for ever, once a period.

    A robot that has a `time` says itself when a sample is there, by `read`; all others are read at the absolute
    deadlines k·dt after the first reading, and those that have passed already are left out.

    Args:
        robot: The robot.
        dt: The period, s.
    """
    return _on_its_clock(robot) if isinstance(robot, ClockedRobot) else _on_our_clock(robot, dt)


def sleep_until(deadline: float) -> None:
    """Wait until `time.perf_counter()` is at a deadline, s: asleep first, awake for the last `SPIN`."""
    left = deadline - perf_counter() - SPIN
    if left > 0.0:
        time.sleep(left)
    while perf_counter() < deadline:
        pass


def _on_its_clock(robot: ClockedRobot) -> Iterator[RobotSample]:
    q, v = robot.read()
    start = robot.time
    yield RobotSample(0.0, perf_counter(), q, v)
    while True:
        q, v = robot.read()
        yield RobotSample(robot.time - start, perf_counter(), q, v)


def _on_our_clock(robot: Robot, dt: float) -> Iterator[RobotSample]:
    start, k = perf_counter(), 0
    while True:
        yield RobotSample(k * dt, start + k * dt, *robot.read())
        k = max(k + 1, floor((perf_counter() - start) / dt))
        sleep_until(start + k * dt)
