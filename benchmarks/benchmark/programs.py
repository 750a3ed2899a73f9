"""Row group 5: every tick of the quadratic program with torque limits, by several solvers, on one motion.

The motion is one at 1 kHz, gone through to and fro. A tick costs more where the active limits change.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from aspect_control import controllers
from aspect_control.arm import Arm
from aspect_control.redundancy import Array
from oracles import literal

from .arms import Sample
from .floor import floor
from .timing import Motion, Row, every_tick

TIGHT = 0.9
"""Part of the largest torque that the unlimited law has on the motion, joint by joint, that the limit is."""

SOLVERS = ("osqp", "daqp", "proxqp", "quadprog")

FREE, TIGHT_LIMITS = "Panda, xyz: qp, no active constraint", "Panda, xyz: qp, tight torque limits"
"""Groups of rows."""


def programs(arm: Arm, rounds: int) -> list[Row]:
    """Time every tick of `qp` with torque limits, and the same program through plain qpsolvers.

    Args:
        arm: The arm.
        rounds: How often the motion is gone through, to and fro.
    """
    import qpsolvers

    motion = _along_a_motion(arm)
    free = controllers.create("null-space-vector", arm)
    limit = TIGHT * np.abs([free.torque(each.q, each.v, each.target) for each in motion]).max(axis=0) + 0.1
    solvers = [each for each in SOLVERS if each in qpsolvers.available_solvers]
    samples = motion + motion[::-1]
    rows: list[Row] = []
    for group, at in ((FREE, 10.0 * limit), (TIGHT_LIMITS, limit)):
        calls = {"floor": Motion(floor(arm)), "plain qpsolvers, osqp": Motion(_plainly(arm, at))}
        calls |= {solver: _motion(arm, solver, at, motion[0]) for solver in solvers}
        note = f"{len(motion)} states; {_outcomes(arm, at, samples)}"
        rows += [replace(row, note=note) for row in every_tick(group, calls, samples, rounds * len(samples))]
    return rows


def not_installed() -> list[str]:
    """Return the solvers that are not installed."""
    import qpsolvers

    return [each for each in SOLVERS if each not in qpsolvers.available_solvers]


def _motion(arm: Arm, solver: str, limit: Array, start: Sample) -> Motion:
    law = controllers.QPTorque(arm, solver=solver, torque_limit=limit)
    return Motion(lambda each: law.torque(each.q, each.v, each.target), lambda: law.reset(start.q, start.v, literal.DT))


def _plainly(arm: Arm, limit: Array) -> Callable[[Sample], object]:
    import qpsolvers

    law = controllers.QPTorque(arm, torque_limit=limit)

    def plainly(each: Sample) -> object:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return qpsolvers.solve_problem(law.problem(arm.state(each.q, each.v), each.target), solver="osqp")

    return plainly


def _outcomes(arm: Arm, limit: Array, samples: list[Sample]) -> str:
    """Return how many of the ticks end without a call of a solver, and how many scale the task back."""
    law, statuses = controllers.QPTorque(arm, torque_limit=limit), []
    for each in samples:
        law.torque(each.q, each.v, each.target)
        statuses.append(law.status)
    called = sum(status is not None and status.iterations > 0 for status in statuses)
    scaled = sum(status is not None and status.outcome == "scaled" for status in statuses)
    return f"{called} of {len(samples)} ticks call a solver, {scaled} scale the task back"


def _along_a_motion(arm: Arm) -> list[Sample]:
    from aspect_control.simulation import simulate
    from aspect_control.trajectories import StraightLine, Target

    q0 = arm.configuration([0.3, 0.4, 0.2, -1.8, 0.1, 1.9, 0.5])
    line = StraightLine([0.1, 0.1, 0.1], 0.25)
    run = simulate(controllers.create("damped-null-space", arm), line, q0=q0)
    return [
        Sample(run.q[i], run.v[i], Target(run.x_desired[i], run.dx_desired[i], run.ddx_desired[i]), arm.state(q0, q0))
        for i in range(len(run.t))
    ]
