"""What the laws have in common that are one compiled function of the state and the target."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numpy import empty
from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..redundancy import Array
from ..trajectories import Target
from .base import TaskSpaceController


class CompiledLaw(TaskSpaceController):
    """A task-space law that `redundancy.feedback.task_space_law` made one compiled function of: its `compiled_text`.

    A subclass without that sets `_law` to a prepared function when it is made.
    """

    is_compiled = True
    _law: Callable[..., None]

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0) -> None:
        """Set the arm and the task-space gains; see `TaskSpaceController`."""
        super().__init__(arm, kp=kp, kv=kv)
        if self._texts:
            (self._law,) = self._texts
        self._state_at = arm.unchecked_terms
        self._parameter: float | None = None

    def command(self, state: ArmState | tuple[Any, ...], target: Target) -> Array:
        """Return τ, shape (nv,), N m."""
        # `terms` in place: a call of its own would be the fiftieth part of the tick.
        _, v, M, nle, J, drift, x = state
        if self._has_rotation:
            x = -self.arm.coordinates.error(target.x, x)
        tau = empty(self.arm.nv)
        if self._parameter is None:
            self._law(M, nle, J, drift, x, v, target.rows, self._gains, tau)
        else:
            self._law(M, nle, J, drift, x, v, target.rows, self._gains, tau, self._parameter)
        return tau
