"""The pseudoinverse law with damped self-motion."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import non_negative
from ..redundancy import Array, homogeneous_velocity, pseudoinverse_torque
from ..trajectories import Target
from .base import TaskSpaceController


class DampedNullSpace(TaskSpaceController):
    """τ = τ̃ − D M θ̇_H: Eq. (7), and the self-motion of Eq. (15) decays at the rate D.

    Null-space damping as in P. Hsu, J. Hauser and S. Sastry, "Dynamic control of redundant manipulators", Journal of
    Robotic Systems 6 (1989), with the desired self-motion zero and without the derivative of the projector.

    Attributes:
        damping: D, 1/s.
    """

    name = "damped-null-space"

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0, damping: float = 10.0) -> None:
        """Set the arm, the task-space gains and the damping.

        Args:
            arm: The arm; its task must leave at least one joint spare.
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

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        theta_dot_H = homogeneous_velocity(state.J, state.v)
        tau: Array = pseudoinverse_torque(state.M, state.nle, state.J, b) - self.damping * state.M @ theta_dot_H
        return tau
