"""What feedback asks for in task space, and the laws that are made of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from .array import Array
from .compiled import MATRIX, STACK, VECTOR, F, compiled
from .products import times

TASK_SPACE = (MATRIX, VECTOR, MATRIX, VECTOR, VECTOR, VECTOR, MATRIX, STACK)
"""Arguments of a task-space law: M, N, then those of `commanded_acceleration`."""


@compiled(*TASK_SPACE[2:])
def commanded_acceleration(J: Array, drift: Array, x: Array, v: Array, desired: Array, gains: Array) -> Array:
    """Return b = ẍ_d + K_v(ẋ_d − Jθ̇) + K_p(x_d − x) − J̇θ̇ of Eq. (5).

    Args:
        J: Jacobian, shape (m, n).
        drift: J̇θ̇, shape (m,), m/s² and rad/s².
        x: Task value, shape (m,), m; for a task with rotations the displacement from the target, m and rad.
        v: Joint velocity θ̇, shape (n,), rad/s.
        desired: x_d, ẋ_d and ẍ_d, shape (3, m); for a task with rotations x_d is zero.
        gains: K_p, 1/s², and K_v, 1/s, shape (2, m, m).

    Returns:
        b, shape (m,), m/s² and rad/s².

    Raises:
        ValueError: If the shapes do not fit.
    """
    m = len(J)
    if not (desired.shape == (3, m) and len(x) == len(drift) == m):
        raise ValueError("the target and the task have different numbers of coordinates")
    x_d, dx_d, ddx_d = desired[0], desired[1], desired[2]
    kp, kv = gains[0], gains[1]
    dx, b = times(J, v), ddx_d - drift
    for i in range(m):
        for j in range(m):
            b[i] += kv[i, j] * (dx_d[j] - dx[j]) + kp[i, j] * (x_d[j] - x[j])
    return b


def task_space_law(*parameter: str) -> Callable[[F], F]:
    """Make a law of (M, N, J, b, θ̇), or of these and a parameter, one compiled function of `TASK_SPACE` and it.

    Its b is that of `commanded_acceleration`. Of J only the m first rows count. Its torque is written to the last
    argument but for the parameter, shape (n,), which takes less time than an array that is handed out; one that is not
    finite is refused before.

    Args:
        *parameter: Type of the parameter, as for `compiled`, if there is one.
    """

    def decorate(law: F) -> F:
        torque = compiled(MATRIX, VECTOR, MATRIX, VECTOR, VECTOR, *parameter)(law)

        # Numba compiles no *parameters for types that are given beforehand.
        def plain(M, nle, J, drift, x, v, desired, gains, tau):  # type: ignore[no-untyped-def]
            J = J[: len(drift)]
            b = commanded_acceleration(J, drift, x, v, desired, gains)
            tau[:] = require_finite(torque(M, nle, J, b, v))

        def with_parameter(M, nle, J, drift, x, v, desired, gains, tau, parameter):  # type: ignore[no-untyped-def]
            J = J[: len(drift)]
            b = commanded_acceleration(J, drift, x, v, desired, gains)
            tau[:] = require_finite(torque(M, nle, J, b, v, parameter))

        return compiled(*TASK_SPACE, VECTOR, *parameter)(cast(F, with_parameter if parameter else plain))

    return decorate


@compiled(VECTOR)
def require_finite(vector: Array) -> Array:
    """Return a vector, shape (any,), if it is finite.

    Raises:
        FloatingPointError: If it is not.
    """
    for entry in vector:
        if not np.isfinite(entry):
            raise FloatingPointError("not finite")
    return vector
