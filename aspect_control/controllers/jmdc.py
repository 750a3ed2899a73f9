"""J-minor based dynamic control: stay inside the aspect by the choice of joint velocity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from ..arm import Arm
from ..criteria import Criterion, MinorMeasure
from .resolved_motion import ResolvedMotion


class JMinorDynamicControl(ResolvedMotion):
    """JMDC, Eqs. (17)–(21): resolved motion with the minor measure of Eq. (18) as its criterion.

    See `ResolvedMotion` for the equations and `MinorMeasure` for a start on the border of an aspect. With another
    criterion it is the same law as `ResolvedMotion`, and no longer the paper's.
    """

    name = "jmdc"

    def __init__(
        self,
        arm: Arm,
        *,
        kp: ArrayLike = 100.0,
        kv: ArrayLike = 20.0,
        kappa: float = 0.001,
        criterion: str | Mapping[str, Any] | Criterion = MinorMeasure.name,
    ) -> None:
        """Set the arm, the joint-space gains and the weight of the criterion.

        Args:
            arm: The arm; its task must leave a redundant degree of freedom.
            kp: Position gain K_p, 1/s²: a scalar, a vector of n entries or an (n, n) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of n entries or an (n, n) matrix.
            kappa: κ, rad² per s and unit of H; 0 leaves the criterion out.
            criterion: H, as for `ResolvedMotion`; the minor measure unless given.

        Raises:
            AspectControlError: As `ResolvedMotion` does.
        """
        super().__init__(arm, kp=kp, kv=kv, kappa=kappa, criterion=criterion)
