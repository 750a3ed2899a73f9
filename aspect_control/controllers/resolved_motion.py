"""Resolved motion with computed torque: redundancy is resolved in velocities, and the torque follows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import criteria
from ..arm import Arm, ArmState
from ..checks import non_negative
from ..criteria import Criterion
from ..exceptions import NotResetError
from ..redundancy import Array
from ..redundancy.compiled import prepared
from ..redundancy.gradients import given_gradient
from ..redundancy.resolved_motion import resolved_motion_law
from ..trajectories import Target
from .base import Controller


class ResolvedMotion(Controller):
    """Eq. (2) with the computed torque of Eq. (21).

    θ̇_d^{i+1} = J⁺ẋ_d^i + κ(I − J⁺J)∇H                       Eqs. (2), (17)
    θ_d^{i+1} = θ_d^i + θ̇_d^i Δt                              Eq. (19)
    θ̈_d^i = (θ̇_d^i − θ̇_d^{i−1}) / Δt                         Eq. (20)
    τ = M{θ̈_d + K_v(θ̇_d − θ̇) + K_p(θ_d − θ)} + N             Eq. (21)

    with θ_d^0 = θ^0 and θ̇_d^0 = θ̇^0, the measured start. The law has memory: every call of `torque` is one sample.
    The target's position and acceleration are not used: the task is tracked in velocity, as printed.

    The method of A. Liégeois, "Automatic supervisory control of the configuration and behavior of multibody
    mechanisms", IEEE Transactions on Systems, Man, and Cybernetics 7 (1977), with the computed torque of the paper.

    Attributes:
        kappa: κ, the weight of the criterion.
        criterion: The criterion H; None for κ = 0, where none is needed.
    """

    name = "resolved-motion"
    is_compiled = True

    def __init__(
        self,
        arm: Arm,
        *,
        kp: ArrayLike = 100.0,
        kv: ArrayLike = 20.0,
        kappa: float = 0.001,
        criterion: str | Mapping[str, Any] | Criterion = "manipulability",
    ) -> None:
        """Set the arm, the joint-space gains and the criterion.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            kp: Position gain K_p, 1/s²: a scalar, a vector of n entries or an (n, n) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of n entries or an (n, n) matrix.
            kappa: κ, rad² per s and unit of H; 0 leaves the criterion out.
            criterion: H, which is increased: a name of `criteria.available()`; a mapping with a `name` and the
                criterion's parameters; or a criterion of the arm.

        Raises:
            UnknownNameError: If there is no such criterion, or it has no such parameter.
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain or κ is negative, or a parameter of the criterion has an impossible value.
            TooManyMinorsError: If the criterion needs more minors than can be handled.
        """
        super().__init__(arm, arm.nv, kp, kv)
        self.kappa = non_negative("kappa", kappa)
        self.criterion: Criterion | None = None
        self._specification: str | dict[str, Any]
        if self.kappa == 0.0 and isinstance(criterion, str):
            # Only looked up: the arm may have more minors than the criterion, which is not used, can handle.
            criteria.find(criterion)
            self._specification = criterion
        else:
            made = criteria.make(arm, criterion)
            self._specification = criteria.specification(made)
            self.criterion = made if self.kappa > 0.0 else None
        gradient = given_gradient if self.criterion is None else self.criterion.compiled_gradient
        self._sample = prepared(resolved_motion_law(gradient))
        self._given_gradient = gradient is given_gradient
        if self.criterion is None or not self._given_gradient:
            self._state_at = arm.unchecked_state_without_task
        self._no_gradient = np.zeros(arm.nv)
        self._dt: float | None = None
        self._q_d = np.zeros(0)
        self._memory = np.zeros((3, arm.nv))
        self._displacement = self._memory[2]

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "kappa": self.kappa, "criterion": self._specification}

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Set θ_d^0 = θ^0 and θ̇_d^0 = θ̇^0."""
        self._dt = dt
        self._q_d, self._memory[:2] = q, v
        if self.criterion is not None:
            self.criterion.start(q)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and move the commanded joint motion on by one sample."""
        if self._dt is None:
            raise NotResetError(f"{self.name} has memory: call reset(q, v, dt) before the first torque(q, v, target)")
        q, v, M, nle, J, _, _ = state
        arguments = self._gradient_arguments(state)
        error, tau = self.arm.difference(q, self._q_d), np.empty(self.arm.nv)
        self._sample(M, nle, J, v, target.rows, self._gains, error, self._memory, self.kappa, self._dt, tau, arguments)
        self._q_d = self.arm.integrate(self._q_d, self._displacement)
        return tau

    def _gradient_arguments(self, state: ArmState) -> tuple[Any, ...]:
        if self.criterion is None:
            return (self._no_gradient,)
        return (self.criterion.gradient(state),) if self._given_gradient else self.criterion.gradient_arguments(state)
