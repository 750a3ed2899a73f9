"""Limits of the joints, as bounds of the joint acceleration at one state."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm import Arm
from ...checks import restore_read_only
from ...limits import joint_limit, joint_range
from ...redundancy import Array


class JointLimits:
    """The limits of one arm: |τ| ≤ τ_max, |θ̇| ≤ θ̇_max, θ_min ≤ θ ≤ θ_max, |θ̈| ≤ θ̈_max; infinite where there is none.

    Attributes:
        torque: τ_max, shape (n,), N m.
        speed: θ̇_max, shape (n,), rad/s.
        lower: θ_min, shape (n,), rad.
        upper: θ_max, shape (n,), rad.
        acceleration: θ̈_max, shape (n,), rad/s².
        bound_acceleration: Whether any of the last four is finite.
        parameters: What was given, as plain numbers, strings and lists.
    """

    def __init__(self, arm: Arm, torque: Any, speed: Any, position: Any, acceleration: Any) -> None:
        """Read the limits; see `QPTorque` for what may be given and for the errors."""
        n = arm.nv
        self.torque = joint_limit("torque_limit", torque, n, arm.torque_limit)
        self.speed = joint_limit("speed_limit", speed, n, arm.velocity_limit, "rad/s")
        self.lower, self.upper = joint_range("position_limit", position, n, arm.position_limits)
        self.acceleration = joint_limit("acceleration_limit", acceleration, n, unit="rad/s²")
        self.bound_acceleration = bool(np.isfinite((self.speed, self.lower, self.upper, self.acceleration)).any())
        self.parameters = {
            "torque_limit": _plain(torque),
            "speed_limit": _plain(speed),
            "position_limit": position if position is None or isinstance(position, str) else [*map(_plain, position)],
            "acceleration_limit": _plain(acceleration),
        }

    __setstate__ = restore_read_only

    def acceleration_interval(self, position: Array, v: Array, horizon: float, dt: float) -> tuple[Array, Array]:
        """Return the joint accelerations that keep the speed, the position and the acceleration within their limits.

        position:      (θ_min − θ)/T² − 2θ̇/T ≤ θ̈ ≤ (θ_max − θ)/T² − 2θ̇/T
        speed:         (−θ̇_max − θ̇)/Δt ≤ θ̈ ≤ (θ̇_max − θ̇)/Δt
        acceleration:  −θ̈_max ≤ θ̈ ≤ θ̈_max

        The first lets a joint come as near to its limit as a critically damped motion of time constant T does, which
        does not overshoot; a joint beyond the limit comes back by the same rule. A joint beyond its speed limit slows
        down within T instead of Δt. Where the intervals have nothing in common, the acceleration limit comes before
        the speed limit, and that before the position limit: what is later is moved into what is earlier.

        Args:
            position: Joint positions θ, shape (n,), rad.
            v: Joint velocity θ̇, shape (n,), rad/s.
            horizon: T, s.
            dt: Δt, s.

        Returns:
            Lower and upper bounds of θ̈, shapes (n,), rad/s²; lower ≤ upper, infinite where nothing bounds it.
        """
        below, above, largest = -self.speed - v, self.speed - v, self.acceleration
        slowest = np.clip(below / np.where(below <= 0.0, dt, horizon), -largest, largest)
        fastest = np.clip(above / np.where(above >= 0.0, dt, horizon), -largest, largest)
        leftmost, rightmost = ((end - position) / horizon**2 - 2.0 * v / horizon for end in (self.lower, self.upper))
        return np.clip(leftmost, slowest, fastest), np.clip(rightmost, slowest, fastest)


def _plain(given: Any) -> Any:
    return given if given is None or isinstance(given, str) else np.array(given, dtype=np.float64).tolist()
