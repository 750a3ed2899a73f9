"""The inertia-weighted law: least joint acceleration in the norm of the inertia matrix."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, inertia_weighted_torque
from ..trajectories import Target
from .controller import TaskSpaceController


class InertiaWeighted(TaskSpaceController):
    """τ = Jᵀ(J M⁻¹Jᵀ)⁻¹b + N: the task acceleration at the least θ̈ᵀMθ̈.

    The inertia-weighted pseudoinverse of J. M. Hollerbach and K. C. Suh, "Redundancy resolution of manipulators through
    torque optimization" (1987), reference [15] of the paper. In torques: least (τ − N)ᵀM⁻¹(τ − N), where Eq. (8) has
    the plain norm of τ. Nothing damps the self-motion, which can build up until the torques explode: not safe to run
    on a real arm by itself.
    """

    name = "inertia-weighted"

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        return inertia_weighted_torque(state.M, state.nle, state.J, b)
