"""The chain of an arm as MuJoCo's own description of it (MJCF)."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from ..arm import Arm
from ..redundancy import Array

SMALLEST_INERTIA = 1e-6
"""Principal moments of inertia below this part of the largest are raised to it: MuJoCo wants all of them positive."""

AXES = np.eye(3)


def mjcf(arm: Arm, *, dt: float, friction: Array, damping: Array) -> str:
    """Return an arm as an MJCF document without shapes, contacts or motors.

    Args:
        arm: The arm.
        dt: Time step, s.
        friction: Dry friction of each joint, shape (nv,), N m.
        damping: Viscous friction of each joint, shape (nv,), N m s/rad.
    """
    root, model = ElementTree.Element("mujoco", model="arm"), arm.model
    ElementTree.SubElement(root, "compiler", angle="radian", balanceinertia="true")
    option = {"timestep": repr(dt), "gravity": _text(arm.gravity), "integrator": "implicitfast"}
    ElementTree.SubElement(
        ElementTree.SubElement(root, "option", option), "flag", contact="disable", autoreset="disable"
    )
    bodies = [ElementTree.SubElement(root, "worldbody")]
    for index in range(1, model.njoints):
        joint, placement = model.joints[index], model.jointPlacements[index]
        turned = _quaternion(placement.rotation)
        body = ElementTree.SubElement(
            bodies[model.parents[index]],
            "body",
            {"name": f"body{index}", "pos": _text(placement.translation), "quat": turned},
        )
        bodies.append(body)
        _add_inertial(body, model.inertias[index])
        j = joint.idx_v
        ElementTree.SubElement(
            body,
            "joint",
            {
                "name": f"joint{index}",
                "type": "slide" if arm.prismatic[j] else "hinge",
                "axis": _text(_axis(joint)),
                "limited": "false",
                "armature": repr(float(model.armature[j])),
                "frictionloss": repr(float(friction[j])),
                # As stiff as the time step allows: by default a joint that dry friction holds creeps.
                "solreffriction": _text((2.0 * dt, 1.0)),
                "solimpfriction": "0.999 0.999 0.001",
                "damping": repr(float(damping[j])),
            },
        )
    return ElementTree.tostring(root, encoding="unicode")


def _add_inertial(body: ElementTree.Element, inertia: pin.Inertia) -> None:
    moments, axes = np.linalg.eigh(inertia.inertia)
    axes *= np.sign(np.linalg.det(axes))
    moments = np.maximum(moments, max(SMALLEST_INERTIA * moments.max(), 1e-9))
    ElementTree.SubElement(
        body,
        "inertial",
        {
            "pos": _text(inertia.lever),
            "quat": _quaternion(axes),
            "mass": repr(max(float(inertia.mass), 1e-9)),
            "diaginertia": _text(moments),
        },
    )


def _axis(joint: pin.JointModel) -> Array:
    """Return the axis of a joint of one degree of freedom, in its own frame, shape (3,)."""
    data = joint.createData()
    joint.calc(data, np.eye(joint.nq)[0])
    column = np.ravel(data.S)
    axis: Array = column[:3] if np.any(column[:3]) else column[3:]
    return axis


def _quaternion(rotation: Array) -> str:
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return _text((w, x, y, z))


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)
