"""Joint range availability: stay away from the joint limits."""

from __future__ import annotations

import numpy as np

from ..arm import Arm, ArmState
from ..exceptions import ParameterError
from ..redundancy import Array, joint_range_availability, joint_range_availability_gradient
from .criterion import Criterion


class JointRange(Criterion):
    """H = −(1/n) Σ ((θ_i − θ̄_i) / Δθ_i)², the joint range availability of A. Liégeois with the sign reversed.

    θ̄_i is the middle of a joint's range, Δθ_i half its width; the sum goes over the n joints with both a lower and an
    upper limit. A joint without, such as a continuous one, contributes nothing.

    A. Liégeois, "Automatic supervisory control of the configuration and behavior of multibody mechanisms", IEEE
    Transactions on Systems, Man, and Cybernetics 7 (1977).
    """

    name = "joint-range"

    def __init__(self, arm: Arm) -> None:
        """Set the arm.

        Raises:
            ParameterError: If no joint of it has both a lower and an upper limit.
        """
        super().__init__(arm)
        lower, upper = arm.position_limits
        self._limited = np.flatnonzero(np.isfinite(lower) & np.isfinite(upper))
        if len(self._limited) == 0:
            raise ParameterError(
                f"{self.name!r} needs joints with limits: none of {', '.join(map(repr, arm.joint_names))} of "
                f"{arm.name!r} has both a lower and an upper one"
            )
        self._lower, self._upper = lower[self._limited], upper[self._limited]
        # A joint with limits has one coordinate in q, its position.
        self._coordinates = np.array([arm.model.joints[int(joint) + 1].idx_q for joint in self._limited])

    def value(self, state: ArmState) -> float:
        """Return H, dimensionless: 0 with all joints in the middle, −1 with all at a limit."""
        return float(joint_range_availability(state.q[self._coordinates], self._lower, self._upper))

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), per rad; zero for joints without limits."""
        gradient = np.zeros(self.arm.nv)
        gradient[self._limited] = joint_range_availability_gradient(
            state.q[self._coordinates], self._lower, self._upper
        )
        return gradient
