"""The closed loop: a law, a trajectory and a plant, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..checks import finite_vector, positive
from ..controllers import Controller
from ..exceptions import NonFiniteError, ParameterError, ShapeError
from ..trajectories import Trajectory
from .integrators import Integrator, find_integrator
from .plant import Plant
from .run import Run
from .run_file import RunInfo, Status, versions

MAX_SAMPLES = 20_000_000
"""The longest recording that is started, in samples: about 5 GB for a 7-axis arm."""

DIVERGED_SPEED = 1e6
"""Joint speed above which a run has diverged, rad/s (m/s for prismatic joints)."""


def simulate(
    controller: Controller,
    trajectory: Trajectory,
    *,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    dt: float = 1e-3,
    integrator: str | Integrator = "rk4",
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Run a law on a trajectory in closed loop and record it.

    The torque is computed at every sample and held until the next. The trajectory starts where q0 puts the task
    frame. A run whose joint speed passes `DIVERGED_SPEED`, or whose state or torque is no longer finite, ends there
    with `run.status == "diverged"`; what was recorded up to then is kept.

    Args:
        controller: The law, with its arm.
        trajectory: What the task is to do.
        q0: Joint configuration at the start, shape (nq,), rad.
        v0: Joint velocity at the start, shape (nv,), rad/s; None for rest.
        dt: Sampling time, s.
        integrator: A name of `simulation.INTEGRATORS`, or an integrator.
        progress: Called with the part of the motion that is done, 0 to 1, about a hundred times.

    Returns:
        The run, with k = ⌊duration / dt⌋ + 1 samples.

    Raises:
        ShapeError: If q0 or v0 has the wrong shape, or the trajectory another number of task coordinates than the arm.
        NonFiniteError: If q0 or v0 is not finite.
        ParameterError: If v0 is beyond `DIVERGED_SPEED`, or dt is not above zero, longer than the motion, or so short
            that the recording would not fit.
        UnknownNameError: If there is no such integrator.
    """
    arm = controller.arm
    q = finite_vector("q0", q0, arm.nq)
    v = finite_vector("v0", v0, arm.nv) if v0 is not None else np.zeros(arm.nv)
    if np.abs(v).max() > DIVERGED_SPEED:
        raise ParameterError(f"v0 must be within ±{DIVERGED_SPEED:g} rad/s, got {v.tolist()}")
    samples = _samples(trajectory.duration, positive("dt", dt, "s"))
    if trajectory.task_dim != arm.task_dim:
        raise ShapeError(
            f"the trajectory has {trajectory.task_dim} task coordinates, "
            f"the arm's task {arm.task} has {arm.task_dim}: give one number for each"
        )
    method, plant, start = find_integrator(integrator), Plant(arm), arm.task_position(q)
    t = np.arange(samples, dtype=np.float64) * dt
    recorded_q, recorded_v = np.empty((samples, arm.nq)), np.empty((samples, arm.nv))
    recorded_tau, recorded_target = np.empty((samples, arm.nv)), np.empty((3, samples, arm.task_dim))
    status: Status = "finished"
    message, recorded = f"finished at t = {t[-1]:.6g} s", samples
    report_every = max(1, samples // 100)
    controller.reset(q, v, dt)
    for i in range(samples):
        speed = np.abs(v).max()
        if not speed <= DIVERGED_SPEED:
            status, recorded = "diverged", i
            message = f"diverged at t = {t[i]:.6g} s: joint speed {speed:.3g} rad/s, limit {DIVERGED_SPEED:g} rad/s"
            break
        target = trajectory.target(t[i], start)
        try:
            tau = controller.torque(q, v, target)
        except NonFiniteError as error:
            status, message, recorded = "diverged", f"diverged at t = {t[i]:.6g} s: {error}", i
            break
        recorded_q[i], recorded_v[i], recorded_tau[i] = q, v, tau
        recorded_target[:, i] = target.x, target.dx, target.ddx
        q, v = method.step(plant, q, v, tau, dt)
        if progress is not None and (i + 1) % report_every == 0:
            progress((i + 1) / samples)
    if progress is not None:
        progress(1.0)
    return Run(
        t=t[:recorded],
        q=recorded_q[:recorded],
        v=recorded_v[:recorded],
        tau=recorded_tau[:recorded],
        x_desired=recorded_target[0, :recorded],
        dx_desired=recorded_target[1, :recorded],
        ddx_desired=recorded_target[2, :recorded],
        arm=arm,
        info=RunInfo(
            controller=controller.name,
            parameters=controller.parameters,
            trajectory=repr(trajectory),
            dt=dt,
            integrator=method.name,
            status=status,
            message=message,
            versions=versions(),
        ),
    )


def _samples(duration: float, dt: float) -> int:
    if dt > duration:
        raise ParameterError(f"dt must not be longer than the motion of {duration:g} s, got {dt:g} s")
    steps = duration / dt
    if steps >= MAX_SAMPLES:
        raise ParameterError(
            f"dt = {dt:g} s would record {steps:.3g} samples of a {duration:g} s motion; "
            f"at most {MAX_SAMPLES:,} fit: give at least {duration / MAX_SAMPLES:.1g} s"
        )
    return math.floor(steps * (1.0 + 1e-12)) + 1
