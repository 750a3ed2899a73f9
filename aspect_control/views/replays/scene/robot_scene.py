"""Where things stand in the scene: robots side by side on the ground, and the camera that sees them all."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ....arm import Arm
from ....redundancy import Array
from .command_recorder import CommandRecorder
from .robot import Robot

MARGIN = 0.25
"""Space between two robots as a part of the width that one takes up."""

FROM_ABOVE = (0.0, -0.45, 1.0)
"""Direction from which arms that move in a horizontal plane are seen."""

FROM_THE_SIDE = (0.75, -0.85, 0.5)
"""Direction from which other arms are seen."""


class SceneRobot(NamedTuple):
    """One robot of the scene.

    Attributes:
        arm: The arm.
        q: Configuration at the start, shape (nq,), rad.
        points: Points that the camera must see, shape (any, 3), m, as if the robot stood alone.
    """

    arm: Arm
    q: Array
    points: Array


class RobotScene:
    """Robots on the ground, each drawn once, in rows.

    Attributes:
        recorder: The drawing commands.
        nodes: Path of each robot's node in the scene.
        offsets: Where each robot's world frame is put, shape (robots, 3), m.
        data: What the page needs to know: camera, ground, copied robots.
        notes: What could not be drawn as it should.
    """

    def __init__(self, robots: Sequence[SceneRobot]) -> None:
        """Put up the robots.

        Args:
            robots: The robots, one at least.
        """
        self.recorder = CommandRecorder()
        self.nodes = [f"/meshcat/run{i}" for i in range(len(robots))]
        self.notes: list[str] = []
        copies, boxes = self._draw(robots)
        moving = np.concatenate([scene_robot.points for scene_robot in robots])
        flat = bool(np.ptp(moving[:, 2]) <= 1e-6 * np.ptp(moving, axis=0).max())
        low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        view = np.array(FROM_ABOVE if flat else FROM_THE_SIDE)
        columns = math.ceil(math.sqrt(1.6 * len(robots))) if flat else len(robots)
        self.offsets = _rows(len(robots), columns, high - low, view)
        for node, offset in zip(self.nodes, self.offsets, strict=True):
            self.recorder.visualizer()[node].set_transform(pin.SE3(np.eye(3), offset).homogeneous)
        self.data: dict[str, Any] = {
            "view": (view / np.linalg.norm(view)).tolist(),
            "boxes": (boxes + self.offsets[:, None]).tolist(),
            "anchor": [0.5 * (low[0] + high[0]), float(low[1]) if flat else 0.5 * (low[1] + high[1]), low[2]],
            "size": float(np.linalg.norm(np.ptp(moving, axis=0))),
            "ground": min(0.0, float(low[2])),
            "copies": copies,
        }

    def _draw(self, robots: Sequence[SceneRobot]) -> tuple[list[list[str]], Array]:
        """Draw each robot, or say of which one it is a copy; return that and the box that each takes up."""
        root, drawn = self.recorder.visualizer(), dict[int, Robot]()
        copies, boxes = [], []
        for i, (arm, q, points) in enumerate(robots):
            original = next((j for j in drawn if drawn[j].arm.description == arm.description), i)
            if original == i:
                drawn[i] = Robot(arm)
                note = drawn[i].draw(root[f"run{i}"]["robot"])
                self.notes += [] if note is None else [note]
            else:
                copies.append([f"{self.nodes[original]}/robot", f"{self.nodes[i]}/robot"])
            extent = np.concatenate([points, drawn[original].bounds(q)])
            boxes.append([extent.min(axis=0), extent.max(axis=0)])
        return copies, np.array(boxes)


def _rows(count: int, columns: int, extent: Array, view: Array) -> Array:
    """Return the offsets of robots in rows across the view, shape (count, 3), m; further rows stand in front."""
    right = np.cross([0.0, 0.0, 1.0], view)
    right /= np.linalg.norm(right)
    front = np.cross(right, [0.0, 0.0, 1.0])
    width, depth = (1.0 + MARGIN) * np.abs(right) @ extent, (1.0 + MARGIN) * np.abs(front) @ extent
    offsets: Array = np.array([(i % columns) * width * right + (i // columns) * depth * front for i in range(count)])
    return offsets
