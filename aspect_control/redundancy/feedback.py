"""What feedback asks for in task space."""

from __future__ import annotations

from .array import Matrix, Vector
from .kernels import kernel


@kernel
def commanded_acceleration(
    J: Matrix, drift: Vector, v: Vector, error: Vector, dx: Vector, ddx: Vector, kp: Matrix, kv: Matrix
) -> Vector:
    """Return b = ẍ_d + K_v(ẋ_d − Jθ̇) + K_p e − J̇θ̇ of Eq. (5).

    Args:
        J: Jacobian, shape (m, n).
        drift: J̇θ̇, shape (m,), m/s² and rad/s².
        v: Joint velocity θ̇, shape (n,), rad/s.
        error: Task error e = x_d − x, shape (m,), m and rad; its rotation rows are a rotation vector.
        dx: Desired task velocity ẋ_d, shape (m,), m/s and rad/s.
        ddx: Desired task acceleration ẍ_d, shape (m,), m/s² and rad/s².
        kp: Position gain K_p, shape (m, m), 1/s².
        kv: Velocity gain K_v, shape (m, m), 1/s.

    Returns:
        b, shape (m,), m/s² and rad/s².
    """
    return ddx + kv @ (dx - J @ v) + kp @ error - drift
