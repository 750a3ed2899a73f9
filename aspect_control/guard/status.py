"""How a guard stands to its law, and what it remembers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..arm import ArmState
from ..redundancy import Array
from .monitor import Watch
from .plausibility import AS_TOLD
from .viability import Certificate

RUNNING, LIMITING, STOPPING, STOPPED = "running", "limiting", "stopping", "stopped"
"""The stages of a guard, in their order."""


@dataclass(frozen=True, slots=True)
class GuardStatus:
    """What a guard does, and why.

    Attributes:
        state: `"running"`: the law's torque is passed on as it is; `"limiting"`: since the last `reset` a limit has
            held and the torque was cut to it; `"stopping"`: the arm is being braked; `"stopped"`: it is at rest and its
            posture is held.
        reason: Why, in plain words; empty while running.
    """

    state: str
    reason: str = ""


class Stage(NamedTuple):
    """What changes only when a guard goes from one stage to the next.

    Attributes:
        status: What the guard does, and why.
        dt: Δt, s.
        steps: How far each torque may go in one sample, N m.
        start: The configuration that `reset` was given, shape (nq,), rad.
        held: The configuration that is held once the arm has stopped, shape (nq,), rad; None before.
        reading: How q and v are to be read, where they were told in another way; see `Plausibility`.
        braking: Whether the law is no longer asked.
    """

    status: GuardStatus
    dt: float
    steps: list[float]
    start: Array
    held: Array | None = None
    reading: str = AS_TOLD
    braking: bool = False


class GuardMemory(NamedTuple):
    """What a guard carries from one sample to the next.

    Attributes:
        stage: What changes only from stage to stage.
        state: The arm's last state that was believed; None before the first.
        tau: The last torque, N m, one a joint.
        positions: The last measured joint configuration, rad.
        speeds: The last measured joint velocities, rad/s, one a joint.
        desired: The last target's position, m.
        certificate: Where the arm is known to be able to stop; None where nothing is known.
        watch: What the monitor keeps; None before the first sample.
        countdown: Samples until the monitor looks again.
        agreeing: Samples after one another that repeat the one before; while braking, that agree with each other.
    """

    stage: Stage
    state: ArmState | None
    tau: list[float]
    positions: list[float]
    speeds: list[float]
    desired: list[float]
    certificate: Certificate | None = None
    watch: Watch | None = None
    countdown: int = 0
    agreeing: int = 0
