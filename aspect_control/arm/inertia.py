"""Which masses and rotational inertias a body can have."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..exceptions import ModelError
from ..redundancy import Array

_ROUNDING = 1e-9
"""Part of the largest principal moment by which rounding may break the triangle inequality."""

_SMALLEST_RADIUS = 1e-6
"""Radius of gyration up to which a moment of inertia counts as zero, m."""


def require_possible(name: str, mass: float, inertia: Array) -> None:
    """Make sure that some distribution of mass has this mass and this rotational inertia.

    No principal moment is negative, and none is larger than the sum of the other two.

    Args:
        name: What the body is called in the error.
        mass: Its mass, kg.
        inertia: Its rotational inertia about its centre of mass, shape (3, 3), kg m².

    Raises:
        ModelError: If it is not so; the message has the numbers.
    """
    if not (np.isfinite(mass) and np.isfinite(inertia).all()):
        raise ModelError(f"{name} has a mass or an inertia that is not finite: {mass} kg, {inertia.tolist()} kg m²")
    if mass < 0.0:
        raise ModelError(f"{name} has a negative mass of {mass:.6g} kg")
    scale = float(np.abs(inertia).max())
    if scale == 0.0:
        return
    if not np.allclose(inertia, inertia.T, rtol=0.0, atol=_ROUNDING * scale):
        raise ModelError(f"{name} has an inertia that is not symmetric: {inertia.tolist()} kg m²")
    moments = np.linalg.eigvalsh(inertia / scale)
    allowed = _ROUNDING + mass * _SMALLEST_RADIUS**2 / scale
    listed = ", ".join(f"{moment * scale:.6g}" for moment in moments)
    if moments[0] < -allowed:
        raise ModelError(f"{name} has a negative principal moment of inertia: {listed} kg m²")
    if moments[2] - moments[0] - moments[1] > allowed:
        raise ModelError(
            f"{name} has principal moments of inertia that break the triangle inequality, the largest is more than "
            f"the sum of the others: {listed} kg m²"
        )


def require_possible_bodies(model: Any, joints: Iterable[int]) -> None:
    """Make sure that what each of some joints moves, with all that is fixed to it, has a possible inertia.

    Args:
        model: A `pin.Model`.
        joints: Indices of the joints.

    Raises:
        ModelError: If a body has not; the message names the joint that moves it.
    """
    for joint in joints:
        body = model.inertias[joint]
        require_possible(f"what joint {model.names[joint]!r} of {model.name!r} moves", body.mass, body.inertia)
