"""What the paper says of the computational load, measured by timing both laws' ticks in turn."""

from __future__ import annotations

import time

import numpy as np

from ... import controllers
from ...redundancy import kernels_compiled
from ...trajectories import Target
from .claim import AGREES, DIFFERS, PARTLY, Claim
from .trajectory_a import Reproduction

ROUNDS = 7
"""Rounds in which the two laws take turns."""

TICKS = 300
"""States of the run at which each law is timed in a round."""

COMPARED = ("modified-null-space-vector", "jmdc")


def cost_claims(r: Reproduction) -> list[Claim]:
    """Return the claim about the computational load."""
    ratios = tick_ratios(r)
    mode = "compiled" if kernels_compiled() else "as plain NumPy"
    low, ratio, high = np.quantile(ratios, [0.0, 0.5, 1.0])
    return [
        Claim(
            "computational load",
            "JMDC needs one pseudoinverse, the modified method several: JMDC suits real-time control better.",
            f"a tick of the modified method, {mode}, takes {ratio:.2f} times a tick of JMDC "
            f"(median of {ROUNDS} rounds in turn, {low:.2f} to {high:.2f})",
            AGREES if low > 1.0 else DIFFERS if high < 1.0 else PARTLY,
            "minimum torque needs no projector and no n × n pseudoinverse, while JMDC pays for the gradient of the "
            "minor measure",
        )
    ]


def tick_ratios(r: Reproduction) -> list[float]:
    """Time `torque` of the modified method and of JMDC over the same states, in turn.

    Returns:
        The ratio of their times, modified method over JMDC, one a round.
    """
    run = r.runs["jmdc"]
    picked = np.linspace(0, len(run.t) - 1, TICKS).astype(int)
    targets = [Target(run.x_desired[i], run.dx_desired[i], run.ddx_desired[i]) for i in picked]
    calls = list(zip(run.q[picked], run.v[picked], targets, strict=True))
    laws = [controllers.create(law, run.arm) for law in COMPARED]
    ratios = []
    for _ in range(ROUNDS + 1):
        seconds = []
        for law in laws:
            law.reset(run.q[0], run.v[0], run.info.dt)
            begin = time.perf_counter()
            for q, v, target in calls:
                law.torque(q, v, target)
            seconds.append(time.perf_counter() - begin)
        ratios.append(seconds[0] / seconds[1])
    return ratios[1:]
