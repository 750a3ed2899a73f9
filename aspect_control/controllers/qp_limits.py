"""Limits of the joints, as a caller gives them and as bounds of the joint acceleration at one state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import finite_vector
from ..exceptions import ParameterError, ShapeError
from ..redundancy import Array

FROM_URDF = "urdf"
"""What stands for the limits of the robot's description."""


class JointLimits:
    """The limits of one arm: |τ| ≤ τ_max, |θ̇| ≤ θ̇_max, θ_min ≤ θ ≤ θ_max, |θ̈| ≤ θ̈_max.

    Attributes:
        torque: τ_max, shape (n,), N m; None without a torque limit. Infinite where the URDF has none.
        speed: θ̇_max, shape (n,), rad/s; infinite where there is none.
        lower: θ_min, shape (n,), rad; minus infinity where there is none.
        upper: θ_max, shape (n,), rad; infinite where there is none.
        acceleration: θ̈_max, shape (n,), rad/s²; infinite where there is none.
        bound_acceleration: Whether any of the last four is given.
        parameters: What was given, as plain numbers, strings and lists.
    """

    def __init__(
        self,
        arm: Arm,
        torque_limit: ArrayLike | str | None,
        speed_limit: ArrayLike | str | None,
        position_limit: Any,
        acceleration_limit: ArrayLike | str | None,
    ) -> None:
        """Read the limits.

        Args:
            arm: The arm.
            torque_limit: None, `"urdf"`, a number or one a joint, N m.
            speed_limit: None, `"urdf"`, a number or one a joint, rad/s.
            position_limit: None, `"urdf"`, or a pair (lower, upper), each a number or one a joint, rad.
            acceleration_limit: None, a number or one a joint, rad/s²; a URDF has no such limit.

        Raises:
            ParameterError: If a limit is not above zero, a lower limit not below the upper, or the URDF has none.
            NonFiniteError: If a limit is NaN or infinite: None stands for no limit.
            ShapeError: If a limit has the wrong shape.
        """
        unlimited = np.full(arm.nv, np.inf)
        torque = _magnitude("torque_limit", torque_limit, arm.torque_limit, arm, "N m")
        speed = _magnitude("speed_limit", speed_limit, arm.velocity_limit, arm, "rad/s")
        acceleration = _magnitude("acceleration_limit", acceleration_limit, unlimited, arm, "rad/s²")
        interval = _interval(position_limit, arm)
        self.torque = torque
        self.speed = unlimited if speed is None else speed
        self.acceleration = unlimited if acceleration is None else acceleration
        self.lower: Array = -unlimited if interval is None else interval[0]
        self.upper: Array = unlimited if interval is None else interval[1]
        self.bound_acceleration = any(limit is not None for limit in (speed, interval, acceleration))
        self.parameters = {
            "torque_limit": _plain(torque_limit, torque),
            "speed_limit": _plain(speed_limit, speed),
            "position_limit": _plain(position_limit, interval),
            "acceleration_limit": _plain(acceleration_limit, acceleration),
        }

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
        room_below, room_above = -self.speed - v, self.speed - v
        slowest = np.where(room_below <= 0.0, room_below / dt, room_below / horizon)
        fastest = np.where(room_above >= 0.0, room_above / dt, room_above / horizon)
        lower, upper = _moved_into((slowest, fastest), (-self.acceleration, self.acceleration))
        damping = 2.0 * v / horizon
        leftmost = (self.lower - position) / horizon**2 - damping
        rightmost = (self.upper - position) / horizon**2 - damping
        return _moved_into((leftmost, rightmost), (lower, upper))

    def largest_part(self, push: Array, gravity: Array) -> Array:
        """Return G + λ M θ̈ with the largest λ in [0, 1] that the torque limits allow.

        Whatever λ, θ̈ = −θ̇/T takes the power λ θ̇ᵀM θ̇/T out of the arm.

        Args:
            push: M θ̈, shape (n,), N m.
            gravity: Gravity torques G, shape (n,), N m.

        Returns:
            Shape (n,), N m; beyond the limit of a joint whose gravity torque is.
        """
        if self.torque is None:
            return gravity + push
        room = np.maximum(self.torque - np.sign(push) * gravity, 0.0)
        moving = push != 0.0
        part = min(1.0, float((room[moving] / np.abs(push[moving])).min(initial=1.0)))
        return gravity + part * push


def _moved_into(interval: tuple[Array, Array], bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    return np.clip(interval[0], *bounds), np.clip(interval[1], *bounds)


def _magnitude(name: str, value: Any, of_urdf: Array, arm: Arm, unit: str) -> Array | None:
    if value is None:
        return None
    if isinstance(value, str):
        _require_urdf(name, value, "a number, one a joint, 'urdf' or None")
        if not np.isfinite(of_urdf).any():
            raise ParameterError(
                f"{name} = 'urdf': the description of {arm.name!r} has no such limit; give numbers in {unit}, or None"
            )
        return of_urdf
    limit = _per_joint(name, value, arm.nv)
    if not np.all(limit > 0.0):
        raise ParameterError(f"{name} must be above 0 {unit}, got {np.array(value).tolist()}")
    return limit


def _interval(value: Any, arm: Arm) -> tuple[Array, Array] | None:
    if value is None:
        return None
    if isinstance(value, str):
        _require_urdf("position_limit", value, "a pair (lower, upper), 'urdf' or None")
        lower, upper = arm.position_limits
        if not (np.isfinite(lower) | np.isfinite(upper)).any():
            raise ParameterError(
                f"position_limit = 'urdf': the description of {arm.name!r} has no such limit; "
                "give a pair (lower, upper) in rad, or None"
            )
        return lower, upper
    try:
        below, above = value
    except (TypeError, ValueError):
        raise ShapeError(f"position_limit must be a pair (lower, upper), 'urdf' or None, got {value!r}") from None
    lower = _per_joint("position_limit[0]", below, arm.nv)
    upper = _per_joint("position_limit[1]", above, arm.nv)
    for i in np.flatnonzero(lower >= upper):
        raise ParameterError(
            f"position_limit must have each lower limit below the upper, got [{lower[i]:g}, {upper[i]:g}] "
            f"for joint {arm.joint_names[i]!r}"
        )
    return lower, upper


def _per_joint(name: str, value: Any, size: int) -> Array:
    if isinstance(value, bool) or value is None:
        raise ParameterError(f"{name} must be a number or {size} numbers, got {value!r}")
    vector = finite_vector(name, [value] * size if np.ndim(value) == 0 else value, size)
    return vector


def _require_urdf(name: str, value: str, expected: str) -> None:
    if value != FROM_URDF:
        raise ParameterError(f"{name} must be {expected}, got {value!r}")


def _plain(given: Any, limit: Array | tuple[Array, Array] | None) -> Any:
    if limit is None or isinstance(given, str):
        return given
    if isinstance(limit, tuple):
        return [_plain(given[0], limit[0]), _plain(given[1], limit[1])]
    return float(limit[0]) if np.ndim(given) == 0 else [float(entry) for entry in limit]
