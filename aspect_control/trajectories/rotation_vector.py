"""From a rotation vector that changes with time to the angular velocity and acceleration."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ..redundancy import Array

_SMALLEST = 1e-30
"""Half angles below are taken for this one: all that is made of them is the same, and none divides by zero."""


def angular_motion(phi: Array, dphi: Array, ddphi: Array) -> tuple[Array, Array]:
    """Return the angular velocity and acceleration of the orientation exp(φ(t)), both in the world frame.

    With h = φ/2 and x = |h| the unit quaternion is (cos x, j₀(x)·h). The spherical Bessel functions j_n give every
    derivative, as dj_n(x)/xⁿ = −j_{n+1}(x)/xⁿ⁺¹ · x·dx, and keep their precision at small angles, where closed forms
    of the derivative of the exponential's Jacobian (`pinocchio.Jexp6` among them) lose it.

    Args:
        phi: Rotation vector φ, shape (3,), rad, of any length.
        dphi: Its derivative, shape (3,), rad/s.
        ddphi: Its second derivative, shape (3,), rad/s².

    Returns:
        Angular velocity, shape (3,), rad/s, and angular acceleration, shape (3,), rad/s².
    """
    from scipy.special import spherical_jn

    h, dh, ddh = phi / 2.0, dphi / 2.0, ddphi / 2.0
    x = max(float(np.linalg.norm(h)), _SMALLEST)
    orders = np.arange(3)
    f0, f1, f2 = spherical_jn(orders, x) / x**orders
    # p = x·dx is half the derivative of x²; dp is its own derivative.
    p, dp = h @ dh, dh @ dh + h @ ddh
    df0, ddf0 = -f1 * p, f2 * p**2 - f1 * dp
    conjugate = pin.Quaternion(np.append(-f0 * h, np.cos(x)))
    dq = np.append(df0 * h + f0 * dh, -f0 * p)
    ddq = np.append(ddf0 * h + 2.0 * df0 * dh + f0 * ddh, f1 * p**2 - f0 * dp)
    # The other part of d(2·q̇·q̄) is 2·|q̇|², which is real.
    return 2.0 * (pin.Quaternion(dq) * conjugate).vec(), 2.0 * (pin.Quaternion(ddq) * conjugate).vec()
