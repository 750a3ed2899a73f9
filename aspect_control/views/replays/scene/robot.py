"""A robot in the scene: its links drawn once, and where they are at each configuration."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pinocchio as pin
from meshcat import geometry as shapes
from pinocchio.visualize import MeshcatVisualizer

from ....arm import Arm
from ....arm.visuals import visual_geometry
from ....exceptions import ModelError
from ....redundancy import Array

_STICK = shapes.MeshLambertMaterial(color=0xB8BEC6)


class Robot:
    """What an arm, and the robot that carries it, look like.

    Attributes:
        arm: The arm.
        geometry: Its visual geometry; None if there is none to be had.
        problem: Why it is drawn as a stick figure; None if it is not.
    """

    def __init__(self, arm: Arm) -> None:
        """Load the visual geometry."""
        self.arm = arm
        self.geometry: Any = None
        self.problem: str | None = None
        try:
            self.geometry = visual_geometry(arm)
        except ModelError as error:
            self.problem = f"{error} A stick figure is drawn instead."
        else:
            if not self.geometry.geometryObjects:
                self.problem = f"{arm.name!r} has no visual geometry. A stick figure is drawn instead."

    def draw(self, node: Any) -> str | None:
        """Draw the robot below a node of the scene.

        What moves with joint i of `arm.model` is drawn below `node["joint<i>"]` in the joint's own frame; `joint0` is
        what does not move.

        Args:
            node: The `meshcat.Visualizer` of the robot's node.

        Returns:
            None, or why the robot is drawn as a stick figure, or which of its parts are missing.
        """
        if self.problem is not None:
            _draw_stick_figure(node, self.arm)
            return self.problem
        loader = MeshcatVisualizer(self.arm.model, None, self.geometry)
        loader.initViewer(viewer=node)
        with warnings.catch_warnings(record=True) as problems:
            warnings.simplefilter("always")
            for link in self.geometry.geometryObjects:
                loader.viewerVisualGroupName = f"joint{link.parentJoint}"
                loader.loadViewerGeometryObject(link, pin.GeometryType.VISUAL)
                scaled = link.placement.homogeneous @ np.diag([*link.meshScale, 1.0])
                node[loader.getViewerNodeName(link, pin.GeometryType.VISUAL)].set_transform(scaled)
        return " ".join(str(problem.message) for problem in problems) or None

    def bounds(self, q: Array) -> Array:
        """Return the box around the robot at a configuration: its low and its high corner, shape (2, 3), m.

        Args:
            q: Joint configuration, shape (nq,), rad.
        """
        corners = [self.arm.skeleton(q)]
        if self.geometry is not None:
            model, data = self.arm.model, self.arm.model.createData()
            pin.forwardKinematics(model, data, q)
            for link in self.geometry.geometryObjects:
                link.geometry.computeLocalAABB()
                box = link.geometry.aabb_local
                placement = data.oMi[link.parentJoint] * link.placement
                local = np.array(np.meshgrid(*zip(box.min_, box.max_, strict=True))).reshape(3, -1)
                corners.append((placement.rotation @ local).T + placement.translation)
        points = np.concatenate(corners)
        return np.stack([points.min(axis=0), points.max(axis=0)])


def joint_poses(arm: Arm, configurations: Array) -> Array:
    """Return where the joint frames of `arm.model` are.

    Args:
        arm: The arm.
        configurations: Joint configurations, shape (f, nq), rad.

    Returns:
        Position (m) and quaternion (x, y, z, w) of each joint frame in the world frame, shape (f, nv, 7).
    """
    model, data = arm.model, arm.model.createData()
    poses = np.empty((len(configurations), model.njoints - 1, 7))
    for frame, q in enumerate(configurations):
        pin.forwardKinematics(model, data, q)
        for joint in range(1, model.njoints):
            poses[frame, joint - 1] = pin.SE3ToXYZQUAT(data.oMi[joint])
    return poses


def _draw_stick_figure(node: Any, arm: Arm) -> None:
    """Draw an arm as balls at its joints and rods between them, below the same nodes as `Robot.draw`."""
    model = arm.model
    radius = 0.02 * arm.reach
    tip = model.frames[model.getFrameId(arm.frame)]
    for joint in range(model.njoints):
        branches = [model.jointPlacements[i].translation for i in range(1, model.njoints) if model.parents[i] == joint]
        if tip.parentJoint == joint:
            branches.append(tip.placement.translation)
        part = node[f"joint{joint}"]
        if joint > 0:
            part["ball"].set_object(shapes.Sphere(1.4 * radius), _STICK)
        for i, end in enumerate(branches):
            length = float(np.linalg.norm(end))
            if length > radius:
                part[f"rod{i}"].set_object(shapes.Cylinder(length, radius), _STICK)
                part[f"rod{i}"].set_transform(_rod(end))


def _rod(end: Array) -> Array:
    """Return the transform of meshcat's cylinder, whose axis is y, that lays it from the origin to a point."""
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), end / np.linalg.norm(end))
    transform: Array = pin.SE3(turn, 0.5 * end).homogeneous
    return transform
