"""The null space vector method: least torque at every instant."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, minimum_torque
from ..trajectories import Target
from .controller import TaskSpaceController


class NullSpaceVector(TaskSpaceController):
    """τ = τ̃ − M[M(I − J⁺J)]⁺τ̃, Eq. (11): the locally minimum torque.

    The method of J. M. Hollerbach and K. C. Suh, "Redundancy resolution of manipulators through torque optimization"
    (1987), reference [15] of the paper. It feeds the self-motion and its torques explode on long motions: not safe to
    run on a real arm by itself.
    """

    name = "null-space-vector"

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        return minimum_torque(state.M, state.nle, state.J, b)
