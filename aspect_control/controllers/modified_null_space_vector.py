"""The modified null space vector method: least torque, but only while that brakes the self-motion."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import (
    Array,
    homogeneous_acceleration,
    homogeneous_velocity,
    minimum_torque,
    pseudoinverse_torque,
)
from ..trajectories import Target
from .base import TaskSpaceController


class ModifiedNullSpaceVector(TaskSpaceController):
    """The null-space term switched by Maciejewski's condition, Eqs. (12)–(16) and Fig. 1.

    τ = τ̃                            if θ̇_H·θ̈_H ≥ 0, Eq. (13)
    τ = τ̃ − M[M(I − J⁺J)]⁺τ̃         if θ̇_H·θ̈_H < 0, Eq. (14)

    As printed, the law chatters once it has brought the self-motion to rest: θ̇_H then sits at zero and the sign of
    θ̇_H·θ̈_H changes at almost every sample.
    """

    name = "modified-null-space-vector"
    switches = True

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        M, nle, J = state.M, state.nle, state.J
        b = self.commanded_acceleration(state, target)
        tau_tilde = pseudoinverse_torque(M, nle, J, b)
        tau_minimum = minimum_torque(M, nle, J, b)
        theta_dot_H = homogeneous_velocity(J, state.v)
        theta_ddot_H = homogeneous_acceleration(M, tau_minimum, tau_tilde)
        return tau_tilde if theta_dot_H @ theta_ddot_H >= 0.0 else tau_minimum
