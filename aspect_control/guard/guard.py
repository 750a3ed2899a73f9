"""A guard: what stands between a torque law and a robot."""

from __future__ import annotations

from collections.abc import Callable
from math import dist, hypot
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import ArmState
from ..arm.tasks import TaskValue
from ..controllers import Controller
from ..exceptions import AspectControlError, ParameterError, shown
from ..redundancy import Array
from ..trajectories import Target
from .belief import LEAP, Belief
from .bounds import GuardLimits
from .braking import STILL, Brake
from .monitor import Monitor, Watch
from .plausibility import AS_TOLD, Plausibility
from .status import LIMITING, RUNNING, STOPPED, STOPPING, GuardMemory, GuardStatus, Stage
from .viability import NEIGHBOURHOOD, Viability

NOT_RESET = "the guard was not reset: call reset(q, v, dt) before the first torque(q, v, target)"
"""Why a guard stops that was never told where a motion starts."""

_set, _memory = object.__setattr__, tuple.__new__

GUARD_FAILED = "the guard itself failed"
"""How the reason begins for which a guard stops that has a mistake."""

ASSUMED_DT = 1e-3
"""The sampling time that a guard takes for granted that was not reset, s."""

REPEATS, UNSEEN = 5, 1e-3
"""How often a sample may be repeated, and how far the joints may have gone meanwhile by their speed, rad."""


