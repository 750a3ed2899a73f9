"""A criterion as a function of the joint positions, climbed with the task value held."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from ..arm import Arm, ArmState
from ..arm.postures import jacobian, project, task_error
from ..arm.tasks import TaskValue
from ..criteria import make
from ..exceptions import ParameterError
from ..redundancy import Array


@runtime_checkable
class HasValue(Protocol):
    """A criterion H: its value and, if it has one, its `gradient(state)`, shape (nv,)."""

    def value(self, state: ArmState) -> float:
        """Return H at a state."""


Criterion: TypeAlias = str | Mapping[str, Any] | HasValue | Callable[[ArmState], float]


class Objective:
    """A criterion as a function of the joint positions, to be climbed with the task value held.

    Attributes:
        arm: The arm.
        name: What the criterion is called.
        value_of: The criterion as a function of the state.
        gradient_of: Its gradient, shape (nv,); None if it has none.
    """

    def __init__(self, arm: Arm, criterion: Criterion) -> None:
        """Set the arm and the criterion.

        Raises:
            CriterionNotFoundError: If there is no criterion of that name.
            ParameterError: If the criterion has no value and is no function.
            AspectControlError: As the criterion's constructor does.
        """
        self.arm, self._rest = arm, np.zeros(arm.nv)
        self.value_of: Callable[[ArmState], float]
        self.gradient_of: Callable[[ArmState], Array] | None = None
        made = make(arm, criterion) if isinstance(criterion, str | Mapping) else criterion
        self.name = str(getattr(made, "name", getattr(made, "__name__", type(made).__name__)))
        if isinstance(made, HasValue):
            self.value_of, self.gradient_of = made.value, getattr(made, "gradient", None)
        elif callable(made):
            self.value_of = made
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
