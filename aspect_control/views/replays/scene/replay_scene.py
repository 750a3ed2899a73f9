"""The scene of a replay: runs side by side and in step, as meshcat's animation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from meshcat.animation import Animation, AnimationClip, AnimationTrack
from meshcat.commands import SetAnimation
from meshcat.path import Path as NodePath
from numpy.typing import NDArray

from ....analysis import minor_zero_crossings
from ....arm import Arm
from ....redundancy import Array
from ....simulation import Run
from ...figures.panels import desired_positions
from ...frames import FRAME_RATE, finite_part, frame_times, samples_at
from .readings import CALMEST, Reading, change_data, run_data, torque_marks
from .robot import joint_poses
from .robot_scene import RobotScene, SceneRobot

HOLD = 1.0
"""How long the last picture stands before the motion begins again, s of playback."""

REPETITIONS = 1000
"""How often the motion is shown before it stops."""


@dataclass(frozen=True)
class Scene:
    """What a page shows.

    Attributes:
        commands: Packed drawing commands of meshcat, in order.
        data: What the page needs, ready for JSON.
        notes: What could not be drawn as it should, one sentence each.
    """

    commands: list[bytes]
    data: dict[str, Any]
    notes: list[str]


class Motion:
    """One run at the times of the frames.

    Attributes:
        label: What the run is called.
        run: The finite part of the run.
        samples: Index of the sample that each frame shows, shape (f,).
        points: Joints and task frame as of `Arm.skeleton`, shape (f, nv + 1, 3), m.
        desired: The desired path, shape (f, 3), m; in directions that the task leaves free, the tip's own.
        end: How the run ended if it ended before its time; else None.
    """

    def __init__(self, label: str, run: Run, times: Array) -> None:
        """Look at a run at the times of the frames, shape (f,), s."""
        self.label, self.run = label, finite_part(run)
        self.samples = samples_at(run, times)
        self.points: Array = np.array([run.arm.skeleton(q) for q in self.run.q[self.samples]])
        desired = desired_positions(self.run)[self.samples]
        self.desired: Array = np.where(np.isnan(desired), self.points[:, -1], desired)
        cut = f"not finite after t = {self.run.t[-1]:.6g} s" if len(self.run.t) < len(run.t) else None
        self.end = cut if run.status == "finished" else run.message

    @property
    def scene_robot(self) -> SceneRobot:
        """The robot of the run."""
        points = np.concatenate([self.points.reshape(-1, 3), self.desired])
        return SceneRobot(self.run.arm, self.run.q[0], points)

    def readings(self) -> list[Reading]:
        """Return what the page shows at each frame."""
        t, tau = self.run.t[self.samples], self.run.tau[self.samples]
        return [Reading(float(t[i]), tau[i], self.points[i, -1]) for i in range(len(t))]

    def changes(self) -> list[dict[str, Any]]:
        """Return when minors change sign, which ones, and where the tip is then."""
        run, crossings = self.run, minor_zero_crossings(self.run)
        samples = np.searchsorted(run.t, [crossing.time for crossing in crossings]).clip(max=len(run.t) - 1)
        return [
            change_data(run.arm, crossing.minor - 1, crossing.time, run.q[sample])
            for crossing, sample in zip(crossings, samples, strict=True)
        ]


def build_scene(runs: Mapping[str, Run], speed: float = 1.0) -> Scene:
    """Return the scene in which runs move side by side and in step by meshcat's animation.

    The frames are `FRAME_RATE` a second of playback, whatever the sampling time was. Runs of the same arm share its
    meshes.

    Args:
        runs: Runs by their labels, one at least.
        speed: Seconds of motion shown in a second.

    Raises:
        ParameterError: If `speed` is not above zero or a run has no samples.
        NonFiniteError: If the first sample of a run is not finite.
    """
    times = frame_times(list(runs.values()), FRAME_RATE, speed)
    motions = [Motion(label, run, times) for label, run in runs.items()]
    scene = RobotScene([motion.scene_robot for motion in motions])
    scene.recorder.send(SetAnimation(_animation(scene, motions, times, speed), repetitions=REPETITIONS))
    marks = torque_marks([motion.run for motion in motions])
    shown = [
        {
            **run_data(scene.nodes[i], motion.label, motion.run.arm, marks[i], motion.desired),
            "samples": [reading.to_dict() for reading in motion.readings()],
            "changes": motion.changes(),
            "end": motion.end,
        }
        for i, motion in enumerate(motions)
    ]
    data = {"live": False, "speed": speed, "end": float(times[-1]), "compared": CALMEST, **scene.data, "runs": shown}
    return Scene(scene.recorder.commands, data, scene.notes)


def _animation(scene: RobotScene, motions: Sequence[Motion], times: Array, speed: float) -> Animation:
    """Return the animation of every joint's node; all clips last equally long, so that repetitions stay in step."""
    hold = times[-1] + HOLD * speed
    keys = [float(time) * FRAME_RATE for time in (*times, hold)]
    animation = Animation(default_framerate=FRAME_RATE)
    for i, motion in enumerate(motions):
        poses = _held(motion.run.arm, motion.run.q, motion.samples)
        for joint in range(poses.shape[1]):
            tracks = {
                "position": AnimationTrack("position", "vector3", keys, poses[:, joint, :3].tolist()),
                "quaternion": AnimationTrack("quaternion", "quaternion", keys, poses[:, joint, 3:].tolist()),
            }
            path = NodePath(tuple(f"{scene.nodes[i]}/robot/joint{joint + 1}".strip("/").split("/")))
            animation.clips[path] = AnimationClip(tracks, fps=FRAME_RATE)
    return animation


def _held(arm: Arm, q: Array, samples: NDArray[np.intp]) -> Array:
    """Return the poses of the joints at the frames, the last one twice, shape (f + 1, nv, 7)."""
    return joint_poses(arm, q[[*samples, samples[-1]]])