class Guard(Controller):
    """A law with a guard around it, itself a law: every torque is within its limits, whatever the law says or raises.

    At every sample the guard asks its law for a torque and passes it on, to the last bit, as long as no limit holds
    and one more sample of it leaves the arm where it can still be stopped inside its limits; see `Viability`. `status`
    tells what it does:

    - `"running"`: the law's torque is passed on.
    - `"limiting"`: a limit of torque, torque rate or acceleration has held since the last `reset`; the law's torque is
      passed on as far as the limits allow.
    - `"stopping"`: the law is no longer asked; the arm is braked, gravity compensated and without a step in the torque;
      see `Brake`.
    - `"stopped"`: the arm is at rest and its posture is held.

    It goes from one to a later one only, and back to running by `reset`. It stops the arm

    - before the first torque, if q is in degrees, the target in millimetres, q and v are swapped, a joint starts
      outside its limits, the posture does not belong to the target, or `reset` was not called or was told another one;
    - when the arm could not be stopped inside its position and speed limits any more one sample later;
    - when the target is too far away, jumps or is none; when q or v is not finite, has another shape or leaps;
    - when the law raises an exception or returns no torque;
    - when, looked at every 25 ms, the self-motion and the energy keep growing, the Jacobian is losing its rank, the
      target asks for more speed than a joint has, or samples are lost, repeated or not as far apart as `dt`.

    `torque` raises nothing. A sample that cannot be believed is replaced by what the arm's model predicts. The torque
    before the first one counts as the one that holds the arm against gravity.

    Attributes:
        law: The law.
        limits: The limits.
        on_change: What is called with the status whenever its state changes.
    """

    memory: GuardMemory | None = None

    def __init__(
        self,
        law: Controller,
        *,
        torque: ArrayLike | str | None = "urdf",
        torque_rate: ArrayLike | None = None,
        speed: ArrayLike | str | None = "urdf",
        position: tuple[ArrayLike, ArrayLike] | str | None = "urdf",
        acceleration: ArrayLike | None = None,
        tracking: float | None = 0.1,
        jump: float | None = 0.02,
        distance: float | None = None,
        on_change: Callable[[GuardStatus], None] | None = None,
    ) -> None:
        """Set the law and its limits, each of which is a number or one a joint; None for no limit.

        Args:
            law: The law.
            torque: Largest |τ|, N m, or `"urdf"` for the robot's own.
            torque_rate: Largest |dτ/dt|, N m/s.
            speed: Largest |θ̇|, rad/s, or `"urdf"` for the robot's own.
            position: A pair (lower, upper), rad, or `"urdf"` for the robot's own.
            acceleration: Largest |θ̈| that the law may ask for, rad/s². It comes after torque and torque rate.
            tracking: Largest distance of the task frame from its target, m; for the rotations of a task, rad.
            jump: Largest jump of the target in one sample beyond the motion that it announces, m.
            distance: Largest distance of the target from the first joint, m; None for the arm's reach.
            on_change: Called with the new status whenever its state changes. What it raises is told in the reason.

        Raises:
            ShapeError: If a limit has the wrong shape.
            NonFiniteError: If a limit is NaN.
            ParameterError: If `law` is no law, a limit not above zero, a lower limit not below the upper, a joint that
                turns without end is given position limits, or the robot's description has no such limit.
        """
        if not isinstance(law, Controller):
            raise ParameterError(f"law must be a Controller, got {shown(law)}")
        if on_change is not None and not callable(on_change):
            raise ParameterError(f"on_change must be a function or None, got {shown(on_change)}")
        self.law, self.arm, self.kp, self.kv = law, law.arm, law.kp, law.kv
        self.name, self.switches = law.name, law.switches  # type: ignore[misc]
        self.limits = limits = GuardLimits(
            law.arm, torque, torque_rate, speed, position, acceleration, tracking, jump, distance
        )
        self.on_change = on_change
        self._viability, self._monitor = Viability(law.arm, limits), Monitor(law.arm, limits)
        self._brake = Brake(law.arm, limits, self._viability)
        self._plausibility = Plausibility(law.arm, limits, self._monitor)
        self._belief = Belief(law.arm, self._plausibility)
        self._rest, self._neutral = np.zeros(law.arm.nv), law.arm.configuration(np.zeros(law.arm.nv))
        task = law.arm.coordinates
        self._axes = task.position_axes if task.has_rotation else None

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters, and the limits as `guard`."""
        return {**self.law.parameters, "guard": self.limits.parameters}

    @property
    def status(self) -> GuardStatus:
        """What the guard does, and why."""
        return GuardStatus(STOPPED, NOT_RESET) if self.memory is None else self.memory.stage.status

    @property
    def reading(self) -> str:
        """How q and v are read: `"as told"`, or as `"degrees"` or `"swapped"` where the first sample gave that away."""
        return AS_TOLD if self.memory is None else self.memory.stage.reading

    @property
    def brakes(self) -> bool:
        """Whether the law is no longer asked: the arm is being braked, or held."""
        return self.memory is not None and self.memory.stage.braking

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Begin a motion: reset the law, and be running."""
        memory = self._begun(q, dt)
        self.law.reset(q, v, dt)
        self.memory = memory

    def torque(self, q: ArrayLike, v: ArrayLike, target: Target) -> Array:
        """Return the joint torque to apply until the next sample.

        Args:
            q: Measured joint configuration, shape (nq,), rad.
            v: Measured joint velocity, shape (nv,), rad/s.
            target: What the task is to do now.

        Returns:
            τ, shape (nv,), N m. Always finite and within the limits of torque and torque rate, also for a wrong sample.
        """
        memory, of_law = self.memory, self.law.memory
        try:
            try:
                state = self.arm.state(q, v)
            except Exception as error:
                return self._braked(None, f"the sample cannot be used: {error}")
            try:
                self.require_target(target)
            except AspectControlError as error:
                return self._braked(state, str(error))
            try:
                return self.command(state, target)
            except Exception as error:
                return self._braked(state, f"{GUARD_FAILED}: {type(error).__name__}: {error}")
        except BaseException:
            self.memory, self.law.memory = memory, of_law
            raise

    def command(self, state: ArmState, target: Target) -> Array:
        """Return the law's torque, or what the guard makes of it, shape (nv,), N m."""
        if self.memory is None:
            return self._braked(state, NOT_RESET)
        stage, _, tau_before, q_before, v_before, x_before, certificate, watch, countdown, repeats = self.memory
        if stage.braking:
            return self._braked(state, "")
        limits, q, v, asked_for, at = self.limits, state.q.tolist(), state.v.tolist(), target.x, state.x
        if self._axes is None:
            x_d, x = asked_for.tolist(), at.tolist()
        else:
            x_d, x = self._positions(asked_for), self._positions(at)
        near = certificate is not None and dist(q, certificate.q) <= NEIGHBOURHOOD
        countdown, reason = countdown - 1, ""
        repeats = repeats + 1 if q == q_before and v == v_before else 0
        if watch is None:
            reason, reading = self._plausibility.doubt(state, target, stage.start)
            if reading != AS_TOLD:
                meant = self._begun(self._plausibility.read(state, reading).q, stage.dt)
                self.memory = meant._replace(stage=meant.stage._replace(reading=reading))
        elif not near and dist(q, q_before) > LEAP + 3.0 * stage.dt * hypot(*v_before):
            far = dist(q, q_before)
            return self._braked(None, f"the measured position leaps by {far:.3g} rad: samples are lost, or wrong")
        elif repeats >= REPEATS and repeats * stage.dt * hypot(*v) > UNSEEN:
            return self._braked(None, f"the same sample has come {repeats + 1} times while the arm moves")
        elif dist(x_d, x_before) > limits.jump and self._jumps(target, dist(x_d, x_before), stage.dt):
            reason = f"the target jumps by {dist(x_d, x_before):.3g} m in one sample"
        elif dist(x_d, x) > limits.tracking:
            reason = self._monitor.not_tracked(state, target)
        if countdown < 0 and not reason:
            watch, reason = self._monitor.look(watch or Watch(), state, target, stage.dt)
            countdown = self._monitor.samples(stage.dt) - 1
        if reason:
            return self._braked(state, reason)
        try:
            tau = self.law.torque_at(state, target)
        except Exception as error:
            return self._braked(state, f"the law {self.law.name!r} raised {type(error).__name__}: {error}")
        given = tau.tolist()
        covered = near and certificate.covers(v, given)  # type: ignore[union-attr]
        if not covered or limits.on_every_sample:
            tau, held = limits.within(tau, given, tau_before, stage.steps, state)
            if not covered or held:
                given = tau.tolist()
                reason, certificate = self._viability.plan(state, tau, stage.dt)
                if reason:
                    return self._braked(state, reason)
            if held and stage.status.state == RUNNING:
                stage = self._told(stage, GuardStatus(LIMITING, held))
        memory = (stage, state, given, q, v, x_d, certificate, watch, countdown, repeats)
        _set(self, "memory", _memory(GuardMemory, memory))
        return tau

    def _braked(self, state: ArmState | None, reason: str) -> Array:
        """Return the braking torque, shape (nv,), N m, and from now on nothing else until `reset`.

        Args:
            state: The arm's state; None if it could not be measured.
            reason: Why, where the arm is not being braked yet.
        """
        if self.memory is None:
            state = self.arm.state(self._neutral, self._rest) if state is None else state
            self.memory, reason = self._begun(state.q, ASSUMED_DT), NOT_RESET
        memory, stage = self.memory, self.memory.stage
        state, q, v, agreeing = self._belief.believed(state, memory)
        if not stage.braking:
            stage = self._told(stage, GuardStatus(STOPPING, reason))
        elif stage.held is None and np.abs(state.v).max() <= STILL:
            stage = self._told(stage._replace(held=state.q), GuardStatus(STOPPED, stage.status.reason))
        tau = self._brake.torque(state, memory.tau, stage.dt, stage.held)
        self.memory = GuardMemory(stage, state, tau.tolist(), q, v, memory.desired, agreeing=agreeing)
        return tau

    def _begun(self, q: Array, dt: float) -> GuardMemory:
        """Return the memory at the start of a motion: the arm is held against gravity."""
        gravity = self.arm.state(q, self._rest).nle
        tau = np.clip(gravity, -self.limits.torque, self.limits.torque).tolist()
        stage = Stage(GuardStatus(RUNNING), dt, self.limits.steps(dt), q)
        return GuardMemory(stage, None, tau, q.tolist(), self._rest.tolist(), [])

    def _told(self, stage: Stage, status: GuardStatus) -> Stage:
        """Return a stage with a new status, after telling who wants to know."""
        if self.on_change is not None:
            try:
                self.on_change(status)
            except Exception as error:
                status = GuardStatus(status.state, f"{status.reason}; on_change raised {type(error).__name__}: {error}")
        return stage._replace(status=status, braking=status.state in (STOPPING, STOPPED))

    def _jumps(self, target: Target, way: float, dt: float) -> bool:
        """Return whether a target has moved farther than it announces."""
        return way > self.limits.jump + dt * hypot(*target.dx.tolist())

    def _positions(self, pose: TaskValue) -> list[float]:
        return [pose.translation.item(axis) for axis in self._axes or ()]
