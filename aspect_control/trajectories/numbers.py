"""A check of numbers of either sign."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

from ..exceptions import ParameterError


def finite_number(name: str, value: Any) -> float:
    """Return `value` as a finite float.

    Args:
        name: What the value is called in the error.
        value: A number.

    Raises:
        ParameterError: If it is not a finite number.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise ParameterError(f"{name} must be a finite number, got {value!r}")
    return float(value)
