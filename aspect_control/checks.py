"""Checks of what a caller hands in, each with one clear error."""

from __future__ import annotations

import math
from math import isfinite
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .exceptions import NonFiniteError, ParameterError, ShapeError
from .redundancy import Array

_FLOAT = np.dtype(np.float64)


def finite_vector(name: str, value: ArrayLike, size: int | None = None) -> Array:
    """Return a copy of `value` as a vector of finite floats.

    Args:
        name: What the value is called in the error.
        value: Anything NumPy reads as a vector.
        size: The number of entries expected; None for any number.

    Returns:
        The vector, of shape (size,).

    Raises:
        ShapeError: If it is not a vector of `size` numbers.
        NonFiniteError: If an entry is NaN or infinite.
    """
    if type(value) is np.ndarray and value.dtype is _FLOAT and value.ndim == 1 and size in (None, len(value)):
        copy: Array = value.copy()
        if isfinite(sum(copy.tolist())):
            return copy  # the usual case, without NumPy's checks, which take several times as long
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"{name} must be a vector of numbers, got {value!r}") from None
    if vector.ndim != 1 or (size is not None and vector.shape[0] != size):
        expected = f"({size},)" if size is not None else "(any,)"
        raise ShapeError(f"{name} must have shape {expected}, got {vector.shape}")
    if not np.isfinite(vector).all():
        raise NonFiniteError(f"{name} must be finite, got {vector.tolist()}")
    return vector


def finite_number(name: str, value: Any) -> float:
    """Return `value` as a finite float of either sign.

    Args:
        name: What the value is called in the error.
        value: A number.

    Raises:
        ParameterError: If it is not a finite number.
    """
    if type(value) is float and isfinite(value):
        return value
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise ParameterError(f"{name} must be a finite number, got {value!r}")
    return float(value)


def positive(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float above zero.

    Args:
        name: What the value is called in the error.
        value: A number.
        unit: Its unit, for the error.

    Raises:
        ParameterError: If it is not a finite number above zero.
    """
    number = _number(name, value)
    if not (math.isfinite(number) and number > 0.0):
        raise ParameterError(f"{name} must be a finite number above 0{_in(unit)}, got {value!r}")
    return number


def non_negative(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float of at least zero.

    Args:
        name: What the value is called in the error.
        value: A number.
        unit: Its unit, for the error.

    Raises:
        ParameterError: If it is not a finite number of at least zero.
    """
    number = _number(name, value)
    if not (math.isfinite(number) and number >= 0.0):
        raise ParameterError(f"{name} must be a finite number of at least 0{_in(unit)}, got {value!r}")
    return number


def gain_matrix(name: str, value: ArrayLike, size: int) -> Array:
    """Return a feedback gain as a matrix.

    Args:
        name: What the gain is called in the error.
        value: A scalar, a vector of `size` entries (the diagonal) or a matrix of shape (size, size).
        size: The number of coordinates fed back.

    Returns:
        The gain, of shape (size, size).

    Raises:
        ShapeError: If it has another shape.
        NonFiniteError: If an entry is NaN or infinite.
        ParameterError: If it is negative: an entry of a scalar or vector below zero, or a matrix whose symmetric
            part is not positive semidefinite.
    """
    try:
        gain = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"{name} must be a number, a vector or a matrix, got {value!r}") from None
    if gain.shape not in ((), (size,), (size, size)):
        raise ShapeError(f"{name} must be a scalar or have shape ({size},) or ({size}, {size}), got shape {gain.shape}")
    if not np.isfinite(gain).all():
        raise NonFiniteError(f"{name} must be finite, got {gain.tolist()}")
    matrix = gain if gain.ndim == 2 else np.diag(np.broadcast_to(gain, (size,)))
    smallest = np.linalg.eigvalsh(matrix / 2.0 + matrix.T / 2.0).min()
    if smallest < -np.finfo(np.float64).eps * np.abs(matrix).max():
        raise ParameterError(f"{name} must not be negative, got {gain.tolist()}")
    return np.ascontiguousarray(matrix)


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ParameterError(f"{name} must be a number, got {value!r}")
    return float(value)


def _in(unit: str) -> str:
    return f" {unit}" if unit else ""
