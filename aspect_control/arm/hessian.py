"""Pinocchio's kinematic Hessian, with its entries where they belong."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin
from pinocchio import getFrameKinematicHessian

from ..redundancy import Array

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def frame_kinematic_hessian(model: Any, data: Any, frame_id: int) -> Array:
    """Return ∂J[i, j] / ∂q_k of a frame's Jacobian, world-aligned, shape (6, nv, nv).

    Args:
        model: A `pin.Model`.
        data: Its `pin.Data`, after `pin.computeJointKinematicHessians`.
        frame_id: Index of the frame.
    """
    hessian: Array = getFrameKinematicHessian(model, data, frame_id, _WORLD_ALIGNED)
    return hessian.reshape(hessian.shape[::-1]).T if _is_column_major() else hessian


@lru_cache(maxsize=1)
def _is_column_major() -> bool:
    """Tell whether Pinocchio labels its column-major Hessian as row-major, as 4.1.0 does, by comparing H v with J̇."""
    model = pin.buildSampleModelManipulator()
    data = model.createData()
    frame_id = model.nframes - 1
    q, v = np.linspace(0.3, 1.1, model.nv), np.linspace(-0.7, 0.9, model.nv)
    pin.computeJointJacobiansTimeVariation(model, data, q, v)
    pin.updateFramePlacements(model, data)
    expected = pin.getFrameJacobianTimeVariation(model, data, frame_id, _WORLD_ALIGNED)
    pin.computeJointKinematicHessians(model, data, q)
    hessian = pin.getFrameKinematicHessian(model, data, frame_id, _WORLD_ALIGNED)
    return not np.allclose(hessian @ v, expected)
