"""The null space vector method: least torque at every instant."""

from __future__ import annotations

from ..redundancy import Array, minimum_torque
from ..redundancy.feedback import task_space_law
from .compiled_law import CompiledLaw


@task_space_law()
def _torque(M: Array, nle: Array, J: Array, b: Array, v: Array) -> Array:
    return minimum_torque(M, nle, J, b)


class NullSpaceVector(CompiledLaw):
    """τ = τ̃ − M[M(I − J⁺J)]⁺τ̃, Eq. (11): the locally minimum torque.

    The method of J. M. Hollerbach and K. C. Suh, "Redundancy resolution of manipulators through torque optimization"
    (1987), reference [15] of the paper. It feeds the self-motion and its torques explode on long motions.
    """

    name = "null-space-vector"
    compiled_text = (_torque,)
