"""Limits of the joints as a caller gives them: numbers, those of the robot's file, or none."""

from __future__ import annotations

from typing import Any

import numpy as np

from .checks import read_only, real_array
from .exceptions import ParameterError, ShapeError, shown
from .redundancy import Array

FROM_FILE = "urdf"
"""What stands for the limits of the robot's own description."""

NO_LIMIT = np.inf
"""The limit of a joint that has none."""


def joint_limit(
    name: str, value: Any, size: int | None = None, of_file: Array | None = None, unit: str = "N m"
) -> Array:
    """Return the largest magnitude that each joint may have.

    Args:
        name: What the limit is called in errors.
        value: A number or one a joint, above 0 and infinite for no limit; None for no limit at all; `"urdf"` for those
            of the robot's description.
        size: Number of joints; None if it is not known yet, so that the shape of `value` is kept.
        of_file: The limits of the robot's description, shape (size,), if it can have any.
        unit: Their unit.

    Returns:
        Shape (size,); `NO_LIMIT` where there is none.

    Raises:
        ShapeError: If it is neither a number nor a vector of `size` numbers.
        ParameterError: If a number is not above 0, or the description has no such limit.
    """
    if isinstance(value, str):
        return _of_file(name, value, of_file, "a number, one a joint, 'urdf' or None")
    limit = _numbers(name, NO_LIMIT if value is None else value, size)
    if not np.all(limit > 0.0):
        raise ParameterError(f"{name} must be above 0 {unit}, got {np.array(value).tolist()}")
    return limit


def joint_range(
    name: str, value: Any, size: int, of_file: tuple[Array, Array], unit: str = "rad"
) -> tuple[Array, Array]:
    """Return the lowest and the highest value that each joint may have.

    Args:
        name: What the limit is called in errors.
        value: A pair (lower, upper), each a number or one a joint, infinite for no limit; None for no limit at all;
            `"urdf"` for those of the robot's description.
        size: Number of joints.
        of_file: The limits of the robot's description, shapes (size,).
        unit: Their unit.

    Returns:
        Lower and upper limits, shapes (size,); minus and plus `NO_LIMIT` where there is none.

    Raises:
        ShapeError: If it is no pair, or one of it neither a number nor a vector of `size` numbers.
        ParameterError: If a lower limit is not below the upper, or the description has no such limit.
    """
    if value is None:
        return read_only(np.full(size, -NO_LIMIT)), read_only(np.full(size, NO_LIMIT))
    if isinstance(value, str):
        lower, upper = of_file
        _of_file(name, value, np.where(np.isfinite(lower), lower, upper), "a pair (lower, upper), 'urdf' or None")
        return lower, upper
    try:
        below, above = value
    except (TypeError, ValueError):
        raise ShapeError(f"{name} must be a pair (lower, upper), 'urdf' or None, got {shown(value)}") from None
    lower, upper = _numbers(f"{name}[0]", below, size), _numbers(f"{name}[1]", above, size)
    for i in np.flatnonzero(~(lower < upper)):
        given = f"[{lower[i]:g}, {upper[i]:g}] {unit} for joint {i + 1}"
        raise ParameterError(f"{name} must have each lower limit below the upper, got {given}")
    return lower, upper


def _of_file(name: str, value: str, of_file: Array | None, expected: str) -> Array:
    if value != FROM_FILE or of_file is None:
        raise ParameterError(f"{name} must be {expected}, got {shown(value)}")
    if not np.isfinite(of_file).any():
        raise ParameterError(f"{name} = 'urdf': the robot's description has no such limit; give numbers, or None")
    return of_file


def _numbers(name: str, value: Any, size: int | None) -> Array:
    count = " of numbers" if size is None else f" of {size} numbers"
    numbers = np.atleast_1d(real_array(name, value, f"a number or a vector{count}"))
    if numbers.ndim != 1 or len(numbers) == 0 or (size is not None and len(numbers) not in (1, size)):
        raise ShapeError(f"{name} must be a number or a vector{count}, got shape {numbers.shape}")
    return read_only(np.array(np.broadcast_to(numbers, numbers.shape if size is None else (size,))))
