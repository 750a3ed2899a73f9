"""What an arm looks like: the visual geometry of its URDF."""

from __future__ import annotations

from typing import Any

import pinocchio as pin

from ..exceptions import ModelError
from .arm import Arm
from .chain import joints_to_lock, reduce_geometry
from .sources.urdf import mimic_joints


def visual_geometry(arm: Arm) -> Any:
    """Return the visual geometry of an arm and of the robot that carries it, as a `pin.GeometryModel` of `arm.model`.

    Args:
        arm: The arm; the folders of its `package://` meshes are its description's `package_dirs`.

    Raises:
        ModelError: If the arm was not made of a URDF, or a mesh is missing; the message names the mesh and the folders.
    """
    description = arm.description
    if description.urdf is None:
        raise ModelError(f"{arm.name!r} was made of a pin.Model, which has no visual geometry")
    model = description.model()
    folders = list(description.package_dirs)
    try:
        geometry = pin.buildGeomFromUrdfString(model, description.urdf, pin.GeometryType.VISUAL, package_dirs=folders)
    except ValueError as error:
        places = ", ".join(folders) or "none were given; pass package_dirs to Arm.from_urdf"
        raise ModelError(f"the visual geometry of {arm.name!r} cannot be loaded: {error} Searched: {places}") from error
    locked, q = joints_to_lock(model, description.frame, description.locked, mimic_joints(description.urdf))
    return reduce_geometry(model, geometry, locked, q)
