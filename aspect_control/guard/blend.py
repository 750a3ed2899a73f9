"""From one law to another in the middle of a motion, without a step in the torque."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..arm import ArmState
from ..checks import non_negative, positive
from ..controllers import Controller
from ..exceptions import NotResetError, ParameterError, shown
from ..redundancy import Array
from ..trajectories import PROFILES, Target

_SAME_SAMPLE = 1e-9
"""A time that is this part of Δt after a sample is that of the sample: i·Δt is rarely exact."""


class BlendMemory(NamedTuple):
    """What a blend carries from one sample to the next.

    Attributes:
        dt: Δt, s.
        sample: How many samples there have been since `reset`.
        to_second: Whether it goes, or has gone, over to the second law.
        step: How many samples of the way have been gone, from 0 at the first law to all at the second.
        laws: What the two laws remember.
    """

    dt: float
    sample: int
    to_second: bool
    step: int
    laws: tuple[Any, Any]


class Blend(Controller):
    """Two laws, and a smooth way from one to the other and back.

    τ = (1 − s) τ₁ + s τ₂ with s = 10u³ − 15u⁴ + 6u⁵, where u grows from 0 to 1 in the time `duration` once `switch` is
    called, or at the time `switch_at`. Before and after, one of the two laws alone is computed and the torque is its
    own. The law that comes in is reset at the present state. A second call of `switch` leads back, also half-way.

    The torque makes no step: to what the laws do by themselves a sample adds at most 1.875 |τ₂ − τ₁| Δt / `duration`.
    The task is kept: the task acceleration J M⁻¹(τ − N) + J̇θ̇ is linear in τ, so that two laws that both give the
    commanded one give it at every s. Of laws that do not, because their gains differ or because they track joint
    motions as JMDC does, it is (1 − s) times the one plus s times the other.

    The two laws belong to the blend, which sets what they remember.

    Attributes:
        first: The law that begins.
        second: The law that it goes over to.
        duration: How long the way takes, s.
        switch_at: When it sets off by itself, s; None if it waits for `switch`.
        kp: K_p of the law with the larger K_v.
        kv: K_v of that law.
        memory: Where it is on the way, and what the two laws remember, a `BlendMemory`.
    """

    name = "blend"
    memory: BlendMemory | None = None

    def __init__(
        self, first: Controller, second: Controller, *, duration: float = 0.2, switch_at: float | None = None
    ) -> None:
        """Set the laws and the way from one to the other.

        Args:
            first: The law that begins.
            second: The law that it goes over to, of the same arm.
            duration: How long the way takes, s.
            switch_at: When it sets off by itself, s from `reset` on; None to wait for `switch`.

        Raises:
            ParameterError: If one of them is no law, they are of two arms, `duration` is not above zero or `switch_at`
                below zero.
        """
        for name, law in (("first", first), ("second", second)):
            if not isinstance(law, Controller):
                raise ParameterError(f"{name} must be a Controller, got {shown(law)}")
        if second.arm is not first.arm and second.arm.description != first.arm.description:
            raise ParameterError(f"both laws must be of one arm, got {first.arm!r} and {second.arm!r}")
        stiffer = max(first, second, key=lambda law: float(np.linalg.norm(law.kv, 2)))
        super().__init__(first.arm, len(stiffer.kv), stiffer.kp, stiffer.kv)
        self.first, self.second = first, second
        self.duration = positive("duration", duration, "s")
        self.switch_at = None if switch_at is None else non_negative("switch_at", switch_at, "s")
        self.switches = first.switches or second.switches  # type: ignore[misc]

    @property
    def parameters(self) -> dict[str, Any]:
        """Names and parameters of the two laws, and the times; see `Controller.parameters`."""
        first, second = ({"name": law.name, **law.parameters} for law in (self.first, self.second))
        return {"first": first, "second": second, "duration": self.duration, "switch_at": self.switch_at}

    @property
    def share(self) -> float:
        """The second law's share s of the last torque: 0 for the first law alone, 1 for the second."""
        return 0.0 if self.memory is None else self._share(self.memory)

    def switch(self) -> None:
        """Set off for the other law with the next torque.

        Raises:
            NotResetError: If `reset` was not called.
        """
        memory = self._memory()
        self.memory = memory._replace(to_second=not memory.to_second)

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Begin with the first law."""
        self.memory = BlendMemory(dt, 0, False, 0, (_begun(self.first, q, v, dt), None))

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and go on."""
        memory = self._memory()
        dt, sample, to_second, before, _ = memory
        if self.switch_at is not None and sample == math.ceil(self.switch_at / dt - _SAME_SAMPLE):
            to_second = True
        steps = self._steps(dt)
        step = min(before + 1, steps) if to_second else max(before - 1, 0)
        memory = memory._replace(sample=sample + 1, to_second=to_second, step=step)
        s = self._share(memory)
        tau, remembered = np.zeros(self.arm.nv), list(memory.laws)
        for i, (law, weight, idle) in enumerate(((self.first, 1.0 - s, steps), (self.second, s, 0))):
            if weight == 0.0:
                continue
            law.memory = _begun(law, state.q, state.v, dt) if before == idle else remembered[i]
            tau += weight * self._checked(law.command(state, target), state)
            remembered[i] = law.memory
        self.memory = memory._replace(laws=(remembered[0], remembered[1]))
        return tau

    def _memory(self) -> BlendMemory:
        if self.memory is None:
            raise NotResetError("a blend needs the sampling time: call reset(q, v, dt) before the first torque")
        return self.memory

    def _steps(self, dt: float) -> int:
        return max(1, math.ceil(self.duration / dt - _SAME_SAMPLE))

    def _share(self, memory: BlendMemory) -> float:
        return PROFILES["quintic"](memory.step / self._steps(memory.dt))[0]


def _begun(law: Controller, q: Array, v: Array, dt: float) -> Any:
    """Return what a law remembers at the start of a motion."""
    law.start(q, v, dt)
    return law.memory
