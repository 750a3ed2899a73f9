"""The robots that `example-robot-data` ships, and those of this package, by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import pinocchio as pin

from ...checks import known_name
from ...exceptions import ModelError
from ...resources import model_path
from .urdf import parse_urdf, read_urdf

OWN_ROBOTS = {"planar3r": "planar3r.urdf"}
"""Robots whose URDF ships with this package."""


class ExampleRobot(NamedTuple):
    """Where a robot's description is.

    Attributes:
        name: Its name among the examples.
        path: Its URDF, or SDF.
        package_dirs: Folders in which its `package://` meshes are found.
    """

    name: str
    path: Path
    package_dirs: tuple[str, ...]


def example_names() -> tuple[str, ...]:
    """Return the names of all example robots, sorted."""
    return tuple(sorted({*OWN_ROBOTS, *_loaders()}))


def find_example(name: str) -> ExampleRobot:
    """Return where an example robot's description is.

    Raises:
        UnknownNameError: If there is no such robot; the message lists those that exist.
        ModelError: If its description is not installed.
    """
    if isinstance(name, str) and name in OWN_ROBOTS:
        return ExampleRobot(name, model_path(OWN_ROBOTS[name]), ())
    loader = _loaders()[known_name(name, example_names(), "example robot")]
    from example_robot_data.robots_loader import getModelPath

    folder, file = (
        (loader.urdf_subpath, loader.urdf_filename)
        if loader.urdf_filename
        else (loader.sdf_subpath, loader.sdf_filename)
    )
    relative = Path(loader.path) / folder / file
    try:
        root = Path(loader.model_path or getModelPath(str(relative)))
    except OSError as error:
        raise ModelError(f"the description of example robot {name!r} is not installed: {error}") from error
    return ExampleRobot(name, root / relative, (str((root / "../..").resolve()),))


def load_example_model(name: str) -> Any:
    """Return the whole robot as a `pin.Model`, without a floating base and without meshes.

    Raises:
        UnknownNameError: If there is no such robot.
        ModelError: If its description cannot be read.
    """
    robot = find_example(name)
    if robot.path.suffix == ".sdf":
        return _load_sdf(name)
    return parse_urdf(read_urdf(robot.path), str(robot.path))


def end_frames(model: Any) -> list[str]:
    """Return the frames that end a chain: bodies that carry no further body and that a joint moves."""
    parents = {frame.parentFrame for frame in model.frames}
    bodies = [
        (index, frame)
        for index, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY and frame.parentJoint != 0
    ]
    return [frame.name for index, frame in bodies if index not in parents]


class ExampleOverview(NamedTuple):
    """What an example robot offers.

    Attributes:
        name: Its name among the examples.
        joints: Number of joint velocities of the whole robot.
        end_frames: Frames that end a chain of joints.
        problem: Why it cannot be loaded; empty if it can.
    """

    name: str
    joints: int
    end_frames: list[str]
    problem: str


def example_overview(name: str) -> ExampleOverview:
    """Return what an example robot offers, or why it cannot be loaded.

    Raises:
        UnknownNameError: If there is no such robot.
    """
    find_example(name)
    try:
        model = load_example_model(name)
    except ModelError as error:
        return ExampleOverview(name, 0, [], str(error))
    return ExampleOverview(name, model.nv, end_frames(model), "")


def _load_sdf(name: str) -> Any:
    from example_robot_data import load

    try:
        return load(name).model
    except Exception as error:
        # The loader re-raises whatever Pinocchio's SDF parser and its dependencies raise.
        raise ModelError(f"example robot {name!r} is described in SDF, which cannot be read here: {error}") from error


def _loaders() -> dict[str, Any]:
    try:
        from example_robot_data.robots_loader import ROBOTS
    except ImportError:
        return {}
    return dict(ROBOTS)
