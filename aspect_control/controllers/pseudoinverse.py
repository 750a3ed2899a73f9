"""The pseudoinverse law: least joint acceleration."""

from __future__ import annotations

from ..redundancy import Array, pseudoinverse_torque
from ..redundancy.feedback import task_space_law
from .compiled_law import CompiledLaw


@task_space_law()
def _torque(M: Array, nle: Array, J: Array, b: Array, v: Array) -> Array:
    return pseudoinverse_torque(M, nle, J, b)


class Pseudoinverse(CompiledLaw):
    """τ̃ = M J⁺(ẍ_d + K_v ė + K_p e − J̇θ̇) + N, Eq. (7): the minimum-norm joint acceleration."""

    name = "pseudoinverse"
    compiled_text = (_torque,)
