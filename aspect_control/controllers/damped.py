"""What the laws that damp the self-motion have in common."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import non_negative
from .controller import TaskSpaceController


class DampedController(TaskSpaceController):
    """A task-space law with a rate at which the self-motion is damped.

    Attributes:
        damping: D, 1/s.
    """

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0, damping: float = 10.0) -> None:
        """Set the arm, the task-space gains and the damping.

        Args:
            arm: The arm; its task must leave a redundant degree of freedom.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.
            damping: D, 1/s, at least 0.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain or the damping is negative.
        """
        super().__init__(arm, kp=kp, kv=kv)
        self.damping = non_negative("damping", damping, "1/s")

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "damping": self.damping}
