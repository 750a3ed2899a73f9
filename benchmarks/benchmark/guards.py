"""What a guard around a law costs: every tick of a calm motion with it and without, and the difference."""

from __future__ import annotations

import numpy as np

from aspect_control import controllers
from aspect_control.arm import Arm
from aspect_control.controllers import Controller
from aspect_control.guard import Guard
from oracles import literal

from . import arms
from .floor import floor
from .timing import Motion, Row, every_tick

ADDED, ADDED_ON_AVERAGE = "what a guard adds to the median tick", "what it adds on average"
"""Names of the rows with the differences; the average has all that it does only at times, such as planning a stop."""

CALM = 0.05
"""How far the tool is moved along each axis, m: within the limits of Panda."""

PASSES = 5
"""Passes of the motion in a round; of each tick the median counts, so that what else the machine does is left out."""


def guards(arm: Arm, rounds: int) -> list[Row]:
    """Time laws on a calm motion of Panda, with a guard around them and without.

    Of each tick the median over the passes of a round counts; what a round gives is the median of the ticks.
    """
    return [row for name in ("pseudoinverse", "jmdc") for row in _rows(name, arm, rounds)]


def _rows(name: str, arm: Arm, rounds: int) -> list[Row]:
    samples, group = arms.motion(arm, CALM), f"Panda, xyz: a guard around {name}"
    guard, with_rate = Guard(controllers.create(name, arm)), Guard(controllers.create(name, arm), torque_rate=1e6)
    timed: dict[str, Controller] = {
        name: controllers.create(name, arm),
        f"{name}, guarded": guard,
        f"{name}, guarded, with a torque rate": with_rate,
    }
    q, v = samples[0].q, samples[0].v

    def motion(law: Controller) -> Motion:
        return Motion(lambda each: law.torque(each.q, each.v, each.target), lambda: law.reset(q, v, literal.DT))

    calls = {"floor": Motion(floor(arm)), **{label: motion(law) for label, law in timed.items()}}
    ticks = every_tick(group, calls, samples, PASSES * rounds * len(samples))
    if not guard.status.state == with_rate.status.state == "running":
        raise RuntimeError(f"a guard that is to be timed is {guard.status} and {with_rate.status}")
    each_tick = {row.name: np.median(row.seconds.reshape(rounds, PASSES, len(samples)), axis=1) for row in ticks}
    added = each_tick[f"{name}, guarded"] - each_tick[name]
    seconds = {label: np.median(each, axis=1) for label, each in each_tick.items()}
    seconds |= {ADDED: np.median(added, axis=1), ADDED_ON_AVERAGE: added.mean(axis=1)}
    return [Row(group, label, each, seconds["floor"], "floor") for label, each in seconds.items()]
