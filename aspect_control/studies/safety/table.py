"""Every fault under every law, without a guard and with one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ... import controllers
from ...arm import Arm
from ...exceptions import AspectControlError
from ...guard import Guard
from ...plants import RigidBodyPlant
from ...redundancy import Array
from ...simulation import RungeKutta4
from ...trajectories import StraightLine
from .faults import FAULTS, Call, Fault, Stubborn

START = (0.3, -0.5, 0.2, -2.0, 0.3, 1.8, 0.5)
"""Where Panda starts, rad."""

LINE = StraightLine([0.1, 0.15, 0.1], duration=1.0, profile="quintic")
"""What it is to do."""

DT, SAMPLES, MIDDLE = 1e-3, 1000, 400
"""Sampling time, s; samples of a motion; the one at which a fault begins that is not there from the first."""

FASTEST = 1e3
"""Joint speed at which an arm without a guard counts as lost, rad/s."""


@dataclass(frozen=True)
class SafetyRow:
    """One fault under one law.

    Attributes:
        fault: What went wrong.
        law: Name of the law.
        bare: How it ended without a guard: `"raised"` and what, `"lost"` for joints faster than any arm, or `"ran on"`.
        bare_torque: Largest |τ| without a guard, N m; 0 if there was none.
        state: State of the guard at the end.
        reason: Why it stopped the arm.
        torque: Largest |τ| with the guard, N m.
        share: The largest part that a torque was of its limit, with the guard.
        speed: Largest |θ̇| of the arm from then on, rad/s.
    """

    fault: str
    law: str
    bare: str
    bare_torque: float
    state: str
    reason: str
    torque: float
    share: float
    speed: float

    def to_dict(self) -> dict[str, Any]:
        """Return the row as plain data."""
        return asdict(self)


def safety_table(
    progress: Callable[[str, float], None] | None = None, faults: Sequence[Fault] = FAULTS, laws: Sequence[str] = ()
) -> list[SafetyRow]:
    """Try every fault under every registered law on Panda.

    Args:
        progress: Called with what is tried and the part of the work that is done, 0 to 1.
        faults: The faults.
        laws: Names of the laws; all that are registered unless given.
    """
    arm = Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
    pairs = [(fault, law) for fault in faults for law in laws or controllers.available()]
    rows = []
    for i, (fault, name) in enumerate(pairs):
        if progress is not None:
            progress(f"{fault.name}: {name}", i / len(pairs))
        rows.append(_row(arm, fault, name))
    return rows


def _row(arm: Arm, fault: Fault, name: str) -> SafetyRow:
    bare = _driven(arm, fault, Stubborn(controllers.create(name, arm)))
    stubborn = Stubborn(controllers.create(name, arm))
    guard = Guard(stubborn)
    driven = _driven(arm, fault, stubborn, guard)
    shares = driven.tau / guard.limits.torque
    return SafetyRow(
        fault=fault.name,
        law=name,
        bare=bare.ended,
        bare_torque=float(bare.tau.max(initial=0.0)),
        state=guard.status.state,
        reason=guard.status.reason,
        torque=float(driven.tau.max()),
        share=float(shares.max()),
        speed=driven.speed,
    )


@dataclass(frozen=True)
class _Driven:
    """How a motion went: how it ended, the largest |τ| of each joint, N m, the largest |θ̇| after the fault, rad/s."""

    ended: str
    tau: Array
    speed: float


def _driven(arm: Arm, fault: Fault, law: Stubborn, guard: Guard | None = None) -> _Driven:
    plant, method, controller = RigidBodyPlant(arm), RungeKutta4(), law if guard is None else guard
    q, v = arm.configuration(_beyond(arm) if fault.beyond_limits else START), np.zeros(arm.nv)
    x, largest, speed, first = arm.task_position(q), np.zeros(arm.nv), 0.0, None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a start near the border of an aspect
        begun = False
        for i in range(SAMPLES):
            call = Call(q, v, LINE.target(i * DT, x, arm.coordinates))
            wrong = fault.from_start or i >= MIDDLE
            if wrong:
                first = call if first is None else first
                law.told = fault.raises
                call = call if fault.change is None else fault.change(arm, call, first)
            try:
                if fault.reset and not begun:
                    controller.reset(call.q, call.v, DT)
                    begun = True
                tau = controller.torque(*call)
            except (AspectControlError, ArithmeticError, np.linalg.LinAlgError) as error:
                return _Driven(f"raised {type(error).__name__}", largest, speed)
            largest = np.maximum(largest, np.abs(tau))
            for _ in range(fault.pace if wrong else 1):
                q, v = method.step(plant, q, v, tau, DT)
            speed = max(speed, float(np.abs(v).max())) if wrong else speed
            if not np.abs(v).max() <= FASTEST:
                return _Driven("lost", largest, speed)
    return _Driven("ran on", largest, speed)


def _beyond(arm: Arm) -> Array:
    positions = np.array(START)
    positions[3] = arm.position_limits[1][3] + 0.2
    return positions
