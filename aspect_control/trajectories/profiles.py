"""How far along its path a motion is at any time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from ..checks import known_name

SAME_INSTANT = 1e-12
"""Times closer than this part of the duration are the same instant: i·dt is rarely exact."""

Progress: TypeAlias = tuple[float, float, float]
"""Distance, speed and acceleration along a motion of unit length and duration."""


@dataclass(frozen=True, slots=True)
class Profile:
    """Distance, speed and acceleration along a motion of unit length and duration, as functions of time.

    Attributes:
        pieces: The functions of time that follow one another.
        breakpoints: Times inside the motion at which the acceleration jumps: from one piece to the next.
    """

    pieces: tuple[Callable[[float], Progress], ...]
    breakpoints: tuple[float, ...] = ()

    def __call__(self, u: float) -> Progress:
        """Return distance, speed and acceleration at the time `u`; outside 0 to 1 the motion stands still.

        At a breakpoint the acceleration is the one that follows; at 1 it is the one that was.
        """
        if u < 0.0:
            if u < -SAME_INSTANT:
                return 0.0, 0.0, 0.0
            u = 0.0
        elif u > 1.0:
            if u > 1.0 + SAME_INSTANT:
                return 1.0, 0.0, 0.0
            u = 1.0
        return self.pieces[bisect_right(self.breakpoints, u + SAME_INSTANT)](u)


def _speeding_up(acceleration: float, u: float) -> Progress:
    return acceleration / 2.0 * u**2, acceleration * u, acceleration


def _braking(deceleration: float, u: float) -> Progress:
    return 1.0 - deceleration / 2.0 * (1.0 - u) ** 2, deceleration * (1.0 - u), -deceleration


def _cruising(speed: float, u: float) -> Progress:
    return 0.5 + speed * (u - 0.5), speed, 0.0


def _at_constant_speed(u: float) -> Progress:
    return u, 1.0, 0.0


def _cubic(u: float) -> Progress:
    return u**2 * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u), 6.0 - 12.0 * u


def _quintic(u: float) -> Progress:
    distance = u**3 * (10.0 + u * (6.0 * u - 15.0))
    return distance, 30.0 * (u * (1.0 - u)) ** 2, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


PROFILES: dict[str, Profile] = {
    "bang-bang": Profile((partial(_speeding_up, 4.0), partial(_braking, 4.0)), breakpoints=(0.5,)),
    "trapezoidal": Profile(
        (partial(_speeding_up, 4.5), partial(_cruising, 1.5), partial(_braking, 4.5)), (1.0 / 3.0, 2.0 / 3.0)
    ),
    "cubic": Profile((_cubic,)),
    "quintic": Profile((_quintic,)),
}
"""The profiles from rest to rest, by name."""

UNIFORM = Profile((_at_constant_speed,))
"""Constant speed: for a path that is a function of time by itself."""


def find_profile(name: str) -> Profile:
    """Return the profile of a name.

    Args:
        name: A name of `PROFILES`.

    Raises:
        UnknownNameError: If there is no such profile.
    """
    return PROFILES[known_name(name, PROFILES, "profile")]
