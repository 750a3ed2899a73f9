"""How well a loop kept its time."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..redundancy import Array


class Percentiles(NamedTuple):
    """How a time was distributed, s.

    Attributes:
        p50: The median.
        p99: What 99 % were at most.
        p99_9: What 99.9 % were at most.
        maximum: The longest.
    """

    p50: float
    p99: float
    p99_9: float
    maximum: float

    @classmethod
    def of(cls, times: Array) -> Percentiles:
        """Return the percentiles of some times, shape (any,), s; all are NaN if there are none."""
        if len(times) == 0:
            return cls(*[float("nan")] * 4)
        return cls(*(float(each) for each in np.percentile(times, (50.0, 99.0, 99.9, 100.0))))


@dataclass(frozen=True, eq=False)
class Timing:
    """How well a loop of k samples kept its time.

    A tick is the time from the sample, once it was read, until its torque was written: the target, the law, the driver.

    Attributes:
        dt: The sampling time that was asked for, s.
        periods: Times between one sample and the next as they arrived, shape (k − 1,), s.
        ticks: Times of the ticks, shape (k,), s.
        deadlines_missed: Number of samples whose torque was written later than dt after the sample was due; on a
            robot's own clock that is when it arrived.
        samples_lost: Number of samples that are missing on the clock that the loop lived on.
        collections: How often Python's garbage collector ran.
        warm_up: Time that the law was warmed up before the first sample, s.
    """

    dt: float
    periods: Array
    ticks: Array
    deadlines_missed: int
    samples_lost: int
    collections: int
    warm_up: float

    @property
    def period(self) -> Percentiles:
        """The percentiles of the periods."""
        return Percentiles.of(self.periods)

    @property
    def tick(self) -> Percentiles:
        """The percentiles of the ticks."""
        return Percentiles.of(self.ticks)

    def __str__(self) -> str:
        """Say it in three lines."""
        rows = (("tick", self.tick), ("period", self.period))
        lines = [
            f"{name:<6}  p50 {times.p50 * 1e6:.0f} µs, p99 {times.p99 * 1e6:.0f} µs, p99.9 {times.p99_9 * 1e6:.0f} µs, "
            f"max {times.maximum * 1e6:.0f} µs"
            for name, times in rows
        ]
        lines.append(
            f"{len(self.ticks):,} samples of {self.dt * 1e3:g} ms: {self.deadlines_missed:,} deadlines missed, "
            f"{self.samples_lost:,} samples lost, {self.collections:,} garbage collections; "
            f"law warmed up in {self.warm_up * 1e3:.3g} ms"
        )
        return "\n".join(lines)


class Stopwatch:
    """The timing of a loop in the making."""

    def __init__(self, dt: float) -> None:
        """Set the sampling time, s."""
        self._dt = dt
        self._t, self._due, self._arrived, self._written = array("d"), array("d"), array("d"), array("d")

    def add(self, t: float, due: float, arrived: float, written: float) -> None:
        """Note one sample: its time on the loop's clock, when it was due and arrived, and when its torque was written.

        All but t by `time.perf_counter`, s.
        """
        self._t.append(t)
        self._due.append(due)
        self._arrived.append(arrived)
        self._written.append(written)

    def timing(self, collections: int, warm_up: float) -> Timing:
        """Return what was measured; see `Timing` for the arguments."""
        t, due, arrived, written = (np.array(each) for each in (self._t, self._due, self._arrived, self._written))
        return Timing(
            dt=self._dt,
            periods=np.diff(arrived),
            ticks=written - arrived,
            deadlines_missed=int(np.count_nonzero(written - due > self._dt)),
            samples_lost=int(np.maximum(np.rint(np.diff(t) / self._dt) - 1.0, 0.0).sum()),
            collections=collections,
            warm_up=warm_up,
        )
