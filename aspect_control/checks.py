"""Checks of what a caller hands in, each with one clear error."""

from __future__ import annotations

import math
import os
from collections.abc import Collection
from math import hypot, isfinite
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import AspectControlError, NonFiniteError, ParameterError, ShapeError, UnknownNameError, shown
from .redundancy import Array

T = TypeVar("T", bound=np.generic)

LARGEST = 1e50
"""Largest magnitude of a number that is taken, in whatever unit: no arm needs more, and its powers do not overflow."""

_FLOAT = np.dtype(np.float64)


def is_finite(vector: Array) -> bool:
    """Return whether a vector, shape (any,), holds neither NaN nor infinity, in a fifth of `np.isfinite`'s time."""
    return isfinite(sum(vector.tolist()))


def finite_vector(name: str, value: ArrayLike, size: int | None = None) -> Array:
    """Return a read-only copy of `value` as a vector of finite floats.

    Args:
        name: What the value is called in the error.
        value: A vector of real numbers: an array of any memory order, of floats or integers of any size and byte order,
            or a sequence. Booleans, complex numbers and masked arrays are none.
        size: The number of entries expected; None for any number.

    Returns:
        The vector, of shape (size,).

    Raises:
        ShapeError: If it is not a vector of `size` real numbers.
        NonFiniteError: If an entry is NaN, infinite or beyond `LARGEST`.
    """
    if type(value) is np.ndarray and value.dtype is _FLOAT and value.ndim == 1 and (size is None or len(value) == size):
        vector: Array = value.copy()
    else:
        vector = real_array(name, value, "a vector of numbers")
        if vector.ndim != 1 or (size is not None and vector.shape[0] != size):
            expected = f"({size},)" if size is not None else "(any,)"
            raise ShapeError(f"{name} must have shape {expected}, got {vector.shape}")
    if not hypot(*vector.tolist()) <= LARGEST:
        require_finite(name, vector)
    vector.setflags(False)  # type: ignore[call-arg]  # as write=False in half the time
    return vector


def read_only(array: NDArray[T]) -> NDArray[T]:
    """Return an array that nobody else writes to, and that from here on nobody can."""
    array.setflags(write=False)
    return array


def restore_read_only(owner: Any, state: dict[str, Any]) -> None:
    """Take over what was pickled or copied, with arrays read-only again: `__setstate__` of a class that has some."""
    owner.__dict__.update(state)
    for value in state.values():
        for each in value if isinstance(value, tuple) else (value,):
            if isinstance(each, np.ndarray):
                each.setflags(write=False)


def real_array(name: str, value: Any, expected: str) -> Array:
    """Return a copy of `value` as an array of floats of any shape; entries may be infinite or NaN.

    Args:
        name: What the value is called in the error.
        value: What is taken for one.
        expected: What it should be, for the error.

    Raises:
        ShapeError: If it is no array of real numbers.
    """
    try:
        array = np.asarray(value)
        kind = array.dtype.name
        if isinstance(value, np.ma.MaskedArray):
            kind = "a masked array"
        elif isinstance(value, (list, tuple)) and any(isinstance(entry, (bool, np.bool_)) for entry in value):
            kind = "booleans among numbers"
        elif array.dtype.kind in "iuf":
            return np.array(array, dtype=np.float64, order="C")
    except Exception as error:
        raise ShapeError(f"{name} must be {expected}, got {shown(value)}: {error}") from None
    raise ShapeError(f"{name} must be {expected}, got {shown(value)} ({kind})")


def require_finite(name: str, array: Array) -> None:
    """Make sure that an array holds neither NaN nor infinity nor a number beyond `LARGEST`.

    Raises:
        NonFiniteError: If it does.
    """
    if not np.isfinite(array).all():
        raise NonFiniteError(f"{name} must be finite, got {array.tolist()}")
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise NonFiniteError(f"{name} must be at most {LARGEST:g} in magnitude, got {array.tolist()}")


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
    expected = "a finite number"
    number = _number(name, value, expected)
    if not math.isfinite(number):
        raise ParameterError(f"{name} must be {expected}, got {shown(value)}")
    return number


