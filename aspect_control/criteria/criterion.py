"""What every criterion is: a function of the configuration that more is better of."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from typing import Any, ClassVar

from ..arm import BORDER_TOLERANCE, Arm, ArmState
from ..exceptions import UndefinedCriterionWarning
from ..redundancy import Array, inverse_condition_number


class Criterion(ABC):
    """A performance function H(q) that a law increases by self-motion, Eqs. (2) and (17).

    What is to be decreased, such as a potential, is defined with the opposite sign, so that +∇H is always the way to
    go. The functions themselves are those of `redundancy`; a criterion ties one to an arm and to its parameters.

    Attributes:
        name: Name in the registry.
        arm: The arm.
    """

    name: ClassVar[str]

    def __init__(self, arm: Arm) -> None:
        """Set the arm."""
        self.arm = arm

    @property
    def parameters(self) -> dict[str, Any]:
        """The criterion's parameters as numbers, strings, lists and dicts, enough to construct it again on the arm."""
        return {}

    def start(self, q: Array) -> None:
        """Prepare for a motion that starts at q, shape (nq,), rad.

        A criterion that has no definite gradient there is reported by an `UndefinedCriterionWarning`.

        Raises:
            UndefinedCriterionError: If the criterion has no meaning there at all.
        """
        reason = self.undefined_because(q)
        if reason is not None:
            warnings.warn(
                f"the criterion {self.name!r} has no definite gradient at the start: {reason}",
                UndefinedCriterionWarning,
                stacklevel=4,
            )

    def undefined_because(self, q: Array) -> str | None:
        """Return why H has no definite gradient at q, shape (nq,), rad, in words; None if it has one."""
        return None

    @abstractmethod
    def value(self, state: ArmState) -> float:
        """Return H at a state."""

    @abstractmethod
    def gradient(self, state: ArmState) -> Array:
        """Return ∇H at a state, shape (nv,), in the unit of H per rad (per m for a prismatic joint). Never NaN."""


class JacobianCriterion(Criterion):
    """A criterion that is a function of J and has no gradient where J loses rank."""

    def undefined_because(self, q: Array) -> str | None:
        """Return why H has no gradient at q: the pose is singular."""
        ratio = float(inverse_condition_number(self.arm.jacobian(q)))
        if ratio > BORDER_TOLERANCE:
            return None
        return f"the pose is singular, the smallest singular value of J is {ratio:.2g} of the largest"
