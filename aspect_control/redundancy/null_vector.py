"""The direction of the self-motion of an arm with one redundant degree of freedom."""

from __future__ import annotations

import numpy as np

from .array import Array


def null_vector(J: Array) -> Array:
    """Return the unit vector z with J z = 0, oriented by det [J; zᵀ] > 0, for one redundant degree of freedom.

    Its entries are the minors over the manipulability: for n = 3, z = (δ₂, δ₃, δ₁) / w. The minors are continuous over
    all configurations, and so is z wherever J has full rank; nowhere else is there a jump, or no direction at all.

    Args:
        J: Jacobian or a stack of them, shape (..., n − 1, n).

    Returns:
        z, shape (..., n), dimensionless.
    """
    z: Array = np.linalg.svd(J)[2][..., -1, :]
    orientation = np.linalg.det(np.concatenate([J, z[..., np.newaxis, :]], axis=-2))
    return np.where(orientation[..., np.newaxis] < 0.0, -z, z)
