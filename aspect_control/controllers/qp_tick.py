"""What a tick of the quadratic program computes before it knows whether a solver is needed, in compiled text."""

from __future__ import annotations

import numpy as np

from ..redundancy import Array
from ..redundancy.compiled import VECTOR, compiled
from ..redundancy.feedback import TASK_SPACE, commanded_acceleration, require_finite
from ..redundancy.open_torques import open_torque, open_torques
from ..redundancy.quadratic_program import minimum_known


@compiled(*TASK_SPACE, VECTOR)
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
) -> tuple[Array, Array, Array, Array, Array]:
    """Return Q, c, d and the bounds of Q η + s c; refuse what is not finite."""
    b = commanded_acceleration(J, drift, x, v, desired, gains)
    Q, c, d = open_torques(M, nle, J, b)
    require_finite(c + d)
    return Q, c, d, -torque_limit - d, torque_limit - d


@compiled(*TASK_SPACE, VECTOR, VECTOR)
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
    multipliers: Array,
) -> tuple[bool, bool, Array]:
    """Return whether no limit, or those of some multipliers, give the least torque; whether any does; the torque."""
    b = commanded_acceleration(J, drift, x, v, desired, gains)
    Q, c, d = open_torques(M, nle, J, b)
    r, least = Q.shape[1], c + d
    known, eta, mu = minimum_known(np.ones(r), np.zeros(r), Q, -torque_limit - least, torque_limit - least, multipliers)
    return known, bool(np.any(mu)), open_torque(Q, c, d, eta, 1.0, torque_limit) if known else least
