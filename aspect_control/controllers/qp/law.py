"""Least torque as a quadratic program, with limits, damped self-motion and stability as a constraint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...arm import Arm
from ...arm_state import ArmState
from ...checks import non_negative, positive
from ...exceptions import UnknownNameError
from ...redundancy import Array
from ...trajectories import Target
from ..base import TaskSpaceController
from .limits import JointLimits
from .program import TOLERANCE, Rows, minimum_on_bounds, open_torques, torque_on_bounds
from .solvers import DAQP, NoSolutionFound, find_solver
from .stability import STABILITIES, self_motion_bound

if TYPE_CHECKING:
    import qpsolvers


@dataclass(frozen=True, slots=True)
class QPStatus:
    """How the torque of one tick came about.

    Attributes:
        outcome: `"optimal"`: least cost, the task kept; `"scaled"`: least cost with the task acceleration scaled back;
            `"braking"`: no solution, the joints are braked.
        task_scale: s, the part of the task acceleration b that is kept, 0 to 1; 0 when braking.
        message: The solvers' own words, or why none was called; when braking, why.
        iterations: Iterations of the solvers, all calls together, as far as they tell; 0 if none was called.
    """

    outcome: str
    task_scale: float
    message: str
    iterations: int


_FREE = QPStatus("optimal", 1.0, "no active limit, no solver called", 0)
_SAME_LIMITS = "the limits active before are active again, no solver called"


class QPMemory(NamedTuple):
    """What the law carries from one sample to the next.

    Attributes:
        dt: Δt, s; None if `reset` was not called.
        status: How the last torque came about; None before the first.
        side: Which bounds held the last minimum that a solver found, as `minimum_on_bounds` takes it; None before.
    """

    dt: float | None = None
    status: QPStatus | None = None
    side: Array | None = None


class QPTorque(TaskSpaceController):
    """Least torque, Eq. (8), as a quadratic program with limits and damped self-motion.

    DOC

    Attributes:
        solver: Name of the solver.
        limits: The limits.
        damping: D, 1/s.
        horizon: T, s.
        stability: What is asked of the self-motion.
    """

    name = "qp"
    memory: QPMemory | None = None

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
        damping: float = 10.0,
        horizon: float = 0.1,
        stability: str = "none",
    ) -> None:
        """Set the arm, the task-space gains, the limits and the solver.

        Args:
            arm: The arm; its task must leave at least one redundant degree of freedom.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.
            solver: A name of `qpsolvers.available_solvers`.
            torque_limit: Largest |τ|: None, `"urdf"`, a number or one a joint, N m.
            speed_limit: Largest |θ̇|: None, `"urdf"`, a number or one a joint, rad/s.
            position_limit: None, `"urdf"`, or a pair (lower, upper), each a number or one a joint, rad.
            acceleration_limit: Largest |θ̈|: None, a number or one a joint, rad/s².
            damping: D, 1/s; 0 for Eq. (8) alone.
            horizon: T, time in which a joint is braked, or led along its position limit, s. Also stands for Δt in the
                speed limit if `reset` was not called.
            stability: `"none"`, `"maciejewski"` or `"dead-beat"`.

        Raises:
            NotRedundantError: If the task takes up every joint.
            UnknownNameError: If the solver is not installed or `stability` is unknown; the message lists what exists.
            ShapeError: If a gain or a limit has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain or the damping is negative, a limit or the horizon not above zero, a lower limit
                not below the upper, or the robot's description has no such limit.
        """
        super().__init__(arm, kp=kp, kv=kv)
        self.limits = JointLimits(arm, torque_limit, speed_limit, position_limit, acceleration_limit)
        self.damping = non_negative("damping", damping, "1/s")
        self.horizon = positive("horizon", horizon, "s")
        if stability not in STABILITIES:
            raise UnknownNameError(stability, STABILITIES, kind="stability")
        self.stability = stability
        self._torque_limits_alone = stability == "none" and not self.limits.bound_acceleration
        self._nothing_held = np.zeros(arm.nv + 1)
        self.solver = solver
        chosen = find_solver(solver)
        self._solvers = (chosen,) if isinstance(chosen, DAQP) else (chosen, DAQP())

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters; see `Controller.parameters`."""
        return {
            **super().parameters,
            "solver": self.solver,
            **self.limits.parameters,
            "damping": self.damping,
            "horizon": self.horizon,
            "stability": self.stability,
        }

    @property
    def status(self) -> QPStatus | None:
        """How the last torque came about; None before the first."""
        return None if self.memory is None else self.memory.status

    def start(self, q: Array, v: Array, dt: float) -> None:
        """Set Δt and forget the last motion."""
        self.memory = QPMemory(dt)

    def problem(self, state: ArmState, target: Target) -> qpsolvers.Problem:
        """Return the quadratic program of a sample, as it is solved where the free torque breaks a limit.

        Its unknown is (ζ, σ), shape (r + 1,), N m. P is diagonal, q has the cost of σ, and G x ≤ h holds the limits, σ ≤ σ₁
        and −σ ≤ 0 among them; σ₁ is what σ is at s = 1.

        Args:
            state: The arm's state, `arm.state(q, v)`.
            target: What the task is to do now.

        Raises:
            ShapeError: If the target is not one for the arm's task.
            NotResetError: If `stability` is `"dead-beat"` and `reset` was not called.
        """
        self.require_target(target)
        memory, terms = self.memory or QPMemory(), self._terms(state, target)
        return self._rows(state, memory, *open_torques(*terms)).program().problem()

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and remember how it came about."""
        memory, terms = self.memory or QPMemory(), self._terms(state, target)
        tau, status, side = self._as_before(memory, terms) or self._solved(state, memory, terms)
        self.memory = QPMemory(memory.dt, status, side)
        return tau

    def _terms(self, state: ArmState, target: Target) -> tuple[Array, Array, Array, Array, Array, float]:
        """Return the arguments of `open_torques`."""
        b = self.commanded_acceleration(state, target)
        return state.M, state.nle, state.J, b, state.v, self.damping

    def _as_before(self, memory: QPMemory, terms: tuple[Any, ...]) -> tuple[Array, QPStatus, Array] | None:
        """Return the torque if no torque limit is active, or those that were before; most ticks end here."""
        if not self._torque_limits_alone:
            return None
        side, n = memory.side if memory.side is not None else self._nothing_held, self.arm.nv
        try:
            found = torque_on_bounds(*terms, self.limits.torque, side)
        except np.linalg.LinAlgError:
            return None
        if found[-1] < 0.0:
            return None
        status = _FREE if found[-1] > 0.0 else _status(float(found[n]), _SAME_LIMITS, 0)
        return found[:n], status, side

    def _solved(
        self, state: ArmState, memory: QPMemory, terms: tuple[Any, ...]
    ) -> tuple[Array, QPStatus, Array | None]:
        """Return the torque by the solvers, or the braking torque."""
        B, c, d = open_torques(*terms)
        limit, rows = self.limits.torque, self._rows(state, memory, B, c, d)
        if (rows.lower <= rows.g).all() and (rows.g <= rows.upper).all():
            return c + d, _FREE, memory.side
        program, messages, iterations = rows.program(), [], 0
        for solver in self._solvers:
            try:
                side, message, count = solver.solve(program)
                messages, iterations = [*messages, message], iterations + count
                x, violation = minimum_on_bounds(*program, side)
            except NoSolutionFound as error:
                messages.append(str(error))
                continue
            except Exception as error:
                messages.append(f"{type(solver).__name__}: {type(error).__name__}: {error}")
                continue
            if violation <= TOLERANCE:
                s = float(x[-1] / program.upper[-1])
                side.setflags(write=False)
                tau = np.clip(B @ x[:-1] + s * c + d, -limit, limit)
                return tau, _status(s, "; ".join(messages), iterations), side
            messages.append(f"not exact by {violation:.1e}")
        message = "no torque within the limits: " + "; ".join(messages)
        tau = np.clip(self._braking_torque(state, memory), -limit, limit)
        return tau, QPStatus("braking", 0.0, message, iterations), None

    def _rows(self, state: ArmState, memory: QPMemory, B: Array, c: Array, d: Array) -> Rows:
        """Return the limits on the torques B ζ + s c + d."""
        limits = self.limits
        rows = [Rows(B, c, -limits.torque - d, limits.torque - d)]
        if self._torque_limits_alone:
            return rows[0]
        # θ̈ = A ζ + s g + rest
        accelerations = np.linalg.solve(state.M, np.column_stack((B, c, d - state.nle)))
        A, g, rest = accelerations[:, :-2], accelerations[:, -2], accelerations[:, -1]
        if limits.bound_acceleration:
            slowest, fastest = self._acceleration_interval(state, memory)
            rows.append(Rows(A, g, slowest - rest, fastest - rest).unit())
        if self.stability != "none":
            u, least = self_motion_bound(self.stability, state.v, A, g + rest, memory.dt)
            at_rest = np.array([u @ rest])
            rows.append(Rows((u @ A)[None], np.array([u @ g]), least - at_rest, -at_rest).unit())
        return Rows(*map(np.concatenate, zip(*rows, strict=True)))

    def _acceleration_interval(self, state: ArmState, memory: QPMemory) -> tuple[Array, Array]:
        dt = self.horizon if memory.dt is None else memory.dt
        return self.limits.acceleration_interval(self.arm.positions(state.q), state.v, self.horizon, dt)

    def _braking_torque(self, state: ArmState, memory: QPMemory) -> Array:
        """Return M θ̈ + N with θ̈ = −θ̇/T moved into the bounds of θ̈, or what the torque limits allow of it."""
        push = state.M @ np.clip(-state.v / self.horizon, *self._acceleration_interval(state, memory))
        tau: Array = state.nle + push
        if np.all(np.abs(tau) <= self.limits.torque):
            return tau
        return self.limits.largest_part(push, self.arm.state(state.q, np.zeros(self.arm.nv)).nle)


def _status(s: float, message: str, iterations: int) -> QPStatus:
    s = min(max(s, 0.0), 1.0)
    return QPStatus("scaled", s, message, iterations) if s < 1.0 - TOLERANCE else QPStatus("optimal", 1.0, message, iterations)
