"""What a tick of the quadratic program computes before it knows whether a solver is needed, in compiled text.

All functions keep Q, c, d and the bounds of Q η + s c in a buffer, that of `Torques.in_buffer`, which takes less time
than to hand them out.
"""

from __future__ import annotations

import numpy as np

from ..redundancy import Array
from ..redundancy.compiled import MATRIX, VECTOR, compiled
from ..redundancy.feedback import TASK_SPACE, commanded_acceleration, require_finite
from ..redundancy.open_torques import open_torque, open_torques
from ..redundancy.quadratic_program import minimum_known
from .qp_program import no_torque_keeps_the_task, scale_of, task_scaled


@compiled(MATRIX, VECTOR, VECTOR, VECTOR, VECTOR)
def _keep(Q: Array, c: Array, d: Array, torque_limit: Array, buffer: Array) -> None:
    n, r = Q.shape
    buffer[: n * r] = Q.reshape(-1)
    rest = buffer[n * r :].reshape(4, n)
    rest[0], rest[1], rest[2], rest[3] = c, d, -torque_limit - d, torque_limit - d


@compiled(*TASK_SPACE)
def _open_torques(
    M: Array, nle: Array, J: Array, drift: Array, x: Array, v: Array, desired: Array, gains: Array
) -> tuple[Array, Array, Array]:
    """Return Q, c and d of the commanded task acceleration; refuse what is not finite."""
    Q, c, d = open_torques(M, nle, J, commanded_acceleration(J, drift, x, v, desired, gains))
    require_finite(c + d)
    return Q, c, d


@compiled(*TASK_SPACE, VECTOR, VECTOR)
def torques_and_bounds(
    M: Array,
    nle: Array,
    J: Array,
    drift: Array,
    x: Array,
    v: Array,
    desired: Array,
    gains: Array,
    torque_limit: Array,
    buffer: Array,
) -> None:
    """Fill the buffer; refuse what is not finite."""
    Q, c, d = _open_torques(M, nle, J, drift, x, v, desired, gains)
    _keep(Q, c, d, torque_limit, buffer)


@compiled(*TASK_SPACE, VECTOR, VECTOR, VECTOR)
def torque_as_before(
    M: Array,
    nle: Array,
    J: Array,
    drift: Array,
    x: Array,
    v: Array,
    desired: Array,
    gains: Array,
    torque_limit: Array,
    buffer: Array,
    multipliers: Array,
) -> tuple[bool, bool, Array]:
    """Return whether no limit, or those of some multipliers, give the least torque; whether any does; the torque.

    If not, the buffer is filled.
    """
    Q, c, d = _open_torques(M, nle, J, drift, x, v, desired, gains)
    r, least = Q.shape[1], c + d
    known, eta, mu = minimum_known(np.ones(r), np.zeros(r), Q, -torque_limit - least, torque_limit - least, multipliers)
    if known:
        return True, bool(np.any(mu)), open_torque(Q, c, d, eta, 1.0, torque_limit)
    _keep(Q, c, d, torque_limit, buffer)
    return False, False, least


@compiled(*TASK_SPACE, VECTOR, VECTOR, VECTOR)
def scaled_as_before(
    M: Array,
    nle: Array,
    J: Array,
    drift: Array,
    x: Array,
    v: Array,
    desired: Array,
    gains: Array,
    torque_limit: Array,
    buffer: Array,
    multipliers: Array,
) -> tuple[bool, float, Array]:
    """Return whether the limits of some multipliers scale the task back; its part s that is kept; the least torque.

    If not, the buffer is filled.
    """
    Q, c, d = _open_torques(M, nle, J, drift, x, v, desired, gains)
    r = Q.shape[1]
    p, q, A, lower, upper = task_scaled(Q, c, -torque_limit - d, torque_limit - d)
    known, solution, _ = minimum_known(p, q, A, lower, upper, multipliers)
    if known and no_torque_keeps_the_task(q, upper, solution, torque_limit):
        s = scale_of(c, float(solution[r]))
        return True, s, open_torque(Q, c, d, solution[:r], s, torque_limit)
    _keep(Q, c, d, torque_limit, buffer)
    return False, 1.0, d