def positive(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float above zero.

    Args:
        name: What the value is called in the error.
        value: A number.
        unit: Its unit, for the error.

    Raises:
        ParameterError: If it is not a finite number above zero.
    """
    expected = f"a finite number above 0{_in(unit)}"
    number = _number(name, value, expected)
    if not (math.isfinite(number) and number > 0.0):
        raise ParameterError(f"{name} must be {expected}, got {shown(value)}")
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
    expected = f"a finite number of at least 0{_in(unit)}"
    number = _number(name, value, expected)
    if not (math.isfinite(number) and number >= 0.0):
        raise ParameterError(f"{name} must be {expected}, got {shown(value)}")
    return number


def gain_matrix(name: str, value: ArrayLike, size: int) -> Array:
    """Return a feedback gain as a matrix.

    Args:
        name: What the gain is called in the error.
        value: A scalar, a vector of `size` entries (the diagonal) or a matrix of shape (size, size).
        size: The number of coordinates fed back.

    Returns:
        The gain, of shape (size, size), read-only.

    Raises:
        ShapeError: If it has another shape.
        NonFiniteError: If an entry is NaN or infinite.
        ParameterError: If it is negative: an entry of a scalar or vector below zero, or a matrix whose symmetric
            part is not positive semidefinite.
    """
    gain = real_array(name, value, "a number, a vector or a matrix")
    if gain.shape not in ((), (size,), (size, size)):
        raise ShapeError(f"{name} must be a scalar or have shape ({size},) or ({size}, {size}), got shape {gain.shape}")
    require_finite(name, gain)
    matrix = gain if gain.ndim == 2 else np.diag(np.broadcast_to(gain, (size,)))
    smallest = np.linalg.eigvalsh(matrix / 2.0 + matrix.T / 2.0).min()
    if smallest < -np.finfo(np.float64).eps * np.abs(matrix).max():
        raise ParameterError(f"{name} must not be negative, got {gain.tolist()}")
    matrix = np.array(matrix, order="C")
    matrix.setflags(write=False)
    return matrix


def whole_number(name: str, value: Any, least: int, most: int | None = None) -> int:
    """Return `value` as an integer of a range.

    Args:
        name: What the value is called in the error.
        value: A whole number; 2.0 is none.
        least: The smallest one allowed.
        most: The largest one allowed; None for any.

    Raises:
        ParameterError: If it is none of them.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < least:
        raise ParameterError(f"{name} must be a whole number of at least {least}, got {shown(value)}")
    if most is not None and int(value) > most:
        raise ParameterError(f"{name} must be a whole number of at most {most:,}, got {shown(value)}")
    return int(value)


def unicode_text(name: str, value: Any, error: type[AspectControlError] = ParameterError) -> str:
    """Return `value` if it is text that any file can hold.

    Args:
        name: What the value is called in the error.
        value: A string.
        error: The class of the error.

    Raises:
        AspectControlError: Of the class `error`, if it is no string or holds NUL or half a surrogate pair.
    """
    if not isinstance(value, str):
        raise error(f"{name} must be text, got {shown(value)}")
    odd = next((character for character in value if character == "\0" or "\ud800" <= character <= "\udfff"), None)
    if odd is not None:
        raise error(f"{name} must be text without the character {odd!r}, got {shown(value)}")
    return value


def file_path(name: str, value: Any, error: type[AspectControlError] = ParameterError) -> Path:
    """Return `value` as a path that a file may have, existing or not.

    Args:
        name: What the value is called in the error.
        value: A string or a path.
        error: The class of the error.

    Raises:
        AspectControlError: Of the class `error`, if it is no path, or no file can have it.
    """
    try:
        given = os.fspath(value)
        if not isinstance(given, str) or b"\0" in os.fsencode(given):
            raise ValueError
    except (TypeError, ValueError):
        raise error(f"{name} must be a path that a file can have, got {shown(value)}") from None
    return Path(given)


def known_name(
    name: Any,
    available: Collection[str],
    kind: str = "",
    *,
    error: type[UnknownNameError] = UnknownNameError,
    context: str = "",
) -> str:
    """Return `name` if it is one of the names that exist.

    Args:
        name: Anything.
        available: The names that exist.
        kind: What a name stands for, for the error; empty for what the error says by itself.
        error: The class of the error.
        context: Where it is looked for, for the error.

    Raises:
        UnknownNameError: Of the class `error`, if it is none of them; the message lists them.
    """
    if not isinstance(name, str) or name not in available:
        raise error(name, available, kind=kind, context=context)
    return name


def _number(name: str, value: Any, expected: str) -> float:
    try:
        if isinstance(value, Real) and not isinstance(value, bool):
            return float(value)
    except OverflowError:
        pass  # an integer or a fraction beyond the largest float
    raise ParameterError(f"{name} must be {expected}, got {shown(value)}")


def _in(unit: str) -> str:
    return f" {unit}" if unit else ""
