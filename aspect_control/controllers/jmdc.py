"""J-minor based dynamic control: stay inside the aspect by the choice of joint velocity."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import non_negative
from ..exceptions import AspectBorderWarning, NotResetError
from ..redundancy import Array, minor_measure_gradient, pseudoinverse
from ..trajectories import Target
from .base import Controller


class JMinorDynamicControl(Controller):
    """JMDC, Eqs. (17)–(21): redundancy is resolved in velocities, and the torque follows.

    θ̇_d^{i+1} = J⁺ẋ_d^i + κ(I − J⁺J)∇H                       Eq. (17), H the minor measure of Eq. (18)
    θ_d^{i+1} = θ_d^i + θ̇_d^i Δt                              Eq. (19)
    θ̈_d^i = (θ̇_d^i − θ̇_d^{i−1}) / Δt                         Eq. (20)
    τ = M{θ̈_d + K_v(θ̇_d − θ̇) + K_p(θ_d − θ)} + N             Eq. (21)

    with θ_d^0 = θ^0 and θ̇_d^0 = θ̇^0, the measured start. The law has memory: every call of `torque` is one sample.
    The target's position and acceleration are not used: the task is tracked in velocity, as printed.

    H is made of the minors that are not structurally zero. A start on the border of an aspect, where a minor is zero,
    is reported by an `AspectBorderWarning`; such minors have no sign to keep and are left out of H until the next
    `reset`.

    Attributes:
        kappa: κ, the weight of the minor measure.
        minor_columns: Columns of the minors that H is made of, shape (p, m).
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
        super().__init__(arm, arm.nv, kp, kv)
        self.kappa = non_negative("kappa", kappa)
        self.minor_columns = arm.minor_columns if self.kappa > 0.0 else np.empty((0, arm.task_dim), dtype=np.intp)
        self._dt: float | None = None
        self._q_d = self._v_d = self._v_d_before = np.zeros(0)

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {**super().parameters, "kappa": self.kappa}

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Set θ_d^0 = θ^0 and θ̇_d^0 = θ̇^0, and leave out the minors that are zero there."""
        self._dt = dt
        self._q_d, self._v_d, self._v_d_before = q, v, v
        if self.kappa > 0.0:
            on_border = self.arm.minors_on_border(q)
            self.minor_columns = np.delete(self.arm.minor_columns, on_border, axis=0)
            if len(on_border) > 0:
                warnings.warn(
                    f"jmdc starts on the border of an aspect: {len(on_border)} of {len(self.arm.minor_columns)} minors "
                    f"are zero and left out of the minor measure: {self.arm.describe_minors(on_border)}",
                    AspectBorderWarning,
                    stacklevel=3,
                )

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and move the commanded joint motion on by one sample."""
        if self._dt is None:
            raise NotResetError("jmdc has memory: call reset(q, v, dt) before the first torque(q, v, target)")
        a_d = (self._v_d - self._v_d_before) / self._dt
        position_error = self.arm.difference(state.q, self._q_d)
        tau: Array = state.M @ (a_d + self.kv @ (self._v_d - state.v) + self.kp @ position_error) + state.nle
        self._q_d = self.arm.integrate(self._q_d, self._v_d * self._dt)
        self._v_d_before, self._v_d = self._v_d, self._resolved_velocity(state, target)
        return tau

    def _resolved_velocity(self, state: ArmState, target: Target) -> Array:
        J, J_pinv = state.J, pseudoinverse(state.J)
        velocity: Array = J_pinv @ target.dx
        if self.kappa > 0.0:
            dJ = self.arm.jacobian_derivative(state.q)
            gradient = minor_measure_gradient(J, dJ, self.minor_columns)
            velocity += self.kappa * (gradient - J_pinv @ (J @ gradient))
        return velocity
