"""The closed loop: a law, a trajectory and a plant, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import finite_vector, positive
from ..controllers import Controller
from ..exceptions import NonFiniteError, ParameterError, ShapeError, shown
from ..guard import Guard
from ..limits import joint_limit
from ..plants import Plant, RigidBodyPlant
from ..plants.registry import PLANTS
from ..trajectories import Trajectory
from .events import DEFAULT_EVENTS, Event, Sample
from .events.registry import EVENTS
from .integrators import Integrator
from .integrators.registry import INTEGRATORS
from .recorder import Recorder, read_only_view
from .run import Run
from .run_file import MAX_SAMPLES, RunInfo, versions


def simulate(
    controller: Controller,
    trajectory: Trajectory,
    *,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    dt: float = 1e-3,
    plant: Plant | str | Mapping[str, Any] | None = None,
    integrator: Integrator | str | Mapping[str, Any] = "rk4",
    saturation: ArrayLike | str | None = None,
    events: Sequence[Event | str | Mapping[str, Any]] = DEFAULT_EVENTS,
    progress: Callable[[float], None] | None = None,
    watch: Callable[[Sample], None] | None = None,
) -> Run:
    """Run a law on a trajectory in closed loop and record it.

    The torque is computed at every sample and held until the next. The trajectory starts where q0 puts the task
    frame. Whatever ends the run early, what was recorded up to then is returned; `run.status` and `run.message` say how
    and why it ended:

    - by an event, with the event's own status;
    - as `"stopped"` by a `Guard` around the law, once the arm is at rest; while it brakes, no event ends the run;
    - as `"diverged"`, whatever the events, when a state or a torque is no longer finite;
    - as `"interrupted"` by the user's Ctrl-C, and as `"failed"` by an exception in `watch`, an event or `progress`:
      `run.error` is what was raised, so that `raise run.error` goes on with it.

    An exception in the law or the trajectory is not a way for a run to end: it reaches the caller as it is.

    Args:
        controller: The law, with its arm.
        trajectory: What the task is to do.
        q0: Joint configuration at the start, shape (nq,), rad.
        v0: Joint velocity at the start, shape (nv,), rad/s; None for rest.
        dt: Sampling time, s.
        plant: What moves under the torque: a plant of the law's arm, or its name, alone or with parameters as
            `{"name": ..., ...}`; None for `RigidBodyPlant`, ideal rigid bodies.
        integrator: An integrator, or its name, alone or with parameters; see `simulation.integrators.available`.
        saturation: Largest |τ| that the motors give, N m: a number, one a joint, or `"urdf"` for the robot's own; the
            torque is cut off there and recorded as it was applied. None for motors without limits.
        events: What ends the run early: events, or their names, alone or with parameters; see
            `simulation.events.available`.
        progress: Called with the part of the motion that is done, 0 to 1, about a hundred times.
        watch: Called with every sample as it is recorded, such as `views.LiveView.watch`; its arrays are read-only.

    Returns:
        The run, with k = ⌊duration / dt⌋ + 1 samples if nothing ends it early; the sample at which an event or an
        exception ends it is recorded.

    Raises:
        ShapeError: If q0 or v0 has the wrong shape, or the trajectory another number of task coordinates than the arm.
        NonFiniteError: If q0 or v0 is not finite.
        ParameterError: If the torque at the start is not finite, dt is not above zero, longer than the motion, or so
            short that the recording would not fit; or the law, the trajectory or a callback is none, or the plant is
            one of another arm.
        UnknownNameError: If there is no such plant, integrator or event.
        KeyboardInterrupt: If the user's Ctrl-C comes before anything is recorded.
    """
    _require_kind("controller", controller, Controller)
    _require_kind("trajectory", trajectory, Trajectory)
    for name, callback in (("progress", progress), ("watch", watch)):
        if callback is not None and not callable(callback):
            raise ParameterError(f"{name} must be a function or None, got {shown(callback)}")
    arm = controller.arm
    q = arm.joints.checked_configuration(finite_vector("q0", q0, arm.nq))
    v = finite_vector("v0", v0, arm.nv) if v0 is not None else np.zeros(arm.nv)
    samples = _samples(trajectory.duration, positive("dt", dt, "s"))
    limit = None if saturation is None else joint_limit("saturation", saturation, arm.nv, arm.torque_limit)
    if trajectory.task_dim not in (None, arm.task_dim):
        raise ShapeError(
            f"the trajectory has {trajectory.task_dim} task coordinates, "
            f"the arm's task {arm.task} has {arm.task_dim}: give one number for each"
        )
    ends, body, method = _events_of(arm, events), _plant_of(arm, plant), INTEGRATORS.make(integrator, arm)
    ends = [each.begin(arm, trajectory, q) for each in ends]
    start, task = arm.task_position(q), arm.coordinates
    recorder = Recorder(arm, np.arange(samples, dtype=np.float64) * dt)
    report_every = max(1, samples // 100)
    end = _End("finished", float(recorder.t[-1]))
    controller.reset(q, v, dt)
    try:
        for i in range(samples):
            t = recorder.t.item(i)
            target = trajectory.target(t, start, task)
            try:
                tau = controller.torque(q, v, target)
            except NonFiniteError as error:
                end = _End("diverged", t, str(error))
                break
            applied = tau if limit is None else np.clip(tau, -limit, limit)
            q, v = recorder.add(q, v, applied, target)
            sample = Sample(arm, t, q, v, read_only_view(tau), target)
            if watch is not None:
                _call("watch", watch, sample)
            guard = controller if isinstance(controller, Guard) and controller.brakes else None
            ended = _event_at(sample, ends) if guard is None else _stopped(guard, t, last=i == samples - 1)
            if ended is not None:
                end = ended
                break
            q, v = method.step(body, q, v, applied, dt)
            if progress is not None and (i + 1) % report_every == 0:
                _call("progress", progress, (i + 1) / samples)
        if progress is not None:
            _call("progress", progress, 1.0)
    except _CallbackError as raised:
        end = _End("failed", recorder.last, str(raised), raised.error)
    except KeyboardInterrupt as error:
        if recorder.count == 0:
            raise
        end = _End("interrupted", recorder.last, "by the user", error)
    if recorder.count == 0:
        raise ParameterError(f"the run cannot start: {end.message}")
    info = RunInfo(
        controller=controller.name,
        parameters=controller.parameters,
        switches=controller.switches,
        trajectory=repr(trajectory),
        dt=dt,
        integrator=method.name,
        status=end.status,
        message=end.message,
        versions=dict(_versions()),
        plant=body.name,
    )
    return recorder.run(info, end.error)


class _End(NamedTuple):
    """How a run ended, when, and what was raised, if anything."""

    status: str
    t: float
    reason: str = ""
    error: BaseException | None = None

    @property
    def message(self) -> str:
        """The status in words."""
        return f"{self.status} at t = {self.t:.6g} s{': ' if self.reason else ''}{self.reason}"


class _CallbackError(Exception):
    """What the user's own code raised while a run called it."""

    def __init__(self, name: str, error: Exception) -> None:
        super().__init__(f"{name} raised {type(error).__name__}: {error}")
        self.error = error


