"""The inertia-weighted law: least joint acceleration in the norm of the inertia matrix."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, inertia_weighted_torque
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
    return require_finite(inertia_weighted_torque(M, nle, J, b))


class InertiaWeighted(TaskSpaceController):
    """τ = Jᵀ(J M⁻¹Jᵀ)⁻¹b + N: the task acceleration at the least θ̈ᵀMθ̈.

    The inertia-weighted pseudoinverse of J. M. Hollerbach and K. C. Suh, "Redundancy resolution of manipulators through
    torque optimization" (1987), reference [15] of the paper. In torques: least (τ − N)ᵀM⁻¹(τ − N), where Eq. (8) has
    the plain norm of τ.
    """

    name = "inertia-weighted"
    is_compiled = True
    compiled_text = (_torque,)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        tau: Array = self._texts[0](*self.terms(state, target))
        return tau
