"""Least torque as a quadratic program, with limits and with stability as a constraint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import positive
from ..exceptions import UnknownNameError
from ..redundancy import Array, pseudoinverse_torque
from ..redundancy.compiled import prepared
from ..redundancy.feedback import require_finite
from ..redundancy.open_torques import open_accelerations, open_torque
from ..trajectories import Target
from .base import TaskSpaceController
from .qp_limits import JointLimits
from .qp_program import Rows, Torques, no_torque_keeps_the_task, scale_of, task_scaled
from .qp_solver import NO_LIMIT, SAME_LIMITS
from .qp_solvers import find_solver
from .qp_stability import STABILITIES, stability_row
from .qp_tick import scaled_as_before, torque_as_before, torques_and_bounds

if TYPE_CHECKING:
    import qpsolvers


@dataclass(frozen=True, slots=True)
class QPStatus:
    """How the torque of one tick came about.

    Attributes:
        outcome: `"optimal"`: least torque, the task kept; `"scaled"`: least torque with the task acceleration scaled
            back; `"braking"`: no solution, the joints are braked.
        task_scale: s, the part of the task acceleration b that is kept, 0 to 1; 0 when braking.
        message: The solver's own words, or why none was called; when braking, why.
        iterations: Iterations of the solver, all its calls together, if it tells; 0 if none was called.
    """

    outcome: str
    task_scale: float
    message: str
    iterations: int | None


_FREE = QPStatus("optimal", 1.0, NO_LIMIT, 0)
_HELD = QPStatus("optimal", 1.0, SAME_LIMITS, 0)


class QPTorque(TaskSpaceController):
    """Least torque, Eq. (8), as a quadratic program with limits.

    With Z an orthonormal basis of the null space of J (n, r = n − m), every joint acceleration that gives the part s
    of the commanded task acceleration b is θ̈ = s J⁺b + Z z, and τ = M θ̈ + N. Eq. (8) is

    minimise ½‖τ‖² = ½‖M Z z + τ̃‖² over z

    By the factorisation M Z = Q R the unknown becomes η = Qᵀτ, the part of the torque that the task leaves open:
    τ = Q η + (I − QQᵀ)(s M J⁺b + N), θ̈ = M⁻¹(τ − N), and the program is as well conditioned as can be:

    minimise ½‖η‖²    subject to   |τ| ≤ τ_max,   θ̈ within its bounds,   θ̇_H·θ̈_H ≤ 0

    Without a limit in the way its solution is η = 0, which is Eq. (11). The bounds of θ̈ come from the limits of
    speed, position and acceleration; see `JointLimits.acceleration_interval`.

    At every sample:

    1. The program is solved with s = 1: outcome `"optimal"`.
       η = 0 and the minimum on the limits that held the last torque are looked at first. Where one of them is the
       solution, which the conditions for the minimum tell, no solver is called, and `status` says so.
    2. If it has no solution: maximise s in [0, 1], and among the torques of that s take the least; both at once, by
       the linear cost −w s with a large w, which is exact: outcome `"scaled"`.
    3. If that fails as well, the task is given up and the arm is braked: outcome `"braking"`. Each joint is decelerated
       by θ̈ = −θ̇/T, moved into the bounds of θ̈. If the torque M θ̈ + N of that is not within the torque limits, it is
       G + λ M θ̈ instead, with G the gravity torque and the largest λ in [0, 1] within them. It takes energy out of the
       arm at any λ > 0; a joint whose limit is below its own gravity torque gets what it has.

    A solution is used only if it satisfies the limits and the optimality conditions of this sample's program to
    `TOLERANCE`, whatever the solver says of it. No failure of a solver leaves `torque` as an exception.

    `stability` asks of the self-motion, with θ̈_H = Z z the acceleration added to the minimum-norm one:

    - `"maciejewski"`: θ̇_H·θ̈_H ≤ 0, Eq. (12) as a half-space. For r = 1 this is the modified method, Eqs. (13), (14).
    - `"dead-beat"`: −‖θ̇_H‖²/Δt ≤ θ̇_H·θ̈_H as well, so that one sample does not reverse the self-motion.

    Without self-motion, θ̇_H = 0, Eq. (12) says nothing. The half-space then faces the free null-space torque, so that
    no self-motion is started for its sake: Eq. (13).

    Attributes:
        solver: Name of the solver.
        limits: The limits.
        horizon: T, s.
        stability: What is asked of the self-motion.
        status: How the last torque came about; None before the first.
    """

    name = "qp"
    is_compiled = True
    compiled_text = (
        torques_and_bounds,
        open_torque,
        task_scaled,
        scale_of,
        no_torque_keeps_the_task,
        require_finite,
    )

    def __init__(
        self,
        arm: Arm,
        *,
        kp: ArrayLike = 100.0,
        kv: ArrayLike = 20.0,
        solver: str = "osqp",
        torque_limit: ArrayLike | str | None = None,
        speed_limit: ArrayLike | str | None = None,
        position_limit: Any = None,
        acceleration_limit: ArrayLike | str | None = None,
        horizon: float = 0.1,
        stability: str = "none",
    ) -> None:
        """Set the arm, the task-space gains, the limits and the solver.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.
            solver: A name of `qpsolvers.available_solvers`.
            torque_limit: Largest |τ|: None, `"urdf"`, a number or one a joint, N m.
            speed_limit: Largest |θ̇|: None, `"urdf"`, a number or one a joint, rad/s.
            position_limit: None, `"urdf"`, or a pair (lower, upper), each a number or one a joint, rad.
            acceleration_limit: Largest |θ̈|: None, a number or one a joint, rad/s².
            horizon: T, time in which a joint is braked, or led along its position limit, s. Also stands for Δt in the
                speed limit if `reset` was not called.
            stability: `"none"`, `"maciejewski"` or `"dead-beat"`.

        Raises:
            NotRedundantError: If the task takes up every joint.
            UnknownNameError: If the solver is not installed or `stability` is unknown; the message lists what exists.
            ShapeError: If a gain or a limit has the wrong shape.
            NonFiniteError: If a gain or a limit is not finite.
            ParameterError: If a gain is negative, a limit or the horizon not above zero, a lower limit not below the
                upper, or the URDF has no such limit.
        """
        super().__init__(arm, kp=kp, kv=kv)
        self.limits = JointLimits(arm, torque_limit, speed_limit, position_limit, acceleration_limit)
        self.horizon = positive("horizon", horizon, "s")
        if stability not in STABILITIES:
            raise UnknownNameError(stability, STABILITIES, kind="stability")
        self.stability = stability
        self._torque_limit = np.full(arm.nv, np.inf) if self.limits.torque is None else self.limits.torque
        self._torques_kept, self._buffer = Torques.in_buffer(arm.nv, arm.redundancy)
        self._kept_shape, self._scaled_shape = (arm.nv, arm.redundancy), (arm.nv + 1, arm.redundancy + 1)
        self._only_torque_limits = (
            self.limits.torque is not None and not self.limits.bound_acceleration and stability == "none"
        )
        self._fill, self._chosen = self._texts[:2]
        if self._only_torque_limits:
            self._kept_as_before, self._scaled_as_before = prepared(torque_as_before), prepared(scaled_as_before)
        else:
            self._accelerations, self._c_tilde = prepared(open_accelerations), prepared(pseudoinverse_torque)
        self._solver = find_solver(solver)
        self.solver = solver
        self.status: QPStatus | None = None
        self._dt: float | None = None

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {
            **super().parameters,
            "solver": self.solver,
            **self.limits.parameters,
            "horizon": self.horizon,
            "stability": self.stability,
        }

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Set Δt and forget the last motion."""
        self._dt = dt
        self.status = None
        self._solver.forget()

    def forget_limits_reached(self) -> None:
        """Forget which limits the last torque reached: the next one takes a call of the solver, if a limit binds."""
        self.status = None
        self._solver.forget_multipliers()

    def problem(self, q: ArrayLike, v: ArrayLike, target: Target) -> qpsolvers.Problem:
        """Return the quadratic program of a sample as it would be solved with the task kept, s = 1.

        Its unknown is η = Qᵀτ, shape (r,), N m: P = I, q = 0, and G η ≤ h holds the limits.

        Args:
            q: Measured joint configuration, shape (nq,), rad.
            v: Measured joint velocity, shape (nv,), rad/s.
            target: What the task is to do now.

        Raises:
            ShapeError: If q, v or the target has the wrong shape.
            NonFiniteError: If q or v is not finite.
            NotResetError: If `stability` is `"dead-beat"` and `reset` was not called.
        """
        self.require_target(target)
        state = self.arm.state(q, v)
        return self._torques(state, target).task_kept().problem()

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and set `status`."""
        before, solve = self.status.outcome if self.status is not None else "", self._solver.solve
        if self._only_torque_limits and before in ("optimal", "scaled"):
            torques, tau = self._torques_kept, self._as_before(state, target, before)
            solve = solve if before == "scaled" else self._solver.searched
        else:
            torques = self._torques(state, target)
            tau = self._scaled_again(torques) if before == "scaled" else None
        if tau is not None:
            return tau
        objections, iterations = [], 0
        for make_program, solved in ((torques.task_kept, solve), (torques.task_scaled, self._solver.solve)):
            try:
                program = make_program()
                answer = solved(program)
                objection = answer.objection(program)
            except Exception as error:
                objections.append(f"{self.solver}: {type(error).__name__}: {error}")
                continue
            iterations += answer.iterations or 0
            if objection or answer.x is None:
                objections.append(objection)
                continue
            known = iterations if answer.iterations is not None else None
            return self._taken(torques, answer.x, answer.message, known)
        message = "no torque within the limits: " + "; ".join(objections)
        self.status = QPStatus("braking", 0.0, message, iterations or None)
        return require_finite(np.clip(self._braking_torque(state), -self._torque_limit, self._torque_limit))

    def _as_before(self, state: ArmState, target: Target, before: str) -> Array | None:
        """Return the torque if no limit or those that held the last one give it, and set `status`.

        If not, `_torques_kept` holds what a solver is to choose from. For torque limits alone.
        """
        tau: Array
        given = *self.terms(state, target), self._torque_limit, self._buffer
        if before == "scaled":
            known, scale, tau = self._scaled_as_before(*given, self._solver.multipliers(self._scaled_shape))
            status = QPStatus("scaled", scale, SAME_LIMITS, 0)
        else:
            known, held, tau = self._kept_as_before(*given, self._solver.multipliers(self._kept_shape))
            status = _HELD if held else _FREE
        if not known:
            return None
        self.status = status
        return tau

    def _scaled_again(self, torques: Torques) -> Array | None:
        """Return the torque if the task was scaled back at the last sample and is so again, by the same limits."""
        program = torques.task_scaled()
        answer = self._solver.known(program)
        if answer is None or answer.x is None:
            return None
        if not no_torque_keeps_the_task(program.q, program.upper, answer.x, self._torque_limit):
            return None
        return self._taken(torques, answer.x, answer.message, answer.iterations)

    def _taken(self, torques: Torques, x: Array, message: str, iterations: int | None) -> Array:
        """Return τ of a solution, and set `status`."""
        eta, scale = torques.solution(x)
        tau: Array = self._chosen(torques.Q, torques.c, torques.d, eta, scale, self._torque_limit)
        self.status = QPStatus("optimal" if scale == 1.0 else "scaled", scale, message, iterations)
        return tau

    def _torques(self, state: ArmState, target: Target) -> Torques:
        """Return the torques of the tasks s b and the limits in terms of them."""
        self._fill(*self.terms(state, target), self._torque_limit, self._buffer)
        Q, c, d, of_torque_limits = self._torques_kept
        limits, rows = self.limits, []
        if limits.torque is not None:
            rows.append(of_torque_limits)
        if limits.bound_acceleration or self.stability != "none":
            M_inv_Q, M_inv_c, free = self._accelerations(state.M, state.nle, Q, c, d)
            if limits.bound_acceleration:
                slowest, fastest = self._acceleration_interval(state)
                rows.append(Rows(M_inv_Q, M_inv_c, slowest - free, fastest - free).unit())
            if self.stability != "none":
                rest, b = np.zeros(self.arm.nv), self.commanded_acceleration(state, target)
                c_tilde = self._c_tilde(state.M, rest, state.J, b)
                rows.append(stability_row(self.stability, state.v, Q, M_inv_Q, c_tilde, state.nle, self._dt))
        return Torques(Q, c, d, Rows.stack(rows, Q.shape[1]))

    def _acceleration_interval(self, state: ArmState) -> tuple[Array, Array]:
        dt = self._dt if self._dt is not None else self.horizon
        return self.limits.acceleration_interval(self.arm.positions(state.q), state.v, self.horizon, dt)

    def _braking_torque(self, state: ArmState) -> Array:
        """Return M θ̈ + N with θ̈ = −θ̇/T moved into the bounds of θ̈, or what the torque limits allow of it."""
        push = state.M @ np.clip(-state.v / self.horizon, *self._acceleration_interval(state))
        tau: Array = state.nle + push
        if np.all(np.abs(tau) <= self._torque_limit):
            return tau
        return self.limits.largest_part(push, self.arm.state(state.q, np.zeros(self.arm.nv)).nle)
