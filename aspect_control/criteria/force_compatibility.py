"""The compatibility index for forces along a direction."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import BORDER_TOLERANCE, Arm, ArmState
from ..exceptions import UndefinedCriterionError
from ..redundancy import Array, force_compatibility, force_compatibility_gradient
from .criterion import Criterion
from .direction import task_direction


class ForceCompatibility(Criterion):
    """H = [uᵀ(JJᵀ)u]⁻¹: the square of the force transmission ratio along u.

    It grows without bound towards a pose in which the structure alone holds a force along u, which is a singular one: a
    law that climbs it gives up the velocities along u.

    S. L. Chiu, "Task compatibility of manipulator postures", International Journal of Robotics Research 7 (1988).

    Attributes:
        direction: Unit vector u, shape (m,), fixed in task coordinates.
    """

    name = "force-compatibility"

    def __init__(self, arm: Arm, direction: ArrayLike) -> None:
        """Set the arm and the direction.

        Args:
            arm: The arm.
            direction: Where the force acts, components along the task coordinates, shape (m,); of any length but zero.

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

    def start(self, q: Array) -> None:
        """Make sure that H is finite at q, shape (nq,), rad.

        Raises:
            UndefinedCriterionError: If a force along u needs no torque there.
        """
        J = self.arm.jacobian(q)
        if np.linalg.norm(self.direction @ J) <= BORDER_TOLERANCE * np.linalg.norm(J):
            raise UndefinedCriterionError(
                f"{self.name!r} is infinite at the start: at this singular pose a force along {self._given.tolist()} "
                "needs no torque; start elsewhere or take another direction"
            )

    def value(self, state: ArmState) -> float:
        """Return H, m⁻² for positions and revolute joints; infinite where a force along u needs no torque."""
        return float(force_compatibility(state.J, self.direction))

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), in the unit of H per rad; zero where H is infinite."""
        return force_compatibility_gradient(state.J, self.arm.jacobian_derivative(state.q), self.direction)
