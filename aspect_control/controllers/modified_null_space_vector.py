"""The modified null space vector method: least torque, but only while that brakes the self-motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..exceptions import NotResetError, UnknownNameError
from ..redundancy import Array, brake_torque, dead_beat_torque, switched_torque
from ..redundancy.compiled import NUMBER, prepared
from ..redundancy.feedback import task_space_law
from .compiled_law import CompiledLaw


@task_space_law()
def _switched(M: Array, nle: Array, J: Array, b: Array, v: Array) -> Array:
    return switched_torque(M, nle, J, b, v, np.inf)


@task_space_law(NUMBER)
def _dead_beat(M: Array, nle: Array, J: Array, b: Array, v: Array, dt: float) -> Array:
    return dead_beat_torque(M, nle, J, b, v, dt)


@task_space_law(NUMBER)
def _brake(M: Array, nle: Array, J: Array, b: Array, v: Array, dt: float) -> Array:
    return brake_torque(M, nle, J, b, v, dt)


SWITCHINGS: dict[str, Callable[..., Any]] = {"hard": _switched, "dead-beat": _dead_beat, "brake": _brake}
"""How the null-space term may be switched."""


class ModifiedNullSpaceVector(CompiledLaw):
    """The null-space term switched by Maciejewski's condition, Eqs. (12)–(16) and Fig. 1.

    τ = τ̃                            if θ̇_H·θ̈_H ≥ 0, Eq. (13)
    τ = τ̃ − M[M(I − J⁺J)]⁺τ̃         if θ̇_H·θ̈_H < 0, Eq. (14)

    With `switching="hard"`, as printed, the law chatters once it has brought the self-motion to rest: θ̇_H then sits at
    zero and the sign of θ̇_H·θ̈_H changes at almost every sample. With `switching="dead-beat"` the null-space term of
    Eq. (14) is scaled by min(1, ‖θ̇_H‖² / (−θ̇_H·θ̈_H Δt)), so that, with one joint to spare, one sample brakes the
    self-motion to rest at most and never reverses it. With several joints to spare most of θ̈_H may point across θ̇_H,
    where that scale does not bound it and it starts another self-motion; `switching="brake"` leaves that part out and
    applies only max(θ̇_H·θ̈_H / ‖θ̇_H‖², −1/Δt) θ̇_H. For one joint to spare the two are the same.

    Attributes:
        switching: `"hard"`, `"dead-beat"` or `"brake"`.
    """

    name = "modified-null-space-vector"
    switches = True

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0, switching: str = "hard") -> None:
        """Set the arm, the task-space gains and the kind of switching.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.
            switching: `"hard"`, the paper's, or `"dead-beat"` or `"brake"`, which need `reset` before the first torque.

        Raises:
            UnknownNameError: If there is no such switching.
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain is negative.
        """
        super().__init__(arm, kp=kp, kv=kv)
        if switching not in SWITCHINGS:
            raise UnknownNameError(switching, SWITCHINGS, kind="switching")
        self.switching = switching
        # The law as printed does not use the sampling time.
        self._law = prepared(SWITCHINGS[switching]) if switching == "hard" else self._refuse

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "switching": self.switching}

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Keep the sampling time."""
        if self.switching != "hard":
            self._law, self._parameter = prepared(SWITCHINGS[self.switching]), dt

    def _refuse(self, *_: object) -> None:
        raise NotResetError(
            f"{self.switching} switching needs the sampling time: call reset(q, v, dt) before the first torque"
        )
