"""The limits of a guard, read once, and the torque cut to them."""

from __future__ import annotations

from operator import gt, sub
from typing import Any

import numpy as np

from ..arm import Arm, ArmState
from ..checks import positive, restore_read_only
from ..exceptions import ParameterError
from ..limits import NO_LIMIT, joint_limit, joint_range
from ..redundancy import Array


class GuardLimits:
    """The limits of one arm; infinite where there is none.

    Attributes:
        torque: τ_max, shape (n,), N m.
        rate: Largest |dτ/dt|, shape (n,), N m/s.
        speed: θ̇_max, shape (n,), rad/s.
        lower: θ_min, shape (n,), rad.
        upper: θ_max, shape (n,), rad.
        acceleration: θ̈_max, shape (n,), rad/s².
        tracking: Largest distance of the task frame from its target, m (rad for rotations).
        jump: Largest jump of the target in one sample beyond the motion that it announces, m.
        distance: Largest distance of the target from the first joint, m.
        on_every_sample: Whether a certificate of the viability leaves limits open: those of acceleration and rate.
        parameters: What was given, as plain numbers, strings and lists.
    """

    def __init__(
        self,
        arm: Arm,
        torque: Any,
        torque_rate: Any,
        speed: Any,
        position: Any,
        acceleration: Any,
        tracking: float | None,
        jump: float | None,
        distance: float | None,
    ) -> None:
        """Read the limits; see `Guard` for what may be given and for the errors."""
        n = arm.nv
        self.torque = joint_limit("torque", torque, n, arm.torque_limit)
        self.rate = joint_limit("torque_rate", torque_rate, n, unit="N m/s")
        self.speed = joint_limit("speed", speed, n, arm.velocity_limit, "rad/s")
        self.lower, self.upper = joint_range("position", position, n, arm.position_limits)
        self.acceleration = joint_limit("acceleration", acceleration, n, unit="rad/s²")
        self.tracking, self.jump = _distance("tracking", tracking), _distance("jump", jump)
        self.distance = arm.reach if distance is None else positive("distance", distance, "m")
        for joint, name, lower, upper in zip(
            arm.model.joints[1:], arm.joint_names, self.lower, self.upper, strict=True
        ):
            if joint.nq != joint.nv and (np.isfinite(lower) or np.isfinite(upper)):
                raise ParameterError(f"position: joint {name!r} turns without end and has no position limits")
        self._torques, self._has_acceleration = self.torque.tolist(), bool(np.isfinite(self.acceleration).any())
        self.on_every_sample = self._has_acceleration or bool(np.isfinite(self.rate).any())
        self.names = arm.joint_names
        self.parameters = {
            "torque": _plain(torque),
            "torque_rate": _plain(torque_rate),
            "speed": _plain(speed),
            "position": position if position is None or isinstance(position, str) else [*map(_plain, position)],
            "acceleration": _plain(acceleration),
            "tracking": _plain(tracking),
            "jump": _plain(jump),
            "distance": _plain(distance),
        }

    __setstate__ = restore_read_only

    def steps(self, dt: float) -> list[float]:
        """Return how far each torque may go in one sample of Δt, N m, one a joint."""
        steps: list[float] = (self.rate * dt).tolist()
        return steps

    def within(
        self, tau: Array, given: list[float], last: list[float], steps: list[float], state: ArmState
    ) -> tuple[Array, str]:
        """Return a torque cut to the limits of acceleration, rate and torque, and which of them holds, if one does.

        A joint acceleration M⁻¹(τ − N) beyond its limit is scaled back as a whole, τ = N + λ(τ − N). The rate comes
        before the acceleration, and the torque itself before both.

        Args:
            tau: Torque τ, shape (n,), N m.
            given: The same, one a joint.
            last: The torque of the sample before, within its limits, N m.
            steps: How far each torque may go from there, N m.
            state: The arm's state.
        """
        slow = not any(map(gt, map(abs, map(sub, given, last)), steps))
        if slow and not self._has_acceleration and not any(map(gt, map(abs, given), self._torques)):
            return tau, ""
        reason, cut = "", tau
        if self._has_acceleration:
            acceleration = np.linalg.solve(state.M, tau - state.nle)
            share = np.abs(acceleration) / self.acceleration
            if share.max() > 1.0:
                i = int(share.argmax())
                reason = self._told("acceleration", i, acceleration[i], self.acceleration[i], "rad/s²")
                cut = state.nle + (tau - state.nle) / share[i]
        before, step = np.array(last), np.array(steps)
        held = np.clip(cut, before - step, before + step)
        if (held != cut).any():
            i = int(np.argmax(np.abs(held - cut)))
            rate = self.rate[i]
            reason = self._told("torque rate", i, (cut[i] - before[i]) * rate / step[i], rate, "N m/s")
            cut = held
        held = np.clip(cut, -self.torque, self.torque)
        if (held != cut).any():
            i = int(np.argmax(np.abs(held - cut)))
            return held, self._told("torque", i, cut[i], self.torque[i], "N m")
        return cut, reason

    def _told(self, what: str, i: int, asked: float, limit: float, unit: str) -> str:
        return f"{what} limit of joint {self.names[i]!r}: {asked:.4g} {unit} asked, {limit:.4g} {unit} allowed"


def joint_index(arm: Arm) -> list[int] | None:
    """Return where the joint positions stand in q, None if q is nothing but them.

    For a joint without end, whose q holds a cosine and a sine, it is that of the cosine: such a joint has no limits.
    """
    if arm.nq == arm.nv:
        return None
    return [joint.idx_q for joint in arm.model.joints[1:]]


def _distance(name: str, value: float | None) -> float:
    return NO_LIMIT if value is None else positive(name, value, "m")


def _plain(given: Any) -> Any:
    return given if given is None or isinstance(given, str) else np.array(given, dtype=np.float64).tolist()
