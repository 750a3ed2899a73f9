"""The array types of the package: all double precision, told apart by their number of dimensions."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""A NumPy array of double-precision numbers; shapes and units stand in the docstrings."""

Vector: TypeAlias = Array
"""An array of one dimension."""

Matrix: TypeAlias = Array
"""An array of two dimensions."""

Tensor: TypeAlias = Array
"""An array of three dimensions."""

Table: TypeAlias = NDArray[np.int64]
"""A table of whole numbers, an array of two dimensions."""
