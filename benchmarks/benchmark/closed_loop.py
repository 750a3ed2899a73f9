"""A closed-loop run at 1 kHz with RK4, and where its time goes."""

from __future__ import annotations

import time

import numpy as np
import pinocchio as pin

from aspect_control import controllers
from aspect_control.arm import Arm
from aspect_control.plants import RigidBodyPlant
from aspect_control.simulation import RungeKutta4, simulate
from aspect_control.trajectories import StraightLine
from oracles import literal

from .arms import Sample
from .floor import floor
from .timing import Call, Row, interleaved

SIMULATED = 1.0
"""Length of the run, s."""


def closed_loop(arm: Arm, rounds: int) -> list[Row]:
    """Time runs of three laws, each beside a tick and four calls of the articulated body algorithm; per sample."""
    return [row for name in ("pseudoinverse", "null-space-vector", "jmdc") for row in _run_of(name, arm, rounds)]


def _run_of(name: str, arm: Arm, rounds: int) -> list[Row]:
    q0, v0 = arm.configuration([0.3, 0.4, 0.2, -1.8, 0.1, 1.9, 0.5]), np.zeros(arm.nv)
    line, start = StraightLine([0.1, 0.1, 0.1], SIMULATED), arm.task_position(q0)
    target, model, data = line.target(0.3, start, arm.coordinates), arm.model, arm.model.createData()
    law, timed = controllers.create(name, arm), controllers.create(name, arm)
    timed.reset(q0, v0, literal.DT)
    bare, sample = floor(arm), Sample(q0, v0, target, arm.state(q0, v0))
    plant, method, tau = RigidBodyPlant(arm), RungeKutta4(), timed.torque(q0, v0, target)

    def run() -> float:
        begin = time.perf_counter()
        recorded = simulate(law, line, q0=q0)
        return (time.perf_counter() - begin) / len(recorded.t)

    calls: dict[str, Call] = {
        "a sample of the run": run,
        "tick": lambda: timed.torque(q0, v0, target),
        "four ABA calls": lambda: [pin.aba(model, data, q0, v0, tau) for _ in range(4)],
        "RK4 step, its four ABA calls included": lambda: method.step(plant, q0, v0, tau, literal.DT),
        "target": lambda: line.target(0.3, start, arm.coordinates),
        "floor": lambda: bare(sample),
    }
    seconds = interleaved(calls, rounds)
    base, of = seconds["tick"] + seconds["four ABA calls"], "tick + four ABA calls"
    return [Row(f"Panda, xyz: closed loop, {name}", each, seconds[each], base, of) for each in calls]
