"""The null space vector method: least torque at every instant."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, minimum_torque
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
    return require_finite(minimum_torque(M, nle, J, b))


class NullSpaceVector(TaskSpaceController):
    """τ = τ̃ − M[M(I − J⁺J)]⁺τ̃, Eq. (11): the locally minimum torque.

    The method of J. M. Hollerbach and K. C. Suh, "Redundancy resolution of manipulators through torque optimization"
    (1987), reference [15] of the paper. It feeds the self-motion and its torques explode on long motions.
    """

    name = "null-space-vector"
    is_compiled = True
    compiled_text = (_torque,)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        tau: Array = self._texts[0](*self.terms(state, target))
        return tau
