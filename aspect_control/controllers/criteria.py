"""Performance functions H(q) that resolved motion climbs, by name."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from ..arm import Arm, ArmState
from ..exceptions import AspectBorderWarning
from ..redundancy import Array, manipulability_gradient
from ..redundancy.compiled import prepared
from ..redundancy.gradients import expanded_gradient, laplace_expansion


class Criterion(ABC):
    """A function of the configuration that a law increases by self-motion.

    Attributes:
        name: Name under which a law finds it.
    """

    name: ClassVar[str]

    def __init__(self, arm: Arm) -> None:
        """Set the arm."""
        self.arm = arm

    def start(self, q: Array) -> None:  # noqa: B027
        """Prepare for a motion that starts at q, shape (nq,), rad; nothing to do for most criteria."""

    @abstractmethod
    def gradient(self, state: ArmState) -> Array:
        """Return ∇H at a state, shape (nv,), per rad."""


class Manipulability(Criterion):
    """w of Eq. (25)."""

    name = "manipulability"

    def __init__(self, arm: Arm) -> None:
        """Set the arm."""
        super().__init__(arm)
        prepared(manipulability_gradient)

    def gradient(self, state: ArmState) -> Array:
        """Return ∇w, shape (nv,), in the unit of w per rad."""
        return manipulability_gradient(state.J, self.arm.jacobian_derivative_at(state))


class MinorMeasure(Criterion):
    """H of Eq. (18), made of the minors that are not structurally zero.

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
        self._gradient = prepared(expanded_gradient)
        self.minor_columns = arm.minor_columns
        self._terms = laplace_expansion(self.minor_columns)

    def start(self, q: Array) -> None:
        """Leave out the minors that are zero at q, shape (nq,), rad, and report them."""
        on_border = self.arm.minors_on_border(q)
        self.minor_columns = np.delete(self.arm.minor_columns, on_border, axis=0)
        self._terms = laplace_expansion(self.minor_columns)
        if len(on_border) > 0:
            warnings.warn(
                f"the motion starts on the border of an aspect: {len(on_border)} of {len(self.arm.minor_columns)} "
                f"minors are zero and left out of the minor measure: {self.arm.describe_minors(on_border)}",
                AspectBorderWarning,
                stacklevel=4,
            )

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), in the unit of H per rad."""
        dJ = self.arm.jacobian_derivative_at(state)
        gradient: Array = self._gradient(state.J, dJ, self._terms, len(self.minor_columns))
        return gradient


CRITERIA: dict[str, type[Criterion]] = {each.name: each for each in (Manipulability, MinorMeasure)}
"""Criteria by name."""
