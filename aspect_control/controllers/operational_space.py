"""Operational-space control with damping in the dynamically consistent null space."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import non_negative
from ..redundancy import Array, dynamically_consistent_null_torque, inertia_weighted_torque
from ..trajectories import Target
from .base import TaskSpaceController


class OperationalSpace(TaskSpaceController):
    """τ = JᵀΛb + N + (I − JᵀJ̄ᵀ)τ₀ with Λ = (J M⁻¹Jᵀ)⁻¹, J̄ = M⁻¹JᵀΛ and τ₀ = −D M θ̇.

    O. Khatib, "A unified approach for motion and force control of robot manipulators: the operational space
    formulation", IEEE Journal on Robotics and Automation 3 (1987). The null-space torque is dynamically consistent: it
    brings about no task acceleration.

    Attributes:
        damping: D, 1/s.
    """

    name = "operational-space"

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0, damping: float = 10.0) -> None:
        """Set the arm, the task-space gains and the damping.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.
            damping: D, 1/s, at least 0.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain or the damping is negative.
        """
        super().__init__(arm, kp=kp, kv=kv)
        self.damping = non_negative("damping", damping, "1/s")

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "damping": self.damping}

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        M, nle, J = state.M, state.nle, state.J
        b = self.commanded_acceleration(state, target)
        damping_torque = -self.damping * M @ state.v
        tau: Array = inertia_weighted_torque(M, nle, J, b) + dynamically_consistent_null_torque(M, J, damping_torque)
        return tau
