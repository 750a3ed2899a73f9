"""The pseudoinverse law with damped self-motion."""

from __future__ import annotations

from ..arm import ArmState
from ..redundancy import Array, damped_torque
from ..trajectories import Target
from .damped import DampedController


class DampedNullSpace(DampedController):
    """τ = τ̃ − D M θ̇_H: Eq. (7), and the self-motion of Eq. (15) decays at the rate D.

    Null-space damping as in P. Hsu, J. Hauser and S. Sastry, "Dynamic control of redundant manipulators", Journal of
    Robotic Systems 6 (1989), with the desired self-motion zero and without the derivative of the projector.

    Attributes:
        damping: D, 1/s.
    """

    name = "damped-null-space"

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        b = self.commanded_acceleration(state, target)
        return damped_torque(state.M, state.nle, state.J, b, state.v, self.damping)
