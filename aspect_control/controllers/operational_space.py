"""Operational-space control with damping in the dynamically consistent null space."""

from __future__ import annotations

from ..redundancy import Array, operational_space_torque
from ..redundancy.compiled import NUMBER
from ..redundancy.feedback import task_space_law
from ..redundancy.products import times
from .damped import DampedController


@task_space_law(NUMBER)
def _torque(M: Array, nle: Array, J: Array, b: Array, v: Array, damping: float) -> Array:
    return operational_space_torque(M, nle, J, b, -damping * times(M, v))


class OperationalSpace(DampedController):
    """τ = JᵀΛb + N + (I − JᵀJ̄ᵀ)τ₀ with Λ = (J M⁻¹Jᵀ)⁻¹, J̄ = M⁻¹JᵀΛ and τ₀ = −D M θ̇.

    O. Khatib, "A unified approach for motion and force control of robot manipulators: the operational space
    formulation", IEEE Journal on Robotics and Automation 3 (1987). The null-space torque is dynamically consistent: it
    brings about no task acceleration.

    Attributes:
        damping: D, 1/s.
    """

    name = "operational-space"
    compiled_text = (_torque,)
