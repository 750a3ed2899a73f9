"""Random sequences of faults under random laws and limits, and whether a guard ever breaks its word."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from ... import controllers
from ...arm import Arm, ArmState
from ...controllers import Controller
from ...guard import AS_TOLD, GUARD_FAILED, Guard
from ...plants import RigidBodyPlant
from ...redundancy import Array
from ...simulation import RungeKutta4
from ...trajectories import StraightLine, Target
from .faults import FAULTS, Call, Stubborn

ROUNDING = 1e-9
"""Part by which rounding may break a limit."""


@dataclass(frozen=True)
class HostileOutcome:
    """How one sequence went.

    Attributes:
        index: Index of the sequence; with the seed it fixes everything.
        law: Name of the law.
        fault: What went wrong.
        state: State of the guard at the end.
        samples: Number of samples.
        positioned: Whether its position limits counted to the end.
        broken: Which bounds were broken, in words; empty if none was.
    """

    index: int
    law: str
    fault: str
    state: str
    samples: int
    positioned: bool
    broken: tuple[str, ...]


@dataclass
class Sequences:
    """What came of many sequences.

    Attributes:
        sequences: How many there were.
        samples: How many samples they had.
        positioned: In how many the position limits counted to the end.
        states: How often the guard ended in each state.
        laws: How often each law was drawn.
        faults: How often each fault was drawn.
        broken: The outcomes in which a bound was broken.
    """

    sequences: int = 0
    samples: int = 0
    positioned: int = 0
    states: Counter[str] = field(default_factory=Counter)
    laws: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    broken: list[HostileOutcome] = field(default_factory=list)

    def add(self, outcome: HostileOutcome) -> None:
        """Count one more sequence."""
        self.sequences += 1
        self.samples += outcome.samples
        self.positioned += outcome.positioned
        self.states[outcome.state] += 1
        self.laws[outcome.law] += 1
        self.faults[outcome.fault] += 1
        if outcome.broken:
            self.broken.append(outcome)

    def to_dict(self) -> dict[str, Any]:
        """Return the counts as plain data."""
        return {
            "sequences": self.sequences,
            "samples": self.samples,
            "positioned": self.positioned,
            "states": dict(self.states),
            "laws": dict(self.laws),
            "faults": dict(self.faults),
            "broken": [vars(each) for each in self.broken],
        }


class Thrashing(Controller):
    """A law that means harm: it throws torques about, all at once or from one sample to the next."""

    name = "thrashing"

    def __init__(self, arm: Arm, size: Array, kind: int, seed: int) -> None:
        """Set the largest torques, shape (n,), N m, what is done with them and the seed."""
        super().__init__(arm, 1, 0.0, 0.0)
        self._size, self._kind, self._rng = size, kind, np.random.default_rng(seed)
        self._side = self._rng.choice([-1.0, 1.0], arm.nv)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (n,), N m."""
        if self._kind == 0:
            return np.asarray(self._size * self._rng.normal(size=self.arm.nv))
        if self._kind == 1:
            return self._pushed()
        if self._kind == 2:
            self._side = -self._side
            return self._pushed()
        if self._rng.random() < 0.02:
            return np.full(self.arm.nv, np.nan)
        return state.nle + state.M @ (self._side * self._rng.uniform(0.0, 30.0))

    def _pushed(self) -> Array:
        torque: Array = self._size * self._side
        return torque


def hostile_sequences(
    count: int, seed: int = 0, progress: Callable[[str, float], None] | None = None, first: int = 0
) -> Sequences:
    """Run many sequences.

    Args:
        count: How many.
        seed: Seed of the draws; a sequence depends on it and on its index alone.
        progress: Called with what is being done and the part that is done, 0 to 1.
        first: Index of the first sequence.
    """
    found = Sequences()
    for i in range(count):
        found.add(hostile_sequence(seed, first + i))
        if progress is not None and i % 20 == 0:
            progress(f"{found.samples:,} samples, {len(found.broken)} broken", i / count)
    return found


