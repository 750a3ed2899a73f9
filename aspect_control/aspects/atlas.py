"""The atlas: aspects, borders and the minor measure over a slice of an arm's configurations."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm import BORDER_TOLERANCE, Arm
from ..arm.postures import beyond_limits
from ..checks import whole_number
from ..exceptions import ParameterError, shown
from ..redundancy import Array, minor_measure, minors, null_vector
from .slices import Slice
from .stability_map import stability

LARGEST_MEMORY = 2e9
"""The most memory that the minors of an atlas may take, bytes."""

_TIMED_POINTS = 60
"""Points that are computed to tell how long the whole takes."""


@dataclass(frozen=True, eq=False)
class Atlas:
    """The minors over a slice, on the centres of a grid of cells.

    Attributes:
        slice: The slice.
        a: First coordinates, shape (k,), rad.
        b: Second coordinates, shape (l,), rad.
        minors: Minors in the order of `arm.minor_columns`, shape (l, k, p).
        minor_measure: H of Eq. (18), shape (l, k).
        within_limits: Whether all joints are inside their limits, angles counted modulo a turn, shape (l, k).
        stability: c of s̈ = −c ṡ² in the direction of `null_vector`, shape (l, k), 1/rad, for one redundant degree
            of freedom; None for others.
        direction: Unit null vector, shape (l, k, nv), for one redundant degree of freedom; None for others.
    """

    slice: Slice
    a: Array
    b: Array
    minors: Array
    minor_measure: Array
    within_limits: NDArray[np.bool_]
    stability: Array | None
    direction: Array | None

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self.slice.arm

    @cached_property
    def signatures(self) -> tuple[NDArray[np.int8], NDArray[np.intp], NDArray[np.intp]]:
        """The signatures that occur, the most frequent first.

        Their signs, shape (c, p); which one each cell has, shape (l, k); how many cells each has, shape (c,).
        """
        signs = np.sign(self.minors).astype(np.int8)
        found, which, counts = np.unique(
            signs.reshape(-1, signs.shape[-1]), axis=0, return_inverse=True, return_counts=True
        )
        order = np.argsort(-counts, kind="stable")
        rank = np.argsort(order, kind="stable")
        return found[order], rank[which.reshape(signs.shape[:2])], counts[order]

    def agreement(self, positions: Array) -> float:
        """Return for which part of a path all minors have the sign that they have at the nearest place of the slice.

        One where the path lies in the slice, or the other joints change no sign; the lower, the less the slice says
        about the path.

        Args:
            positions: Joint positions along the path, shape (k, nv), rad.
        """
        nearest = np.array([self.slice.posture(*place) for place in self.slice.trace(positions).tolist()])
        return float((self._signs(positions) == self._signs(nearest)).all(axis=1).mean())

    def start_signs(self) -> NDArray[np.int8]:
        """Return the sign of each minor at the posture that the slice is laid through, −1, 0 or 1, shape (p,)."""
        signs: NDArray[np.int8] = self._signs(self.slice.start[np.newaxis])[0]
        return signs

    def _signs(self, positions: Array) -> NDArray[np.int8]:
        jacobians = np.array([self.arm.jacobian(self.arm.configuration(each)) for each in positions])
        values = minors(jacobians, self.arm.minor_columns)
        clear = np.abs(values) > BORDER_TOLERANCE * self.arm.minor_scales
        return np.where(clear, np.sign(values), 0.0).astype(np.int8)

    def to_dict(self) -> dict[str, Any]:
        """Return what the atlas comes to as plain numbers and strings, for JSON."""
        found, _, counts = self.signatures
        return {
            "axes": [axis.name for axis in (self.slice.horizontal, self.slice.vertical)],
            "resolution": [len(self.a), len(self.b)],
            "signatures": [
                {"signs": signs.tolist(), "share": float(count / counts.sum())}
                for signs, count in zip(found, counts, strict=True)
            ],
            "largest_minor_measure": float(self.minor_measure.max()),
        }


def compute_atlas(slice_: Slice, resolution: int, progress: Callable[[float], None] | None = None) -> Atlas:
    """Compute the minors, the minor measure and, with one redundant degree of freedom, c over a slice.

    Args:
        slice_: The slice.
        resolution: Number of cells along each side.
        progress: Called with the part that is done, 0 to 1, a row at a time.

    Raises:
        ParameterError: If `resolution` is no whole number from 2 on, or the minors would not fit into memory.
        TooManyMinorsError: If the Jacobian has more minors than can be handled.
    """
    arm = slice_.arm
    _require_fits(arm, resolution)
    a, b = slice_.horizontal.centres(resolution), slice_.vertical.centres(resolution)
    shape = resolution, resolution
    values, measure = np.empty((*shape, len(arm.minor_columns))), np.empty(shape)
    inside = np.empty(shape, dtype=np.bool_)
    single = arm.redundancy == 1
    c, z = np.full(shape, np.nan), np.full((*shape, arm.nv), np.nan)
    for row, vertical in enumerate(b):
        postures = np.array([slice_.posture(float(horizontal), float(vertical)) for horizontal in a])
        configurations = [arm.configuration(each) for each in postures]
        jacobians = np.array([arm.jacobian(q) for q in configurations])
        values[row] = minors(jacobians, arm.minor_columns)
        measure[row] = minor_measure(jacobians, arm.minor_columns)
        inside[row] = np.all(beyond_limits(arm, postures) <= 0.0, axis=1)
        if single:
            c[row] = [stability(arm, q) for q in configurations]
            z[row] = null_vector(jacobians)
        if progress is not None:
            progress((row + 1) / resolution)
    return Atlas(slice_, a, b, values, measure, inside, c if single else None, z if single else None)


def estimated_time(slice_: Slice, resolution: int) -> float:
    """Return how long `compute_atlas` is going to take, s, from timing a few points.

    Args:
        slice_: The slice.
        resolution: Number of cells along each side.

    Raises:
        ParameterError: As `compute_atlas` does.
    """
    arm = slice_.arm
    _require_fits(arm, resolution)
    arm.minor_columns.shape  # noqa: B018 - found once, when they are first needed
    started = time.perf_counter()
    for a, b in zip(slice_.horizontal.centres(_TIMED_POINTS), slice_.vertical.centres(_TIMED_POINTS), strict=True):
        q = arm.configuration(slice_.posture(float(a), float(b)))
        J = arm.jacobian(q)
        minors(J, arm.minor_columns)
        if arm.redundancy == 1:
            stability(arm, q)
    return (time.perf_counter() - started) / _TIMED_POINTS * resolution**2


def _require_fits(arm: Arm, resolution: int) -> None:
    whole_number("resolution", resolution, 2)
    numbers = len(arm.minor_columns) + 2 + (arm.nv if arm.redundancy == 1 else 0)
    most = int(np.sqrt(LARGEST_MEMORY / (8 * numbers)))
    if resolution > most:
        raise ParameterError(
            f"a resolution of {shown(resolution)} does not fit into memory: {len(arm.minor_columns)} minors at "
            f"each point; at most {most} cells a side are computed"
        )
