"""What a curve of postures passes: borders of aspects, the aspects between them, joint limits."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arm import BORDER_TOLERANCE, Arm
from ..arm.postures import beyond_limits, jacobian
from ..redundancy import Array, minors

_COINCIDENCE = 1e-8
"""Arc length within which sign changes of several minors count as one border, rad."""


class BorderCrossing(NamedTuple):
    """A place where a minor changes sign.

    Attributes:
        s: Arc length, rad.
        minor: Which one, counted from 1 in the order of `arm.minor_columns`.
    """

    s: float
    minor: int


class LimitCrossing(NamedTuple):
    """A place where a joint meets one of its limits.

    Attributes:
        s: Arc length, rad.
        joint: Name of the joint.
        leaving: Whether the joint leaves its range in the direction of growing s.
    """

    s: float
    joint: str
    leaving: bool


class AspectInterval(NamedTuple):
    """A stretch of the curve inside one aspect.

    Attributes:
        start: Arc length at its beginning, rad.
        end: Arc length at its end, rad; on a closed curve the stretch that holds the seam ends beyond the last sample.
        signature: Sign of each minor, −1, 0 or 1, shape (p,).
    """

    start: float
    end: float
    signature: tuple[int, ...]


def border_crossings(
    arm: Arm, curve: Callable[[float], Array], s: Array, positions: Array, closed: bool
) -> tuple[BorderCrossing, ...]:
    """Return where minors change sign; a minor that is zero throughout has none.

    Args:
        arm: The arm.
        curve: Joint positions, shape (nv,), rad, as a function of the arc length.
        s: Arc lengths of the samples, shape (k,), rad.
        positions: Joint positions of the samples, shape (k, nv), rad.
        closed: Whether the curve is closed; its last sample is then its first.
    """

    def minor(index: int) -> Callable[[float], float]:
        return lambda arc: float(minors(jacobian(arm, curve(arc)), arm.minor_columns[[index]])[0])

    values = minors(np.array([jacobian(arm, each) for each in positions]), arm.minor_columns)
    found = []
    for index, column in enumerate(values.T):
        signed = np.flatnonzero(np.abs(column) > BORDER_TOLERANCE * arm.minor_scales[index])
        arcs = [(s[a], s[b]) for a, b in pairwise(signed) if column[a] * column[b] < 0.0]
        if closed and len(signed) and column[signed[-1]] * column[signed[0]] < 0.0:
            # The seam lies on the border.
            arcs.append((s[signed[-1]], s[signed[0]] + s[-1]))
        arcs += _dips(minor(index), s, column)
        for low, high in arcs:
            crossing = _root(minor(index), low, high)
            # What lies on the seam to rounding lies at its beginning.
            beyond_seam = closed and crossing > s[-1] - _COINCIDENCE
            place = max(crossing - s[-1], 0.0) if beyond_seam else crossing
            found.append(BorderCrossing(float(place), index + 1))
    return tuple(sorted(found))


def _dips(function: Callable[[float], float], s: Array, values: Array) -> list[tuple[float, float]]:
    """Return brackets of two sign changes that lie between the same samples, where a minor dips through zero."""
    from scipy.optimize import minimize_scalar

    brackets = []
    sizes, sign = np.abs(values), np.sign(values)
    inner = np.arange(1, len(s) - 1)
    lowest = (sizes[inner] <= sizes[inner - 1]) & (sizes[inner] < sizes[inner + 1])
    # A parabola through three samples of one sign can only reach zero if it falls by more than it has left.
    deep = sizes[inner] < (sizes[inner - 1] - sizes[inner]) + (sizes[inner + 1] - sizes[inner])
    same = (sign[inner] == sign[inner - 1]) & (sign[inner] == sign[inner + 1]) & (sign[inner] != 0.0)
    for i in inner[lowest & deep & same]:
        low, high = s[i - 1], s[i + 1]
        bottom = minimize_scalar(lambda arc, i=i: sign[i] * function(arc), bounds=(low, high), method="bounded").x
        if sign[i] * function(bottom) < 0.0:
            brackets += [(low, bottom), (bottom, high)]
    return brackets


def aspect_intervals(
    arm: Arm, curve: Callable[[float], Array], s: Array, crossings: tuple[BorderCrossing, ...], closed: bool
) -> tuple[AspectInterval, ...]:
    """Return the stretches between the places where minors change sign.

    Args:
        arm: The arm.
        curve: Joint positions, shape (nv,), rad, as a function of the arc length.
        s: Arc lengths of the samples, shape (k,), rad.
        crossings: Where minors change sign, by arc length.
        closed: Whether the curve is closed.
    """
    places = _distinct([each.s for each in crossings])
    edges = [s[0], *places, s[-1]]
    if closed and places:
        edges = [*places, places[0] + s[-1]]
    intervals: list[AspectInterval] = []
    for start, end in pairwise(edges):
        values = minors(jacobian(arm, curve((start + end) / 2.0)), arm.minor_columns)
        signs = np.where(np.abs(values) <= BORDER_TOLERANCE * arm.minor_scales, 0.0, np.sign(values))
        intervals.append(AspectInterval(float(start), float(end), tuple(signs.astype(int).tolist())))
    return tuple(intervals)


def limit_crossings(arm: Arm, curve: Callable[[float], Array], s: Array, positions: Array) -> tuple[LimitCrossing, ...]:
    """Return where joints meet their limits, angles counted modulo a turn.

    Args:
        arm: The arm.
        curve: Joint positions, shape (nv,), rad, as a function of the arc length.
        s: Arc lengths of the samples, shape (k,), rad.
        positions: Joint positions of the samples, shape (k, nv), rad.
    """

    def beyond(joint: int) -> Callable[[float], float]:
        return lambda arc: float(beyond_limits(arm, curve(arc))[joint])

    excess = beyond_limits(arm, positions)
    found = []
    for sample, joint in zip(*np.nonzero(np.diff(excess > 0.0, axis=0)), strict=True):
        arc = _root(beyond(joint), s[sample], s[sample + 1])
        found.append(LimitCrossing(arc, arm.joint_names[joint], bool(excess[sample + 1, joint] > 0.0)))
    return tuple(sorted(found))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=1e-13))


def _distinct(places: list[float]) -> list[float]:
    """Return sorted places without those where several minors vanish at once, but for the first."""
    return [place for i, place in enumerate(places) if i == 0 or place - places[i - 1] > _COINCIDENCE]
