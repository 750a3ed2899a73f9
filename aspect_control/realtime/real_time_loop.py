"""A law on a real robot, at the robot's own pace, recorded and measured."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm.tasks import TaskValue
from ..checks import positive
from ..controllers import Controller
from ..exceptions import ParameterError, RobotError, shown
from ..redundancy import Array
from ..simulation import Run, RunInfo, Sample
from ..simulation.recorder import read_only_view
from ..simulation.run_file import versions
from ..trajectories import Hold, Target, Trajectory
from .interruptions import GarbageCollectorOff, StopSignals
from .motion import Following, Motion, Streaming
from .recording import Recording
from .robot_protocol import Robot
from .safe_stop import brake, gravity_compensation
from .samples import samples
from .timing import Stopwatch, Timing

WARM_UP = 20
"""Ticks before the first sample, which fill what is computed once and wake what is loaded late."""

FOR_EVER = 1e9
"""Duration of a `hold` that somebody else ends, s."""

_log = logging.getLogger(__name__)


class RealTimeLoop:
    """The closed loop of a law and a robot.

    A motion goes like this:

    1. The robot is read once and the law is warmed up there, which leaves no trace in it and sends nothing. The garbage
       collector is run once and then switched off until the motion has ended, so that none of its pauses falls into a
       tick. Both are logged (`logging`, level INFO) and measured: see `timing`.
    2. At every sample: read, target, torque, write, record, `watch`. A robot with a clock of its own sets the pace (see
       `ClockedRobot`); any other is read at absolute deadlines. Where samples were lost, the targets go on with the
       clock.
    3. Whatever ends the motion, the arm is then braked and held (`safe_stop.brake`), the last command holds it where it
       is, and `robot.stop()` is called if there is such a method. If the robot can no longer be read, one last command
       carries its weight where it was seen last. A robot that is on its own after that, or after a killed process,
       needs a watchdog of its own.

    Whatever ended it, what was recorded up to then is returned, and is `run`:

    - `"finished"`: the motion came to its end;
    - `"stopped"`: the law is one that stops by itself, such as a guard, and has (`law.status.state`);
    - `"interrupted"`: by SIGINT (Ctrl-C), SIGTERM or `SystemExit`; a second signal does what it does outside the loop;
    - `"failed"`: by an exception in the robot, the law, the motion or `watch`.

    `run.error` is what was raised in the latter two, so that `raise run.error` goes on with it. What is wrong before
    the first command is raised.

    Attributes:
        robot: The robot.
        law: The law.
        dt: The sampling time, s.
        run: The last run; None before the first.
        timing: How well it kept its time; without a sample before the first.
    """

    def __init__(
        self, robot: Robot, law: Controller, dt: float = 1e-3, *, watch: Callable[[Sample], None] | None = None
    ) -> None:
        """Set the robot, the law and the sampling time.

        Args:
            robot: Anything with `read() -> (q, v)` and `write(tau)`.
            law: The law, best a guarded one, with the arm whose joints the robot has.
            dt: Sampling time, s; for a robot with a clock of its own the period of that.
            watch: Called with every sample after its torque was written; its arrays are read-only.

        Raises:
            ParameterError: If one of them is none, or dt is not above zero.
        """
        if not isinstance(robot, Robot):
            raise ParameterError(f"robot must have read() and write(tau), got {shown(robot)}")
        if not isinstance(law, Controller):
            raise ParameterError(f"law must be a Controller, got {shown(law)}")
        if watch is not None and not callable(watch):
            raise ParameterError(f"watch must be a function or None, got {shown(watch)}")
        self.robot, self.law, self.dt, self._watch = robot, law, positive("dt", dt, "s"), watch
        self.run: Run | None = None
        self.timing: Timing = Stopwatch(self.dt).timing(0, 0.0)

    def follow(self, trajectory: Trajectory) -> Run:
        """Follow a trajectory from where the robot is.

        Args:
            trajectory: What the task is to do.

        Raises:
            ParameterError: If it is none.
            ShapeError: If it has another number of task coordinates than the arm.
            Exception: What is raised before the first command.
        """
        return self._go(Following(self.law.arm, trajectory))

    def hold(self, duration: float | None = None) -> Run:
        """Hold the task where it is.

        Args:
            duration: How long, s; None until a signal or the law ends it.

        Raises:
            ParameterError: If the duration is not above zero.
            Exception: What is raised before the first command.
        """
        return self._go(Following(self.law.arm, Hold(FOR_EVER if duration is None else duration)))

    def stream(
        self,
        targets: Iterable[TaskValue | None],
        *,
        speed: ArrayLike,
        acceleration: ArrayLike,
        jerk: ArrayLike,
    ) -> Run:
        """Go where the newest target is, smoothly, whenever it arrives; see `StreamedTarget`.

        Args:
            targets: Asked for one at every sample, and must answer at once: a task value, shape (m,), m, or a `pin.SE3`
                for a task with rotations, or None while there is nothing new. When it ends, the motion ends at the last
                target. A generator that looks into a queue or a socket is one.
            speed: Largest |ẋ_d|, m/s and rad/s, a number or one a task coordinate.
            acceleration: Largest |ẍ_d|, m/s² and rad/s², likewise.
            jerk: Largest rate of ẍ_d, m/s³ and rad/s³, likewise.

        Raises:
            ParameterError: If there are no targets to ask for, or a limit is not above zero.
            ShapeError: If a limit has the wrong shape.
            ImportError: If ruckig is not installed.
            Exception: What is raised before the first command.
        """
        motion = Streaming(self.law.arm, targets, speed=speed, acceleration=acceleration, jerk=jerk)
        return self._go(motion)

    def _go(self, motion: Motion) -> Run:
        arm, stopwatch, recording = self.law.arm, Stopwatch(self.dt), Recording(self.law.arm)
        q, v = self.robot.read()
        warm_up = self._warm_up(q, v)
        motion.start(arm.task_position(q))
        _log.info("law warmed up in %.3g ms; garbage collector off during the motion", warm_up * 1e3)
        with StopSignals() as signals, GarbageCollectorOff() as collector:
            end = self._loop(motion, recording, stopwatch, signals)
            if recording.last is not None:
                end = self._left_safe(end, *recording.last)
        if recording.count == 0:
            raise end.error or ParameterError("the motion has no sample")
        self.timing = stopwatch.timing(collector.collections, warm_up)
        self.run = recording.run(self._info(motion, end), end.error)
        _log.info("%s\n%s", end.message, self.timing)
        return self.run

    def _warm_up(self, q: ArrayLike, v: ArrayLike) -> float:
        """Run the law where the robot stands, put back what it remembers, and return how long it took, s.

        Raises:
            ParameterError: If the law is one that stops by itself, and does not even start here.
        """
        law, arm, began = self.law, self.law.arm, perf_counter()
        memory, rest = law.memory, np.zeros(arm.task_dim)
        try:
            for _ in range(WARM_UP):
                law.reset(q, v, self.dt)
                law.torque(q, v, Target(x=arm.task_position(q), dx=rest, ddx=rest))
                state, reason = _status(law)
                if state in ("stopping", "stopped"):
                    raise ParameterError(f"the law does not start here: {reason}")
        finally:
            law.memory = memory
        return perf_counter() - began

    def _loop(self, motion: Motion, recording: Recording, stopwatch: Stopwatch, signals: StopSignals) -> _End:
        """Run the motion to its end, whatever that is; nothing is raised."""
        robot, law, arm, watch, t = self.robot, self.law, self.law.arm, self._watch, 0.0
        try:
            readings = samples(robot, self.dt)
            while True:
                sample = next(readings)
                arrived = perf_counter()
                if signals.received is not None:
                    return _End("interrupted", sample.t, f"by {signals.received.name}", signals.error())
                if recording.count == 0:
                    motion.start(arm.task_position(sample.q))
                    law.reset(sample.q, sample.v, self.dt)
                elif sample.t - t < self.dt / 2.0:
                    raise RobotError(f"the robot's clock went from {t:g} s to {sample.t:g} s, dt is {self.dt:g} s")
                t = sample.t
                target = motion.target(t)
                if target is None:
                    return _End("finished", t)
                tau = read_only_view(law.torque(sample.q, sample.v, target))
                recording.last = sample.q, tau
                robot.write(tau)
                stopwatch.add(t, sample.due, arrived, perf_counter())
                q, v = recording.add(t, sample.q, sample.v, tau, target)
                if watch is not None:
                    watch(Sample(arm, t, q, v, tau, target))
                state, reason = _status(law)
                if state == "stopped":
                    return _End("stopped", t, reason)
        except (KeyboardInterrupt, SystemExit) as error:
            return _End("interrupted", t, f"by {type(error).__name__}", error)
        except BaseException as error:
            return _End("failed", t, f"{type(error).__name__}: {error}", error)

    def _left_safe(self, end: _End, q: ArrayLike, tau: Array) -> _End:
        """Brake the arm, stop the robot, and return the end with what went wrong in that; see `Recording.last`."""
        arm, robot, trouble = self.law.arm, self.robot, ""
        try:
            if not brake(arm, robot, samples(robot, self.dt), self.dt, tau):
                trouble = "the arm was not brought to rest"
        except BaseException as error:
            trouble = f"the arm was not braked: {type(error).__name__}: {error}"
            with suppress(Exception):
                robot.write(gravity_compensation(arm, q))
        try:
            stop = getattr(robot, "stop", None)
            if stop is not None:
                stop()
        except BaseException as error:
            trouble = f"{trouble}{'; ' if trouble else ''}robot.stop() raised {type(error).__name__}: {error}"
        if trouble:
            return end._replace(reason=f"{end.reason}{'; ' if end.reason else ''}{trouble}")
        return end

    def _info(self, motion: Motion, end: _End) -> RunInfo:
        return RunInfo(
            controller=self.law.name,
            parameters=self.law.parameters,
            switches=self.law.switches,
            trajectory=repr(motion),
            dt=self.dt,
            integrator="none",
            status=end.status,
            message=end.message,
            versions=dict(_versions()),
            plant=type(self.robot).__name__,
        )


class _End(NamedTuple):
    """How a motion ended, when, and what was raised, if anything."""

    status: str
    t: float
    reason: str = ""
    error: BaseException | None = None

    @property
    def message(self) -> str:
        """The status in words."""
        return f"{self.status} at t = {self.t:.6g} s{': ' if self.reason else ''}{self.reason}"


_versions = cache(versions)


def _status(law: Controller) -> tuple[str, str]:
    """Return the state of a law that stops by itself, such as a guard, and the reason; empty for any other law."""
    status = getattr(law, "status", None)
    return str(getattr(status, "state", "")), str(getattr(status, "reason", ""))
