"""The minor measure, which keeps an arm inside its aspect."""

from __future__ import annotations

import warnings

import numpy as np

from ..arm import Arm, ArmState
from ..exceptions import AspectBorderWarning
from ..redundancy import Array, minor_measure
from ..redundancy.gradients import expanded_gradient
from ..redundancy.laplace import laplace_expansion
from .criterion import Criterion


class MinorMeasure(Criterion):
    """H = |δ₁ δ₂ … δ_p|^(1/p), Eq. (18), made of the minors that are not structurally zero.

    A start on the border of an aspect, where a minor is zero, is reported by an `AspectBorderWarning`; such minors have
    no sign to keep and are left out of H until the next `start`.

    Attributes:
        minor_columns: Columns of the minors that H is made of, shape (p, m).
    """

    name = "minor-measure"

    def __init__(self, arm: Arm) -> None:
        """Set the arm.

        Raises:
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        super().__init__(arm)
        self.minor_columns = arm.minor_columns
        self._expansion = laplace_expansion(self.minor_columns)

    def start(self, q: Array) -> None:
        """Leave out the minors that are zero at q, shape (nq,), rad, and report them."""
        on_border = self.arm.minors_on_border(q)
        if len(on_border) > 0:
            warnings.warn(
                f"the motion starts on the border of an aspect: {len(on_border)} of {len(self.arm.minor_columns)} "
                f"minors are zero and left out of the minor measure: {self.arm.minors.describe(on_border)}",
                AspectBorderWarning,
                stacklevel=4,
            )
        self.minor_columns = np.delete(self.arm.minor_columns, on_border, axis=0)
        self._expansion = laplace_expansion(self.minor_columns)

    def value(self, state: ArmState) -> float:
        """Return H, in the unit of the minors; zero on the border of the aspect, and if no minor is left."""
        return float(minor_measure(state.J, self.minor_columns)) if len(self.minor_columns) else 0.0

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), in the unit of H per rad; zero on the border."""
        return expanded_gradient(state.J, self.arm.jacobian_derivative(state.q), self._expansion)
