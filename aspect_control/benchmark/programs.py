"""Row group 5: the quadratic program with torque limits, by several solvers, at states of one motion.

The states are those of a motion at 1 kHz, gone through to and fro, so that a warm start is worth something. They are
told apart by what the limits do there: leave the least torque as it is, hold it, or hold so much that the task has to
be scaled back.
"""

from __future__ import annotations

import warnings

import numpy as np

from .. import controllers
from ..arm import Arm
from ..redundancy import Array
from . import literal
from .arms import Sample
from .floor import floor
from .timing import Call, Row, around, in_turn

TIGHT = 0.9
"""Part of the largest torque that the unlimited law has on the motion, joint by joint, that the limit is."""

SOLVERS = ("osqp", "daqp", "proxqp", "quadprog")

FREE, HELD, SEARCHED, SCALED = (
    "Panda, xyz: qp, no limit in the way",
    "Panda, xyz: qp, a torque limit binds",
    "Panda, xyz: qp, a torque limit binds, not known before",
    "Panda, xyz: qp, the task scaled back",
)
"""Groups of rows."""


def programs(arm: Arm, rounds: int) -> list[Row]:
    """Time a tick of `qp` with torque limits, and the same program through plain qpsolvers."""
    import qpsolvers

    motion = _along_a_motion(arm)
    free = controllers.create("null-space-vector", arm)
    limit = TIGHT * np.abs([free.torque(each.q, each.v, each.target) for each in motion]).max(axis=0) + 0.1
    kept, scaled = _where_limits_bind(arm, motion, limit)
    solvers = [each for each in SOLVERS if each in qpsolvers.available_solvers]
    rows: list[Row] = []
    for group, states, at in (
        (FREE, motion, 10.0 * limit),
        (HELD, kept, limit),
        (SEARCHED, kept, limit),
        (SCALED, scaled, limit),
    ):
        there_and_back = states + states[::-1]
        calls = {"floor": around(floor(arm), there_and_back)}
        for solver in solvers:
            calls[solver] = _tick(arm, solver, at, there_and_back, afresh=group == SEARCHED)
        if group in (FREE, HELD):
            calls["plain qpsolvers, osqp"] = _plainly(arm, at, there_and_back)
        seconds, note = in_turn(calls, rounds), f"{len(states)} states"
        rows += [Row(group, each, seconds[each], seconds["floor"], "floor", note) for each in calls]
    return rows


def not_installed() -> list[str]:
    """Return the solvers that are not installed."""
    import qpsolvers

    return [each for each in SOLVERS if each not in qpsolvers.available_solvers]


def _tick(arm: Arm, solver: str, limit: Array, states: list[Sample], *, afresh: bool) -> Call:
    law = controllers.QPTorque(arm, solver=solver, torque_limit=limit)
    law.reset(states[0].q, states[0].v, literal.DT)

    def tick(each: Sample) -> object:
        if afresh:
            law.forget_limits_reached()
        return law.torque(each.q, each.v, each.target)

    return around(tick, states)


def _plainly(arm: Arm, limit: Array, states: list[Sample]) -> Call:
    import qpsolvers

    law = controllers.QPTorque(arm, torque_limit=limit)

    def plainly(each: Sample) -> object:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return qpsolvers.solve_problem(law.problem(each.q, each.v, each.target), solver="osqp")

    return around(plainly, states)


def _where_limits_bind(arm: Arm, motion: list[Sample], limit: Array) -> tuple[list[Sample], list[Sample]]:
    """Return the states at which a limit changes the least torque, and those at which the task has to be scaled."""
    law, free = controllers.QPTorque(arm, torque_limit=limit), controllers.create("null-space-vector", arm)
    kept, scaled = [], []
    for each in motion:
        law.torque(each.q, each.v, each.target)
        least = free.torque(each.q, each.v, each.target)
        if law.status is not None and law.status.outcome == "scaled":
            scaled.append(each)
        elif np.any(np.abs(least) > limit):
            kept.append(each)
    return kept, scaled


def _along_a_motion(arm: Arm) -> list[Sample]:
    from ..simulation import simulate
    from ..trajectories import StraightLine, Target

    q0 = arm.configuration([0.3, 0.4, 0.2, -1.8, 0.1, 1.9, 0.5])
    line = StraightLine([0.1, 0.1, 0.1], 0.25)
    run = simulate(controllers.create("damped-null-space", arm), line, q0=q0)
    return [
        Sample(run.q[i], run.v[i], Target(run.x_desired[i], run.dx_desired[i], run.ddx_desired[i]), arm.state(q0, q0))
        for i in range(len(run.t))
    ]
