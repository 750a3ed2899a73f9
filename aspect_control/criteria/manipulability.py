"""The manipulability measure."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, manipulability, manipulability_gradient
from .criterion import JacobianCriterion


class Manipulability(JacobianCriterion):
    """H = w = √det(J Jᵀ), Eq. (25): the distance from singular poses.

    T. Yoshikawa, "Manipulability of robotic mechanisms" (1985).
    """

    name = "manipulability"

    def value(self, state: ArmState) -> float:
        """Return w, in the unit of the minors."""
        return float(manipulability(state.J))

    def gradient(self, state: ArmState) -> Array:
        """Return ∇w, shape (nv,), in the unit of w per rad; zero where J has lost rank."""
        return manipulability_gradient(state.J, self.arm.jacobian_derivative(state.q))
