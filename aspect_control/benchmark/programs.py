"""Row group 5: the quadratic program with torque limits, by several solvers."""

from __future__ import annotations

import warnings

import numpy as np

from .. import controllers
from ..arm import Arm
from . import literal
from .arms import Sample
from .floor import floor
from .timing import Call, Row, around, in_turn

TIGHT = 0.9
"""Part of the largest torque of the unlimited law that each joint has, so that limits are reached."""


def programs(arm: Arm, rounds: int) -> list[Row]:
    """Time a tick of `qp` with torque limits that are reached, and the same program through plain qpsolvers."""
    import qpsolvers

    motion = _along_a_motion(arm)
    free = controllers.create("null-space-vector", arm)
    limit = TIGHT * np.abs([free.torque(each.q, each.v, each.target) for each in motion]).max(axis=0) + 0.1
    calls = {"floor": around(floor(arm), motion)}
    for solver in ("osqp", "daqp", "proxqp", "quadprog"):
        if solver not in qpsolvers.available_solvers:
            continue
        law = controllers.QPTorque(arm, solver=solver, torque_limit=limit)
        law.reset(motion[0].q, motion[0].v, literal.DT)
        calls[f"qp, {solver}"] = _tick(law, motion)
    law = controllers.QPTorque(arm, torque_limit=limit)

    def plainly(each: Sample) -> object:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return qpsolvers.solve_problem(law.problem(each.q, each.v, each.target), solver="osqp")

    calls["plain qpsolvers, osqp"] = around(plainly, motion)
    seconds = in_turn(calls, rounds)
    return [Row("Panda, xyz: qp", each, seconds[each], seconds["floor"], "floor") for each in calls]


def _tick(law: controllers.Controller, motion: list[Sample]) -> Call:
    return around(lambda each: law.torque(each.q, each.v, each.target), motion)


def _along_a_motion(arm: Arm) -> list[Sample]:
    """States that follow one another as in a run, so that a warm start is worth something."""
    from ..simulation import simulate
    from ..trajectories import StraightLine, Target

    q0 = arm.configuration([0.3, 0.4, 0.2, -1.8, 0.1, 1.9, 0.5])
    line = StraightLine([0.1, 0.1, 0.1], 0.25)
    run = simulate(controllers.create("damped-null-space", arm), line, q0=q0)
    return [
        Sample(run.q[i], run.v[i], Target(run.x_desired[i], run.dx_desired[i], run.ddx_desired[i]), arm.state(q0, q0))
        for i in range(0, len(run.t), 2)
    ]
