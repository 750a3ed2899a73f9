"""A criterion as a function of the joint positions, climbed with the task value held."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np

from ..arm import Arm, ArmState
from ..exceptions import ParameterError
from ..redundancy import Array, minor_measure, minor_measure_gradient
from ..tasks import TaskValue
from .postures import jacobian, project, task_error


@runtime_checkable
class HasValue(Protocol):
    """A criterion H: its value and, if it has one, its `gradient(state)`, shape (nv,)."""

    def value(self, state: ArmState) -> float:
        """Return H at a state."""


Criterion: TypeAlias = HasValue | Callable[[ArmState], float]


class Objective:
    """A criterion as a function of the joint positions, to be climbed with the task value held.

    Attributes:
        arm: The arm.
        value_of: The criterion as a function of the state.
        gradient_of: Its gradient, shape (nv,); None if it has none.
    """

    def __init__(self, arm: Arm, criterion: Criterion | None) -> None:
        """Set the arm and the criterion; None for the minor measure.

        Raises:
            ParameterError: If the criterion has no value and is no function.
        """
        self.arm, self._rest = arm, np.zeros(arm.nv)
        self.value_of: Callable[[ArmState], float]
        self.gradient_of: Callable[[ArmState], Array] | None
        if criterion is None:
            columns = arm.minor_columns
            self.value_of = lambda state: float(minor_measure(state.J, columns))
            self.gradient_of = lambda state: minor_measure_gradient(state.J, arm.jacobian_derivative(state.q), columns)
        elif isinstance(criterion, HasValue):
            self.value_of, self.gradient_of = criterion.value, getattr(criterion, "gradient", None)
        elif callable(criterion):
            self.value_of, self.gradient_of = criterion, None
        else:
            raise ParameterError(f"a criterion has a 'value(state)' or is a function of the state, got {criterion!r}")

    def value(self, positions: Array) -> float:
        """Return the criterion at joint positions, shape (nv,), rad; −∞ where it is not finite."""
        value = float(self.value_of(self._state(positions)))
        return value if np.isfinite(value) else -np.inf

    def climb(self, positions: Array, x: TaskValue, box: tuple[Array, Array]) -> tuple[Array, float]:
        """Return where SLSQP climbs to from joint positions with task value x, and the value there.

        Args:
            positions: Joint positions to begin with, shape (nv,), rad.
            x: The task value, which is held.
            box: Smallest and largest joint positions, shapes (nv,), rad.
        """
        from scipy.optimize import minimize

        scale = max(abs(self.value(positions)), 1e-9)

        def gradient(positions: Array) -> Array:
            assert self.gradient_of is not None  # noqa: S101
            return -self.gradient_of(self._state(positions)) / scale

        lower, upper = box
        result = minimize(
            lambda each: -self.value(each) / scale,
            np.clip(positions, lower, upper),
            jac=None if self.gradient_of is None else gradient,
            bounds=list(zip(lower, upper, strict=True)),
            constraints={
                "type": "eq",
                "fun": lambda each: task_error(self.arm, each, x),
                "jac": lambda each: -jacobian(self.arm, each),
            },
            method="SLSQP",
            options={"maxiter": 200, "ftol": 1e-14},
        )
        posture = project(self.arm, result.x, x) if np.isfinite(result.x).all() else None
        if posture is None or (posture < lower).any() or (posture > upper).any():
            return positions, -np.inf
        return posture, self.value(posture)

    def _state(self, positions: Array) -> ArmState:
        return self.arm.state(self.arm.configuration(positions), self._rest)
