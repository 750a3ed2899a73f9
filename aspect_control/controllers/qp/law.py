"""Least torque as a quadratic program, with limits, damped self-motion and stability as a constraint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ...arm import Arm, ArmState
from ...checks import known_name, non_negative, positive
from ...redundancy import Array
from ...trajectories import Target
from ..controller import TaskSpaceController
from .acceleration_bounds import JointLimits
from .program import TOLERANCE, Program, Rows, minimum_on_bounds, null_space_torques, program_of_rows, torque_on_bounds
from .self_motion_bound import STABILITIES, self_motion_bound
from .solvers import DAQP, NoSolutionFound, find_solver

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


_Found: TypeAlias = tuple[Array, QPStatus, Array | None]


class QPTorque(TaskSpaceController):
    """Least torque, Eq. (8), as a quadratic program with limits and damped self-motion.

    Every joint acceleration that gives the part s of the commanded task acceleration b is θ̈ = s J⁺b + θ̈_H with θ̈_H in
    the null space of J, and its torque is τ = M θ̈ + N. The law is

    minimise ½‖τ‖² + ½ρ(θ̈_H + D θ̇_H)ᵀM(θ̈_H + D θ̇_H)
    subject to |τ| ≤ τ_max,   θ̈ within its bounds,   θ̇_H·θ̈_H ≤ 0

    The second cost lets the self-motion decay at the rate D. Its ρ is `program.SELF_MOTION_COST` times the mean inertia
    of the joints, so that both costs are squares of torques; without it, at D = 0, this is Eq. (8), which builds up
    self-motion until the torques explode. The bounds of θ̈ come from the limits of speed, position and acceleration;
    see `JointLimits.acceleration_interval`.

    At every sample:

    1. The minimum of the cost at s = 1 without limits is looked at first, which at D = 0 is the torque of Eq. (11);
       with torque limits alone also the minimum on the limits that were active before. Where one of them is the
       solution, which the conditions for the minimum tell, no solver is called.
    2. Otherwise a solver says which limits are active, and the linear equations of those give the solution. The task
       has a weight so large that s < 1 only if no torque within the limits gives s = 1, and then s is the largest
       possible. Outcome `"optimal"` at s = 1, else `"scaled"`.
    3. If the solver's answer does not meet the conditions for the minimum, DAQP is asked.
    4. If that fails as well, the task is given up and the arm is braked: outcome `"braking"`. Each joint is decelerated
       by θ̈ = −θ̇/T, moved into the bounds of θ̈. If the torque M θ̈ + N of that is not within the torque limits, it is
       G + λ M θ̈ instead, with G the gravity torque and the largest λ in [0, 1] within them. It takes energy out of the
       arm at any λ > 0; a joint whose limit is below its own gravity torque gets what it has.

    No failure of a solver leaves `torque` as an exception, and a torque depends on the sample and on `memory` alone.
    `stability` asks of the self-motion:

    - `"maciejewski"`: θ̇_H·θ̈_H ≤ 0, Eq. (12) as a half-space. With one redundant degree of freedom and D = 0 this is the
      modified method, Eqs. (13), (14).
    - `"dead-beat"`: −‖θ̇_H‖²/Δt ≤ θ̇_H·θ̈_H as well, so that one sample does not reverse the self-motion.

    Not safe by itself: torque limits alone do not keep an arm from its other limits, and a joint whose gravity torque
    is beyond its limit falls.
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
        self.limits = limits = JointLimits(arm, torque_limit, speed_limit, position_limit, acceleration_limit)
        self.torque_limit, self.speed_limit, self.acceleration_limit = limits.torque, limits.speed, limits.acceleration
        self.position_limit = limits.lower, limits.upper
        self.damping = non_negative("damping", damping, "1/s")
        self.horizon = positive("horizon", horizon, "s")
        self.stability = known_name(stability, STABILITIES, "stability")
        self._torque_limits_alone = stability == "none" and not self.limits.bound_acceleration
        self._nothing_held = np.zeros(arm.nv + 1)
        self.solver, chosen = solver, find_solver(solver)
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

        Its unknown is x = (ζ, σ), shape (r + 1,), N m: τ = B ζ + s c + d, with σ a multiple of s and the others of
        `null_space_torques`. G x ≤ h holds the upper limits, then the lower ones, each with that of σ as its last.

        Args:
            state: The arm's state, `arm.state(q, v)`.
            target: What the task is to do now.

        Raises:
            ShapeError: If the target is not one for the arm's task.
            NotResetError: If `stability` is `"dead-beat"` and `reset` was not called.
        """
        self.require_target(target)
        memory, terms = self.memory or QPMemory(), self._terms(state, target)
        return Program(*program_of_rows(*self._rows(state, memory, *null_space_torques(*terms)))).problem()

    def command(self, state: ArmState, target: Target) -> Array:
        """Return τ, shape (nv,), N m, and remember how it came about."""
        memory, terms = self.memory or QPMemory(), self._terms(state, target)
        if self._torque_limits_alone:
            tau, status, side = self._warm_started(state, memory, terms)
        else:
            tau, status, side = self._searched(state, memory, *null_space_torques(*terms))
        self.memory = QPMemory(memory.dt, status, side)
        return tau

    def _terms(self, state: ArmState, target: Target) -> tuple[Any, ...]:
        """Return the arguments of `null_space_torques`."""
        b = self.commanded_acceleration(state, target)
        return state.M, state.nle, state.J, b, state.v, self.damping

    def _warm_started(self, state: ArmState, memory: QPMemory, terms: tuple[Any, ...]) -> _Found:
        """Return the torque if no torque limit is active, or those that were before; most ticks end here."""
        side, n = self._nothing_held if memory.side is None else memory.side, self.arm.nv
        try:
            found = torque_on_bounds(*(*terms, self.limits.torque, side))
        except np.linalg.LinAlgError:
            return self._searched(state, memory, *null_space_torques(*terms))
        kind, s = found[:2].tolist()
        if kind < 0.0:
            return self._searched(state, memory, found[n + 2 : -2 * n].reshape(n, -1), found[-2 * n : -n], found[-n:])
        return found[2 : n + 2], _FREE if kind > 0.0 else _status(s, _SAME_LIMITS, 0), side

    def _searched(self, state: ArmState, memory: QPMemory, B: Array, c: Array, d: Array) -> _Found:
        """Return the torque by the solvers, or the braking torque."""
        limit, rows = self.limits.torque, self._rows(state, memory, B, c, d)
        if (rows.lower <= rows.g).all() and (rows.g <= rows.upper).all():
            return c + d, _FREE, memory.side
        program, messages, iterations = Program(*program_of_rows(*rows)), list[str](), 0
        for solver in self._solvers:
            try:
                side, message, count = solver.solve(program)
                messages.append(message)
                iterations += count
                x, violation = minimum_on_bounds(*program, side)
            except Exception as error:
                kind = "" if isinstance(error, NoSolutionFound) else f"{type(error).__name__}: "
                messages.append(f"{solver.name}: {kind}{error}")
                continue
            if violation <= TOLERANCE:
                s = float(x[-1] / program.upper[-1])
                side.setflags(write=False)
                tau = np.clip(B @ x[:-1] + s * c + d, -limit, limit)
                return tau, _status(s, "; ".join(messages), iterations), side
            messages.append(f"not exact by {violation:.1e}")
        message = "no torque within the limits: " + "; ".join(messages)
        return self._braking_torque(state, memory), QPStatus("braking", 0.0, message, iterations), None

    def _rows(self, state: ArmState, memory: QPMemory, B: Array, c: Array, d: Array) -> Rows:
        """Return the limits on the torques B ζ + s c + d."""
        limits = self.limits
        rows = [Rows(B, c, -limits.torque - d, limits.torque - d)]
        if self._torque_limits_alone:
            return rows[0]
        # θ̈ = A ζ + s g + rest
        M_inv: Array = np.asarray(np.linalg.inv(state.M), dtype=np.float64)
        A, g, rest = M_inv @ B, M_inv @ c, M_inv @ (d - state.nle)
        if limits.bound_acceleration:
            slowest, fastest = self._bounds(state, memory)
            rows.append(Rows(A, g, slowest - rest, fastest - rest).unit())
        if self.stability != "none":
            u, least = self_motion_bound(self.stability, state.v, A, g + rest, memory.dt)
            at_rest = np.array([u @ rest])
            rows.append(Rows((u @ A)[None], np.array([u @ g]), least - at_rest, -at_rest).unit())
        return Rows(*map(np.concatenate, zip(*rows, strict=True)))

    def _bounds(self, state: ArmState, memory: QPMemory) -> tuple[Array, Array]:
        """Return the bounds of θ̈."""
        dt = self.horizon if memory.dt is None else memory.dt
        return self.limits.acceleration_interval(self.arm.positions(state.q), state.v, self.horizon, dt)

    def _braking_torque(self, state: ArmState, memory: QPMemory) -> Array:
        """Return M θ̈ + N with θ̈ = −θ̇/T moved into the bounds of θ̈, or what the torque limits allow of it."""
        limit, push = self.limits.torque, state.M @ np.clip(-state.v / self.horizon, *self._bounds(state, memory))
        if np.all(np.abs(state.nle + push) <= limit):
            return state.nle + push
        gravity = self.arm.state(state.q, np.zeros(self.arm.nv)).nle
        room, moving = np.maximum(limit - np.sign(push) * gravity, 0.0), push != 0.0
        part = min(1.0, float((room[moving] / np.abs(push[moving])).min(initial=1.0)))
        return np.clip(gravity + part * push, -limit, limit)


def _status(s: float, message: str, iterations: int) -> QPStatus:
    kept = s >= 1.0 - TOLERANCE
    return QPStatus("optimal" if kept else "scaled", 1.0 if kept else max(s, 0.0), message, iterations)
