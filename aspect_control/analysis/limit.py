"""What a run converges to as the sampling time goes to zero: the closed loop in continuous time."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from ..checks import finite_vector
from ..controllers import TaskSpaceController
from ..plants import RigidBodyPlant
from ..redundancy import Array, homogeneous_acceleration, homogeneous_velocity, minimum_torque, pseudoinverse_torque
from ..trajectories import Target, Trajectory

TOLERANCE = 1e-10
"""Relative and absolute tolerance of the solver."""

_GRID = 2000
"""Points on which each smooth piece is searched for its peaks before they are refined."""


class ContinuousLimit(NamedTuple):
    """Peaks and end of a run in continuous time.

    Attributes:
        peak_torque: Largest |τ| of each joint, shape (nv,), N m.
        peak_torque_time: When, shape (nv,), s.
        maciejewski_product_max: Largest θ̇_H·θ̈_H of Eq. (12), rad²/s³.
        maciejewski_product_max_time: When, s.
        q_end: Joint configuration at the end, shape (nq,), rad.
        evaluations: How often the solver evaluated the law.
    """

    peak_torque: Array
    peak_torque_time: Array
    maciejewski_product_max: float
    maciejewski_product_max_time: float
    q_end: Array
    evaluations: int

    def to_dict(self) -> dict[str, Any]:
        """Return the peaks and the end as plain numbers and lists, for JSON."""
        return {name: np.asarray(value).tolist() for name, value in self._asdict().items()}


def continuous_limit(controller: TaskSpaceController, trajectory: Trajectory, q0: ArrayLike) -> ContinuousLimit:
    """Integrate a closed loop in continuous time by an explicit Runge-Kutta method of order 8 (DOP853).

    Args:
        controller: A law without memory that is a smooth function of state and target between breakpoints.
        trajectory: What the task is to do; the integration restarts at its breakpoints.
        q0: Joint configuration at the start, shape (nq,), rad; the arm starts at rest.

    Returns:
        The peaks, located on the solver's dense output, and the end.

    Raises:
        ShapeError: If q0 has the wrong shape.
        NonFiniteError: If q0 is not finite.
    """
    loop = _ClosedLoop(controller, trajectory, finite_vector("q0", q0, controller.arm.nq))
    nv = controller.arm.nv
    y = np.zeros(2 * nv)
    edges = (0.0, *trajectory.breakpoints, trajectory.duration)
    evaluations, peaks = 0, []
    for begin, end in pairwise(edges):
        loop.piece_end = end
        solution = solve_ivp(
            loop.derivative, (begin, end), y, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE, dense_output=True
        )
        y = solution.y[:, -1]
        evaluations += solution.nfev
        peaks.append(_peaks(loop, solution.sol, begin, end))
    values, times = (np.array(column) for column in zip(*peaks, strict=True))
    best = values.argmax(axis=0)
    values, times = values.max(axis=0), times[best, np.arange(nv + 1)]
    return ContinuousLimit(
        peak_torque=values[:nv],
        peak_torque_time=times[:nv],
        maciejewski_product_max=float(values[nv]),
        maciejewski_product_max_time=float(times[nv]),
        q_end=loop.configuration(y),
        evaluations=evaluations,
    )


class _ClosedLoop:
    """The closed loop as an ordinary differential equation in y = (displacement from q0, v)."""

    def __init__(self, controller: TaskSpaceController, trajectory: Trajectory, q0: Array) -> None:
        self.controller, self.trajectory, self.q0 = controller, trajectory, q0
        self.arm, self.plant = controller.arm, RigidBodyPlant(controller.arm)
        self.start = self.arm.task_position(q0)
        self.piece_end = trajectory.duration

    def configuration(self, y: Array) -> Array:
        return self.arm.integrate(self.q0, y[: self.arm.nv])

    def derivative(self, t: float, y: Array) -> Array:
        q, v = self.configuration(y), y[self.arm.nv :]
        tau = self.controller.torque(q, v, self.target(t))
        return np.concatenate([v, self.plant.acceleration(q, v, tau)])

    def outputs(self, t: float, y: Array) -> Array:
        """Return |τ| of each joint and θ̇_H·θ̈_H."""
        q, v = self.configuration(y), y[self.arm.nv :]
        target = self.target(t)
        state = self.arm.state(q, v)
        M, nle, J = state.M, state.nle, state.J
        b = self.controller.commanded_acceleration(state, target)
        theta_ddot_H = homogeneous_acceleration(M, minimum_torque(M, nle, J, b), pseudoinverse_torque(M, nle, J, b))
        tau = self.controller.command(state, target)
        return np.append(np.abs(tau), homogeneous_velocity(J, v) @ theta_ddot_H)

    def target(self, t: float) -> Target:
        """Return the target, with t off the jump at the end of its piece, where it already belongs to the next one."""
        inside = min(t, self.piece_end - 4e-12 * self.trajectory.duration)
        return self.trajectory.target(inside, self.start, self.arm.coordinates)


def _peaks(loop: _ClosedLoop, solution: Any, begin: float, end: float) -> tuple[Array, Array]:
    t = np.linspace(begin, end, _GRID + 1)
    sampled = np.array([loop.outputs(time, solution(time)) for time in t])
    values, times = [], []
    for column, index in enumerate(sampled.argmax(axis=0)):
        bounds = (t[max(index - 1, 0)], t[min(index + 1, _GRID)])
        found = minimize_scalar(
            lambda time, column=column: -loop.outputs(time, solution(time))[column],
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-9},
        )
        value, time = max((sampled[index, column], t[index]), (-found.fun, found.x))
        values.append(value)
        times.append(time)
    return np.array(values), np.array(times)
