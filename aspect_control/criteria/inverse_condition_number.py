"""The condition number of the Jacobian, to be decreased."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, inverse_condition_number, inverse_condition_number_gradient
from .criterion import JacobianCriterion


class InverseConditionNumber(JacobianCriterion):
    """H = σ_m / σ_1, one over the condition number of J: 0 at a singular pose, 1 at an isotropic one.

    J. K. Salisbury and J. J. Craig, "Articulated hands: force control and kinematic issues" (1982).
    """

    name = "inverse-condition-number"

    def value(self, state: ArmState) -> float:
        """Return H, dimensionless, between 0 and 1."""
        return float(inverse_condition_number(state.J))

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), per rad; zero where J has lost rank."""
        return inverse_condition_number_gradient(state.J, self.arm.jacobian_derivative(state.q))
