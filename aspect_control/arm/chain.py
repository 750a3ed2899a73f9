"""The chain of joints that moves a frame, taken out of any robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from ..checks import finite_number, known_name
from ..exceptions import FrameNotFoundError, JointNotFoundError, ModelError, ParameterError
from ..redundancy import Array

NO_LIMIT = 1e300
"""Magnitude from which a limit of a `pin.Model` means none."""


def require_frame(model: Any, name: str) -> int:
    """Return the index of a frame that at least one joint moves.

    Where a link and a joint have the same name, the link is meant.

    Raises:
        FrameNotFoundError: If the model has no such frame; the message lists those that exist.
        ModelError: If no joint moves it.
    """
    names = [frame.name for frame in model.frames]
    known_name(name, names, error=FrameNotFoundError, context=repr(model.name))
    found = [index for index, each in enumerate(names) if each == name]
    frame_id = next((index for index in found if model.frames[index].type == pin.FrameType.BODY), found[0])
    if model.frames[frame_id].parentJoint == 0:
        moved = [each.name for each in model.frames if each.parentJoint != 0]
        if not moved:
            raise ModelError(f"{model.name!r} has no joints that move: an arm needs at least one")
        raise ModelError(f"frame {name!r} of {model.name!r} is on the base: no joint moves it; try {moved[-1]!r}")
    return frame_id


def reduce_model(model: Any, locked: Sequence[int], q: Array) -> Any:
    """Return a model without the locked joints.

    Args:
        model: The whole robot, a `pin.Model`.
        locked: Indices of the joints to lock.
        q: Configuration in which they stay, shape (nq,).
    """
    if not locked:
        return model
    unique, originals = _with_unique_frame_names(model)
    reduced = pin.buildReducedModel(unique, list(locked), q)
    for frame in reduced.frames:
        frame.name = originals.get(frame.name, frame.name)
    return reduced


def reduce_geometry(model: Any, geometry: Any, locked: Sequence[int], q: Array) -> Any:
    """Return the geometry of a robot, attached to the joints that `reduce_model` leaves.

    Args:
        model: The whole robot, a `pin.Model`.
        geometry: Its `pin.GeometryModel`.
        locked: As for `reduce_model`.
        q: As for `reduce_model`.
    """
    unique, _ = _with_unique_frame_names(model)
    return pin.buildReducedModel(unique, [geometry], list(locked), q)[1][0]


def _with_unique_frame_names(model: Any) -> tuple[Any, dict[str, str]]:
    """Return a copy in which every joint has a frame and no two frames have one name, and the renamed ones' names.

    Pinocchio looks frames up by name while it reduces a model, which fails where a URDF uses a name twice or a model
    was built without joint frames.
    """
    unique = _with_joint_frames(model)
    names = [frame.name for frame in unique.frames]
    originals = {}
    for index, frame in enumerate(unique.frames):
        if names.count(frame.name) > 1 and frame.type != pin.FrameType.JOINT:
            name = f"{frame.name} ({index})"
            originals[name] = frame.name
            frame.name = name
    return unique, originals


def _with_joint_frames(model: Any) -> Any:
    """Return a copy in which every joint has a frame, placed before the frames that hang on it."""
    if all(model.existFrame(name, pin.FrameType.JOINT) for name in list(model.names)[1:]):
        return model.copy()
    copy = pin.Model()
    copy.name, copy.gravity = model.name, model.gravity
    joint_frames = [0]
    for index, joint in enumerate(model.joints):
        if index == 0:
            continue
        q, v = slice(joint.idx_q, joint.idx_q + joint.nq), slice(joint.idx_v, joint.idx_v + joint.nv)
        parent = model.parents[index]
        copy.addJoint(
            parent,
            joint,
            model.jointPlacements[index],
            model.names[index],
            model.effortLimit[v],
            model.velocityLimit[v],
            model.lowerPositionLimit[q],
            model.upperPositionLimit[q],
        )
        copy.inertias[index] = model.inertias[index]
        joint_frames.append(copy.addJointFrame(index, joint_frames[parent]))
    copy.armature = model.armature
    for frame in list(model.frames)[1:]:
        if frame.type != pin.FrameType.JOINT:
            moved = pin.Frame(frame)
            moved.parentFrame = joint_frames[frame.parentJoint]
            copy.addFrame(moved, False)
    return copy


def chain_joints(model: Any, frame: str) -> list[int]:
    """Return the indices of the joints from the root to the frame's parent joint.

    Args:
        model: A `pin.Model`.
        frame: Name of the frame.

    Raises:
        FrameNotFoundError: If the model has no such frame.
        ModelError: If no joint moves it.
    """
    joint = model.frames[require_frame(model, frame)].parentJoint
    return [int(support) for support in model.supports[joint] if support != 0]


def joints_to_lock(
    model: Any, frame: str, locked: Mapping[str, float] | None = None, passive: Sequence[str] = ()
) -> tuple[list[int], Array]:
    """Return which joints do not belong to the arm, and a configuration that holds them where they stay.

    Besides the joints off the chain these are the joints of the chain that are named in `locked` or `passive`, and
    those with more than one degree of freedom, such as a floating base: an arm has joints of one.

    Args:
        model: A `pin.Model`.
        frame: Name of the task frame.
        locked: Joint positions, rad or m, by joint name; joints that are not named stay at their neutral position.
        passive: Names of joints that no motor of their own drives, such as mimic joints.

    Returns:
        Joint indices, and a configuration of the whole model, shape (nq,).

    Raises:
        FrameNotFoundError: If the model has no such frame.
        ModelError: If no joint would be left.
        JointNotFoundError: If `locked` names a joint that does not exist.
        ParameterError: If a position is not finite or outside the joint's limits, or the joint has several degrees of
            freedom.
    """
    chain = chain_joints(model, frame)
    locked = locked if locked is not None else {}
    q = pin.neutral(model)
    for name, position in locked.items():
        _set_joint(model, q, name, position)
    kept = {
        joint
        for joint in chain
        if model.joints[joint].nv == 1 and model.names[joint] not in locked and model.names[joint] not in passive
    }
    if not kept:
        raise ModelError(f"no joint is left to move {frame!r}: all of {[model.names[j] for j in chain]} are locked")
    return [joint for joint in range(1, model.njoints) if joint not in kept], q


def joint_position(model: Any, q: Array, joint: int) -> float:
    """Return the position of a joint of one degree of freedom, rad or m; in (−π, π] for a continuous joint."""
    values = q[model.joints[joint].idx_q :]
    return float(values[0]) if model.joints[joint].nq == 1 else math.atan2(values[1], values[0])


def position_limits(model: Any) -> tuple[Array, Array]:
    """Return lower and upper limits of the joint positions, shapes (nv,), rad or m; infinite where there are none."""
    lower, upper = np.full(model.nv, -np.inf), np.full(model.nv, np.inf)
    for joint in model.joints[1:]:
        if joint.nq == joint.nv == 1:
            bounds = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
            if bounds[0] < bounds[1]:
                lower[joint.idx_v], upper[joint.idx_v] = (
                    bound if abs(bound) < NO_LIMIT else np.copysign(np.inf, bound) for bound in bounds
                )
    return lower, upper


def unit_hint(position: float, lower: float, upper: float, *, prismatic: bool) -> str:
    """Return a hint at a mistaken unit: a position beyond ±2π that would fit as degrees, or metres as millimetres."""
    if prismatic:
        fits = abs(position) > 10.0 and lower <= position / 1000.0 <= upper
        return "; is it in millimetres? Positions are in metres" if fits else ""
    fits = abs(position) > 2.0 * math.pi and lower <= math.radians(position) <= upper
    return f"; is it in degrees? Angles are in radians: {math.radians(position):.6g}" if fits else ""


def is_prismatic(model: Any, joint: int) -> bool:
    """Tell whether a joint of one degree of freedom slides."""
    return "JointModelP" in model.joints[joint].shortname()


def _set_joint(model: Any, q: Array, name: str, position: float) -> None:
    known_name(name, list(model.names)[1:], error=JointNotFoundError, context=repr(model.name))
    index = model.getJointId(name)
    joint = model.joints[index]
    if joint.nv != 1:
        raise ParameterError(f"joint {name!r} has {joint.nv} degrees of freedom and cannot be locked at one position")
    position = finite_number(f"locked[{name!r}]", position)
    lower, upper = (limit[joint.idx_v] for limit in position_limits(model))
    if not lower <= position <= upper:
        hint = unit_hint(position, lower, upper, prismatic=is_prismatic(model, index))
        raise ParameterError(f"locked[{name!r}] = {position:g} is outside the limits [{lower:g}, {upper:g}]{hint}")
    values = [position] if joint.nq == 1 else [math.cos(position), math.sin(position)]
    q[joint.idx_q : joint.idx_q + joint.nq] = values
