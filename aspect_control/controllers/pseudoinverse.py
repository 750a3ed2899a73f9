"""The pseudoinverse law: least joint acceleration."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, pseudoinverse_torque
from ..trajectories import Target
from .controller import TaskSpaceController


class Pseudoinverse(TaskSpaceController):
    """τ̃ = M J⁺(ẍ_d + K_v ė + K_p e − J̇θ̇) + N, Eq. (7): the minimum-norm joint acceleration."""

    name = "pseudoinverse"

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        return pseudoinverse_torque(state.M, state.nle, state.J, b)
