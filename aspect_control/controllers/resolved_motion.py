"""Resolved motion with computed torque: redundancy is resolved in velocities, and the torque follows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .. import criteria
from ..arm import Arm, ArmState
from ..checks import is_finite, non_negative
from ..criteria import Criterion
from ..exceptions import NonFiniteError, NotResetError
from ..redundancy import Array
from ..redundancy.resolved_velocity import computed_torque, resolved_velocity
from ..trajectories import Target
from .controller import Controller


class JointMotion(NamedTuple):
    """The commanded joint motion at one sample.

    Attributes:
        q: θ_d^i, shape (nq,), rad.
        v: θ̇_d^i, shape (nv,), rad/s.
        v_before: θ̇_d^{i−1}, shape (nv,), rad/s.
        dt: Δt, s.
    """

    q: Array
    v: Array
    v_before: Array
    dt: float


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
        memory: The commanded joint motion, a `JointMotion`.
    """

    name = "resolved-motion"
    memory: JointMotion | None = None
    criterion: Criterion | None

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
            arm: The arm; its task must leave a redundant degree of freedom.
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
        self._specification: str | dict[str, Any]
        if self.kappa == 0.0 and isinstance(criterion, str):
            # Only looked up: the arm may have more minors than the criterion, which is not used, can handle.
            criteria.find(criterion)
            self._specification, self.criterion = criterion, None
        else:
            made = criteria.make(arm, criterion)
            self._specification = criteria.specification(made)
            self.criterion = made if self.kappa > 0.0 else None

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "kappa": self.kappa, "criterion": self._specification}

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Set θ_d^0 = θ^0 and θ̇_d^0 = θ̇^0."""
        if self.criterion is not None:
            self.criterion.start(q)
        self.memory = JointMotion(q, v, v, dt)

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and move the commanded joint motion on by one sample."""
        if self.memory is None:
            raise NotResetError(f"{self.name} has memory: call reset(q, v, dt) before the first torque(q, v, target)")
        q_d, v_d, v_d_before, dt = self.memory
        v_d_next = resolved_velocity(state.J, target.dx, self.kappa, self._gradient(state))
        self.memory = JointMotion(self.arm.integrate(q_d, v_d * dt), v_d_next, v_d, dt)
        error = self.arm.difference(state.q, q_d)
        return computed_torque(state.M, state.nle, state.v, v_d, v_d_before, dt, self.kv, self.kp, error)

    def _gradient(self, state: ArmState) -> Array:
        if self.criterion is None:
            return np.zeros(self.arm.nv)
        gradient = self.criterion.gradient(state)
        if not is_finite(gradient):
            raise NonFiniteError(f"the gradient of the criterion {self.criterion.name!r} is not finite: {gradient}")
        return gradient
