"""J-minor based dynamic control: stay inside the aspect by the choice of joint velocity."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm
from .criteria import MinorMeasure
from .resolved_motion import ResolvedMotion


class JMinorDynamicControl(ResolvedMotion):
    """JMDC, Eqs. (17)–(21): resolved motion with the minor measure of Eq. (18) as its criterion.

    See `ResolvedMotion` for the equations and `MinorMeasure` for a start on the border of an aspect.
    """

    name = "jmdc"

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0, kappa: float = 0.001) -> None:
        """Set the arm, the joint-space gains and the weight of the minor measure.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            kp: Position gain K_p, 1/s²: a scalar, a vector of n entries or an (n, n) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of n entries or an (n, n) matrix.
            kappa: κ, rad² per s and unit of H; 0 leaves the minor measure out.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain or κ is negative.
            TooManyMinorsError: If κ is not zero and the Jacobian has more minors than can be handled.
        """
        super().__init__(arm, kp=kp, kv=kv, kappa=kappa, criterion=MinorMeasure.name)

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {name: value for name, value in super().parameters.items() if name != "criterion"}