def hostile_sequence(seed: int, index: int) -> HostileOutcome:
    """Run one sequence: a planar arm under a random law with random limits, and a fault at a random sample.

    The arm lies in its horizontal plane or hangs in a vertical one. A bound of position counts where the guard let the
    first sample pass, so that the arm could be stopped when it took over; faults that hide from it where the arm is, or
    make it see only some of the samples, are not held against it there: it then goes by the arm's model.
    """
    rng = np.random.default_rng([seed, index])
    arm = _arm(bool(rng.random() < 0.5))
    n, plant, method = arm.nv, RigidBodyPlant(arm), RungeKutta4()
    dt = float(rng.choice([1e-3, 2e-3, 5e-3]))
    torque = (700.0 if arm.gravity.any() else 60.0) * np.exp(rng.uniform(-0.7, 0.7, n))
    lower, upper = rng.uniform(-2.0, -0.3, n), rng.uniform(0.3, 2.0, n)
    rate = torque / rng.choice([0.01, 0.03, 0.1]) if rng.random() < 0.5 else None
    law = Stubborn(_law(arm, torque, rng))
    guard = Guard(
        law,
        torque=torque,
        torque_rate=rate,
        speed=rng.uniform(0.5, 6.0, n),
        position=(lower, upper),
        acceleration=float(rng.uniform(5.0, 60.0)) if rng.random() < 0.3 else None,
        tracking=0.1 if rng.random() < 0.5 else None,
        jump=0.02 if rng.random() < 0.5 else None,
    )
    q = arm.configuration(lower + (upper - lower) * rng.uniform(0.05, 0.95, n))
    v = rng.normal(size=n) * rng.choice([0.0, 0.0, 0.5])
    fault = FAULTS[rng.integers(len(FAULTS))] if rng.random() < 0.7 else None
    samples = int(rng.integers(10, 40))
    begins = int(rng.integers(1, samples)) if fault is None or not fault.from_start else 0
    line, x = StraightLine(rng.uniform(-0.4, 0.4, 2), duration=samples * dt), arm.task_position(q)
    last, broken, first, positioned = _gravity(arm, q, guard), set[str](), None, True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a start near the border of an aspect
        for i in range(samples):
            call = Call(q, v, line.target(i * dt, x, arm.coordinates))
            wrong = fault is not None and i >= begins
            if fault is not None and wrong:
                first, law.told = call if first is None else first, fault.raises
                call = call if fault.change is None else fault.change(arm, call, first)
            if i == 0 and (fault is None or fault.reset):
                guard.reset(call.q, call.v, dt)
                last = _gravity(arm, call.q, guard)
            tau = guard.torque(*call)
            if i == 0:
                positioned = not guard.brakes
                # A guard that has recognised degrees, or q and v swapped, begins at the posture that is meant.
                last = last if guard.reading == AS_TOLD else _gravity(arm, q, guard)
            broken |= _broken(tau, last, guard, dt if fault is None or fault.reset else 1e-3)
            last = tau
            pace = fault.pace if fault is not None and wrong else 1
            for _ in range(pace):
                q, v = method.step(plant, q, v, tau, dt)
            positioned = positioned and not (fault is not None and wrong and fault.hides)
            if positioned and ((q < lower - ROUNDING) | (q > upper + ROUNDING)).any():
                broken.add("position")
    name = "none" if fault is None else fault.name
    return HostileOutcome(index, law.name, name, guard.status.state, samples, positioned, tuple(sorted(broken)))


def _broken(tau: Array, last: Array, guard: Guard, dt: float) -> set[str]:
    """Return which bounds a torque breaks."""
    limits, found = guard.limits, set[str]()
    if not (tau.shape == last.shape and np.isfinite(tau).all() and (np.abs(tau) <= limits.torque).all()):
        found.add("torque")
    if not (np.abs(tau - last) <= limits.rate * dt + ROUNDING * limits.torque).all():
        found.add("torque rate")
    if GUARD_FAILED in guard.status.reason:
        found.add("guard")
    return found


def _gravity(arm: Arm, q: Array, guard: Guard) -> Array:
    gravity = arm.state(q, np.zeros(arm.nv)).nle
    return np.clip(gravity, -guard.limits.torque, guard.limits.torque)


def _law(arm: Arm, torque: Array, rng: np.random.Generator) -> Controller:
    names = [*controllers.available(), Thrashing.name]
    name = names[rng.integers(len(names))]
    if name == Thrashing.name:
        size = torque * float(rng.choice([0.3, 1.0, 10.0]))
        return Thrashing(arm, size, int(rng.integers(4)), int(rng.integers(2**31)))
    gain = float(rng.choice([25.0, 100.0, 1600.0]))
    return controllers.create(name, arm, kp=gain, kv=2.0 * gain**0.5)


@cache
def _arm(vertical: bool) -> Arm:
    return Arm.from_example("planar3r", frame="tool", task="xy", gravity=(0.0, -9.81 if vertical else 0.0, 0.0))
