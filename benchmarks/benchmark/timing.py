"""Times of calls that take turns, so that a change of the machine's speed meets all of them.

Wall time; the median of the rounds leaves out those in which the machine did something else.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from aspect_control.redundancy import Array

BATCH = 1e-3
"""How long a call is repeated in one round, s."""

WARM = 0.25
"""Part of the repetitions that is not timed before each batch: the call before has taken up the caches."""

NUMPY, COMPILED = "NumPy", "compiled"
"""How the laws ran: as they stand, or after `compile_kernels`."""

PERCENTILES = {"99th percentile": 99.0, "99.9th percentile": 99.9, "maximum": 100.0}
"""What is told of all ticks of a motion besides the median."""

Call = Callable[[], Any]


@dataclass(frozen=True)
class Row:
    """One line of the benchmark.

    Attributes:
        group: What is compared with what.
        name: What was timed.
        seconds: Time of one call in each round, shape (rounds,), s.
        base: Time of what it is compared with in the same rounds, shape (rounds,), s.
        of: What that is.
        note: What else there is to say.
    """

    group: str
    name: str
    seconds: Array
    base: Array
    of: str
    note: str = ""

    @property
    def ratio(self) -> float:
        """Median of the ratios of the rounds."""
        return float(np.median(self.seconds / self.base))

    def to_dict(self) -> dict[str, Any]:
        """Return the row with medians and quartiles, in microseconds."""
        low, middle, high = np.quantile(self.seconds / self.base, (0.25, 0.5, 0.75))
        times = np.quantile(1e6 * self.seconds, (0.25, 0.5, 0.75))
        return {
            "group": self.group,
            "name": self.name,
            "ratio": float(middle),
            "ratio_quartiles": [float(low), float(high)],
            "of": self.of,
            "microseconds": float(times[1]),
            "microseconds_quartiles": [float(times[0]), float(times[2])],
            "note": self.note,
        }


class EveryTick(Row):
    """A row of every tick of a motion, each timed by itself, in units of the median of the floor in the same pass."""

    @property
    def percentiles(self) -> dict[str, float]:
        """The `PERCENTILES` of the ratios, by name."""
        ratios = np.percentile(self.seconds / self.base, list(PERCENTILES.values()))
        return dict(zip(PERCENTILES, ratios.tolist(), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return the row as `Row` does, with the percentiles and the number of ticks."""
        return {**super().to_dict(), **self.percentiles, "ticks": len(self.seconds)}


@dataclass(frozen=True)
class Motion:
    """What is called at every sample of a motion.

    Attributes:
        tick: Called with each sample, in order.
        begin: Called before the first sample of each pass, such as with the `reset` of a law.
    """

    tick: Callable[[Any], Any]
    begin: Call = lambda: None


def every_tick(group: str, calls: Mapping[str, Motion], samples: Sequence[Any], least: int) -> list[EveryTick]:
    """Time every tick of a motion by itself: a control loop lives by its worst one.

    The motion is gone through in order, again and again; in each pass the calls take turns. Before its pass a call goes
    through the beginning of the motion untimed, for the one before has taken up the caches. Garbage is not collected
    meanwhile, as in a loop on a robot.

    Args:
        group: Name of the group of rows.
        calls: Calls by name, `"floor"` among them, the unit.
        samples: Samples of the motion.
        least: The least number of ticks of each call.

    Returns:
        A row a call.
    """
    passes = math.ceil(least / len(samples))
    seconds: dict[str, list[Array]] = {name: [] for name in calls}
    with _no_garbage_collected():
        for _ in range(passes):
            for name, call in calls.items():
                _times(call, samples[: math.ceil(WARM * len(samples))])
                seconds[name].append(_times(call, samples))
    unit = np.repeat([np.median(each) for each in seconds["floor"]], len(samples))
    return [EveryTick(group, name, np.concatenate(seconds[name]), unit, "median floor") for name in calls]


def interleaved(calls: Mapping[str, Call], rounds: int) -> dict[str, Array]:
    """Time calls in turn.

    Args:
        calls: Calls by name. One that returns a number returns the seconds that it took itself, for one call of what
            it stands for; all others are timed here, repeated for about `BATCH`.
        rounds: Number of rounds.

    Returns:
        Seconds of one call in each round, shape (rounds,), by name.
    """
    repeats = {name: 0 if type(call()) is float else _repeats(call) for name, call in calls.items()}
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            if repeats[name] == 0:
                seconds[name].append(call())
                continue
            _time(call, math.ceil(WARM * repeats[name]))
            seconds[name].append(_time(call, repeats[name]))
    return {name: np.array(values) for name, values in seconds.items()}


def around(call: Callable[[Any], Any], arguments: list[Any]) -> Call:
    """Return a call that takes the next of some arguments each time, so that no cache holds only one state."""
    cycle = _endless(arguments)
    return lambda: call(next(cycle))


def _endless(arguments: list[Any]) -> Iterator[Any]:
    while True:
        yield from arguments


def _time(call: Call, repeats: int) -> float:
    begin = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - begin) / repeats


def _times(call: Motion, samples: Sequence[Any]) -> Array:
    clock, tick, seconds = time.perf_counter, call.tick, np.empty(len(samples))
    call.begin()
    for i, sample in enumerate(samples):
        begin = clock()
        tick(sample)
        seconds[i] = clock() - begin
    return seconds


@contextmanager
def _no_garbage_collected() -> Iterator[None]:
    was_enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if was_enabled:
            gc.enable()


def _repeats(call: Call) -> int:
    """Return how many calls take about `BATCH`: batches double, the faster of two counts, for first calls are slow."""
    repeats = 1
    while repeats * (seconds := min(_time(call, repeats), _time(call, repeats))) < BATCH / 2.0:
        repeats *= 2
    return max(1, round(BATCH / seconds))


@contextmanager
def one_thread() -> Iterator[None]:
    """Hold the process on the processor that it runs on, where the system allows it, so that nothing runs beside it."""
    import os

    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
