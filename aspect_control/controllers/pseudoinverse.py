"""The pseudoinverse law: least joint acceleration."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, pseudoinverse_torque
from ..redundancy.feedback import task_space_law
from ..trajectories import Target
from .base import TaskSpaceController


@task_space_law()
def _torque(M: Array, nle: Array, J: Array, b: Array, v: Array) -> Array:
    return pseudoinverse_torque(M, nle, J, b)


class Pseudoinverse(TaskSpaceController):
    """τ̃ = M J⁺(ẍ_d + K_v ė + K_p e − J̇θ̇) + N, Eq. (7): the minimum-norm joint acceleration."""

    name = "pseudoinverse"
    is_compiled = True
    compiled_text = (_torque,)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ̃, shape (nv,), N m."""
        tau: Array = self._texts[0](*self.terms(state, target))
        return tau
