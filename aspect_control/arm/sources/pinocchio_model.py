"""A chain of joints as plain numbers: how an arm that was made of a `pin.Model` is written down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ...checks import finite_vector
from ...exceptions import ModelError
from ...redundancy import Array
from ..chain import require_frame
from ..inertia import require_possible

_ALIGNED = ("RX", "RY", "RZ", "RUBX", "RUBY", "RUBZ", "PX", "PY", "PZ")
_UNBOUNDED_UNALIGNED = "JointModelRevoluteUnboundedUnaligned"
_UNALIGNED = ("RevoluteUnaligned", "RevoluteUnboundedUnaligned", "PrismaticUnaligned")
JOINT_KINDS = tuple(f"JointModel{kind}" for kind in _ALIGNED + _UNALIGNED)
"""The kinds of joints that can be written down, by Pinocchio's names."""

_CONTINUOUS_JOINT = """<robot name="one joint">
  <link name="base"/>
  <link name="body"/>
  <joint name="joint" type="continuous"><parent link="base"/><child link="body"/><axis xyz="{axis}"/></joint>
</robot>"""


@dataclass(frozen=True)
class JointRecord:
    """One joint and the body that it moves.

    Attributes:
        name: Name of the joint.
        kind: Pinocchio's name of its kind, from `JOINT_KINDS`.
        axis: Its axis, for a kind that needs one; else empty.
        placement: Rotation matrix, row by row, then translation (m), in the joint before it.
        inertia: Mass (kg), centre of mass (m), and rotational inertia about it (kg m²), row by row.
        armature: Rotor inertia, kg m².
        limits: Lower and upper position, velocity and torque limits.
    """

    name: str
    kind: str
    axis: list[float]
    placement: list[float]
    inertia: list[float]
    armature: float
    limits: list[float]


@dataclass(frozen=True)
class ChainRecord:
    """A chain of joints of one degree of freedom, and the task frame.

    Attributes:
        name: The robot's name.
        joints: The joints, from the base.
        frame_placement: Rotation matrix and translation of the task frame in the last joint.
    """

    name: str
    joints: list[JointRecord]
    frame_placement: list[float]


def record_chain(model: Any, frame: str) -> ChainRecord:
    """Write down a reduced model.

    Args:
        model: A `pin.Model` that is a chain of joints of one degree of freedom.
        frame: Name of the task frame, which the last joint carries.

    Raises:
        ModelError: If a joint is of a kind that cannot be written down.
    """
    joints = [_record_joint(model, joint) for joint in range(1, model.njoints)]
    return ChainRecord(model.name, joints, _numbers_of_placement(model.frames[require_frame(model, frame)].placement))


def build_chain(record: ChainRecord, frame: str) -> Any:
    """Return the `pin.Model` of a record, with the task frame under its name.

    Raises:
        ModelError: If the record is not that of a chain.
        ShapeError: If a list has the wrong length.
        NonFiniteError: If a number that must be finite is not.
    """
    model = pin.Model()
    model.name = record.name
    names = [joint.name for joint in record.joints]
    if not names or len({*names, "universe"}) != len(names) + 1:
        raise ModelError(f"a recorded chain needs joints, each with a name of its own; got {names}")
    for index, joint in enumerate(record.joints):
        _add_joint(model, index, joint)
    placement = _placement("the frame's placement", record.frame_placement)
    model.addFrame(pin.Frame(frame, len(names), 0, placement, pin.FrameType.OP_FRAME))
    return model


def _record_joint(model: Any, joint: int) -> JointRecord:
    kind, inertia = model.joints[joint].shortname(), model.inertias[joint]
    if kind not in JOINT_KINDS:
        raise ModelError(
            f"joint {model.names[joint]!r} is a {kind}; an arm has joints of the kinds {', '.join(JOINT_KINDS)}"
        )
    q, v = model.joints[joint].idx_q, model.joints[joint].idx_v
    limits = (
        model.lowerPositionLimit[q],
        model.upperPositionLimit[q],
        model.velocityLimit[v],
        model.effortLimit[v],
    )
    return JointRecord(
        name=model.names[joint],
        kind=kind,
        axis=_axis(model.joints[joint]) if kind.endswith("Unaligned") else [],
        placement=_numbers_of_placement(model.jointPlacements[joint]),
        inertia=[float(inertia.mass), *_floats(inertia.lever), *_floats(inertia.inertia)],
        armature=float(model.armature[v]),
        limits=[float(limit) for limit in limits],
    )


def _add_joint(model: Any, parent: int, record: JointRecord) -> None:
    if record.kind not in JOINT_KINDS:
        raise ModelError(f"joint {record.name!r} is of the unknown kind {record.kind!r}")
    unaligned = record.kind.endswith("Unaligned")
    axis = finite_vector(f"the axis of {record.name!r}", record.axis, 3 if unaligned else 0)
    if unaligned and not np.isclose(np.linalg.norm(axis), 1.0, atol=1e-6):
        raise ModelError(f"the axis of joint {record.name!r} must have length 1, got {record.axis}")
    joint_model = _joint_model(record.kind, axis)
    mass, *rest = finite_vector(f"the inertia of {record.name!r}", record.inertia, 13)
    require_possible(f"what joint {record.name!r} moves", mass, np.reshape(rest[3:], (3, 3)))
    lower, upper, speed, torque = record.limits if len(record.limits) == 4 else (np.nan,) * 4
    if np.isnan([lower, upper, speed, torque]).any():
        raise ModelError(f"joint {record.name!r} needs four limits that are numbers, got {record.limits}")
    nq, nv = joint_model.nq, joint_model.nv
    joint = model.addJoint(
        parent,
        joint_model,
        _placement(f"the placement of {record.name!r}", record.placement),
        record.name,
        np.full(nv, torque),
        np.full(nv, speed),
        np.full(nq, lower),
        np.full(nq, upper),
    )
    model.inertias[joint] = pin.Inertia(mass, np.array(rest[:3]), np.reshape(rest[3:], (3, 3)))
    armature = model.armature.copy()
    armature[model.joints[joint].idx_v] = finite_vector("armature", [record.armature], 1)[0]
    model.armature = armature


def _axis(joint: Any) -> list[float]:
    """Return the axis of a joint that is not aligned with x, y or z, whose columns of S are its own."""
    data = joint.createData()
    joint.calc(data, np.eye(joint.nq)[0])
    column = np.ravel(data.S)
    return _floats(column[:3] if "Prismatic" in joint.shortname() else column[3:])


def _joint_model(kind: str, axis: Array) -> Any:
    if kind != _UNBOUNDED_UNALIGNED:
        return getattr(pin, kind)(axis) if len(axis) else getattr(pin, kind)()
    # Python can give this kind an axis only by way of a URDF.
    numbers = " ".join(map(repr, axis.tolist()))
    return pin.buildModelFromXML(_CONTINUOUS_JOINT.format(axis=numbers)).joints[1]


def _placement(name: str, numbers: list[float]) -> Any:
    values = finite_vector(name, numbers, 12)
    rotation = values[:9].reshape(3, 3)
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) or np.linalg.det(rotation) < 0.0:
        raise ModelError(f"{name} has no rotation matrix: {rotation.tolist()}")
    return pin.SE3(rotation, values[9:])


def _numbers_of_placement(placement: Any) -> list[float]:
    return [*_floats(placement.rotation), *_floats(placement.translation)]


def _floats(array: Any) -> list[float]:
    return [float(number) for number in np.ravel(array)]
