"""The inertia-weighted law: least joint acceleration in the norm of the inertia matrix."""

from __future__ import annotations

from ..redundancy import Array, inertia_weighted_torque
from ..redundancy.feedback import task_space_law
from .compiled_law import CompiledLaw


@task_space_law()
def _torque(M: Array, nle: Array, J: Array, b: Array, v: Array) -> Array:
    return inertia_weighted_torque(M, nle, J, b)


class InertiaWeighted(CompiledLaw):
    """τ = Jᵀ(J M⁻¹Jᵀ)⁻¹b + N: the task acceleration at the least θ̈ᵀMθ̈.

    The inertia-weighted pseudoinverse of J. M. Hollerbach and K. C. Suh, "Redundancy resolution of manipulators through
    torque optimization" (1987), reference [15] of the paper. In torques: least (τ − N)ᵀM⁻¹(τ − N), where Eq. (8) has
    the plain norm of τ.
    """

    name = "inertia-weighted"
    compiled_text = (_torque,)