def _call(name: str, callback: Callable[[Any], None], argument: Any) -> None:
    try:
        callback(argument)
    except Exception as error:
        raise _CallbackError(name, error) from error


_versions = cache(versions)


def completed(run: Run) -> Run:
    """Return a run that came to an end by itself or by an event; go on with what interrupted it otherwise.

    For code that makes many runs: the user's Ctrl-C is meant for all of them.

    Raises:
        BaseException: `run.error`, if there is one.
    """
    if run.error is not None:
        raise run.error
    return run


def _require_kind(name: str, value: object, kind: type) -> None:
    if not isinstance(value, kind):
        raise ParameterError(f"{name} must be a {kind.__name__}, got {shown(value)}")


def _plant_of(arm: Arm, given: Plant | str | Mapping[str, Any] | None) -> Plant:
    plant = RigidBodyPlant(arm) if given is None else PLANTS.make(given, arm)
    if plant.arm is not arm and plant.arm.description != arm.description:
        raise ParameterError(f"the plant must be one of the law's arm {arm!r}, got one of {plant.arm!r}")
    return plant


def _events_of(arm: Arm, given: Sequence[Event | str | Mapping[str, Any]]) -> list[Event]:
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise ParameterError(f"events must be a sequence of events or their names, got {shown(given)}")
    events = [EVENTS.make(each, arm) for each in given]
    for event in events:
        event.require_fits(arm)
    return events


def _event_at(sample: Sample, events: Sequence[Event]) -> _End | None:
    """Return the end that the first event brings about, if one does."""
    for event in events:
        try:
            reason = event.check(sample)
        except Exception as error:
            raise _CallbackError(type(event).__name__, error) from error
        if reason is not None:
            return _End(event.status, sample.t, reason)
    return None


def _stopped(guard: Guard, t: float, *, last: bool) -> _End | None:
    """Return the end that a guard brings about that brakes, once the arm is at rest or the motion is over."""
    return _End("stopped", t, guard.status.reason) if last or guard.status.state == "stopped" else None


def _samples(duration: float, dt: float) -> int:
    if dt > duration:
        raise ParameterError(f"dt must not be longer than the motion of {duration:g} s, got {dt:g} s")
    steps = duration / dt
    if steps >= MAX_SAMPLES:
        raise ParameterError(
            f"dt = {dt:g} s would record {steps:.3g} samples of a {duration:g} s motion; "
            f"at most {MAX_SAMPLES:,} fit: give at least {duration / MAX_SAMPLES:.1g} s"
        )
    return math.floor(steps * (1.0 + 1e-12)) + 1
