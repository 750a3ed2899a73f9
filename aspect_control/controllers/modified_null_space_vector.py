"""The modified null space vector method: least torque, but only while that brakes the self-motion."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import known_name
from ..exceptions import NotResetError
from ..redundancy import Array, brake_torque, dead_beat_torque, switched_torque
from ..trajectories import Target
from .controller import TaskSpaceController

SWITCHINGS = ("hard", "dead-beat", "brake")
"""How the null-space term may be switched."""


class ModifiedNullSpaceVector(TaskSpaceController):
    """The null-space term switched by Maciejewski's condition, Eqs. (12)–(16) and Fig. 1.

    τ = τ̃                            if θ̇_H·θ̈_H ≥ 0, Eq. (13)
    τ = τ̃ − M[M(I − J⁺J)]⁺τ̃         if θ̇_H·θ̈_H < 0, Eq. (14)

    With `switching="hard"`, as printed, the law chatters once it has brought the self-motion to rest: θ̇_H then sits at
    zero and the sign of θ̇_H·θ̈_H changes at almost every sample. With `switching="dead-beat"` the null-space term of
    Eq. (14) is scaled by min(1, ‖θ̇_H‖² / (−θ̇_H·θ̈_H Δt)), so that, with one redundant degree of freedom, one sample
    brakes the self-motion to rest at most and never reverses it. With several of them most of θ̈_H may point across θ̇_H,
    where that scale does not bound it and it starts another self-motion; `switching="brake"` leaves that part out and
    applies only max(θ̇_H·θ̈_H / ‖θ̇_H‖², −1/Δt) θ̇_H. For one redundant degree of freedom the two are the same.

    Attributes:
        switching: `"hard"`, `"dead-beat"` or `"brake"`.
    """

    name = "modified-null-space-vector"
    switches = True

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0, switching: str = "hard") -> None:
        """Set the arm, the task-space gains and the kind of switching.

        Args:
            arm: The arm; its task must leave a redundant degree of freedom.
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
        self.switching = known_name(switching, SWITCHINGS, "switching")

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "switching": self.switching}

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Keep the sampling time, s, as the memory."""
        self.memory = dt

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        if self.switching == "hard":
            return switched_torque(state.M, state.nle, state.J, b, state.v)
        if self.memory is None:
            raise NotResetError(
                f"{self.switching} switching needs the sampling time: call reset(q, v, dt) before the first torque"
            )
        torque = dead_beat_torque if self.switching == "dead-beat" else brake_torque
        return torque(state.M, state.nle, state.J, b, state.v, self.memory)
