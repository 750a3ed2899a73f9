"""The compatibility index for motion along a direction."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..redundancy import Array, velocity_compatibility, velocity_compatibility_gradient
from .criterion import JacobianCriterion
from .direction import task_direction


class VelocityCompatibility(JacobianCriterion):
    """H = [uᵀ(JJᵀ)⁻¹u]⁻¹: the square of the velocity transmission ratio along u.

    S. L. Chiu, "Task compatibility of manipulator postures", International Journal of Robotics Research 7 (1988).

    Attributes:
        direction: Unit vector u, shape (m,), fixed in task coordinates.
    """

    name = "velocity-compatibility"

    def __init__(self, arm: Arm, direction: ArrayLike) -> None:
        """Set the arm and the direction.

        Args:
            arm: The arm.
            direction: Where the motion goes, components along the task coordinates, shape (m,); of any length but zero.

        Raises:
            ShapeError: If there is not one component a task coordinate.
            NonFiniteError: If one is not finite.
            ParameterError: If all are zero.
        """
        super().__init__(arm)
        self._given, self.direction = task_direction(arm, direction)

    @property
    def parameters(self) -> dict[str, Any]:
        """The direction as it was given; see `Criterion.parameters`."""
        return {"direction": self._given.tolist()}

    def value(self, state: ArmState) -> float:
        """Return H, m² for positions and revolute joints; zero where the arm cannot move along u."""
        return float(velocity_compatibility(state.J, self.direction))

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), in the unit of H per rad; zero where the arm cannot move along u."""
        return velocity_compatibility_gradient(state.J, self.arm.jacobian_derivative(state.q), self.direction)
