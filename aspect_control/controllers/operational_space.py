"""Operational-space control with damping in the dynamically consistent null space."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, operational_space_torque
from ..trajectories import Target
from .damped import DampedController


class OperationalSpace(DampedController):
    """τ = JᵀΛb + N + (I − JᵀJ̄ᵀ)τ₀ with Λ = (J M⁻¹Jᵀ)⁻¹, J̄ = M⁻¹JᵀΛ and τ₀ = −D M θ̇.

    O. Khatib, "A unified approach for motion and force control of robot manipulators: the operational space
    formulation", IEEE Journal on Robotics and Automation 3 (1987). The null-space torque is dynamically consistent: it
    brings about no task acceleration.

    Attributes:
        damping: D, 1/s.
    """

    name = "operational-space"

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        tau_0 = -self.damping * (state.M @ state.v)
        return operational_space_torque(state.M, state.nle, state.J, b, tau_0)
