"""The pseudoinverse law: least joint acceleration."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, pseudoinverse_torque
from ..redundancy.compiled import compiled
from ..redundancy.feedback import TASK_SPACE, commanded_acceleration, require_finite
from ..trajectories import Target
from .base import TaskSpaceController


@compiled(*TASK_SPACE)
def _torque(
    M: Array,
    nle: Array,
    J: Array,
    drift: Array,
    x: Array,
    q: Array,
    v: Array,
    x_d: Array,
    dx_d: Array,
    ddx_d: Array,
    kp: Array,
    kv: Array,
) -> Array:
    b = commanded_acceleration(J, drift, x, q, v, x_d, dx_d, ddx_d, kp, kv)
    return require_finite(pseudoinverse_torque(M, nle, J, b))


class Pseudoinverse(TaskSpaceController):
    """τ̃ = M J⁺(ẍ_d + K_v ė + K_p e − J̇θ̇) + N, Eq. (7): the minimum-norm joint acceleration."""

    name = "pseudoinverse"
    is_compiled = True
    compiled_text = (_torque,)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ̃, shape (nv,), N m."""
        tau: Array = self._texts[0](*self.terms(state, target))
        return tau
