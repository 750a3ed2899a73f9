"""The example robots: that each can be loaded or says why not, where their arms end, and how far they reach."""

import re

import numpy as np
import pinocchio as pin
import pytest

from aspect_control import Arm
from aspect_control.arm.sources.examples import (
    end_frames,
    example_names,
    example_overview,
    find_example,
    load_example_model,
)
from aspect_control.exceptions import ModelError, UnknownNameError
from aspect_control.resources import model_path
from conftest import seven_joint_urdf
from example_arms import FRAMES, example_arm, whole_model

every_example = pytest.mark.parametrize("name", example_names())


# What there is


def test_names_are_sorted_and_hold_those_of_the_package_and_of_example_robot_data():
    names = example_names()
    assert list(names) == sorted(set(names))
    assert {"planar3r", "panda", "ur5", "talos", "pr2"} <= set(names)
    assert len(names) > 50


@every_example
def test_example_can_be_loaded_or_says_why_not(name):
    overview = example_overview(name)
    assert overview.name == name
    if overview.problem:
        assert (overview.joints, overview.end_frames) == (0, [])
        with pytest.raises(ModelError, match=re.escape(overview.problem)):
            load_example_model(name)
    else:
        model = load_example_model(name)
        assert overview.joints == model.nv
        assert overview.end_frames == end_frames(model)


def test_nearly_every_example_can_be_loaded():
    # Cassie is described in SDF, which this Pinocchio was built without.
    assert [name for name in example_names() if example_overview(name).problem] in ([], ["cassie"])


def test_example_in_sdf_says_that_it_cannot_be_read():
    problem = example_overview("cassie").problem
    if problem:
        assert re.search("'cassie' is described in SDF, which cannot be read here: .+", problem)
        with pytest.raises(ModelError, match="'cassie' is described in SDF"):
            Arm.from_example("cassie", frame="left_toe", task="xyz")


@every_example
def test_description_of_an_example_exists(name):
    robot = find_example(name)
    assert robot.name == name
    assert robot.path.is_file()


@every_example
def test_example_has_no_floating_base(name):
    if not example_overview(name).problem:
        assert all(joint.nv == 1 for joint in list(load_example_model(name).joints)[1:])


def test_loading_examples_prints_nothing(capfd):
    for name in ("panda", "pr2", "talos", "romeo"):
        load_example_model(name)
    assert capfd.readouterr().out == ""


def test_example_is_the_urdf_it_names():
    arm = example_arm("panda")
    assert arm.description.urdf == find_example("panda").path.read_text(encoding="utf-8")
    assert arm.description.package_dirs == find_example("panda").package_dirs


def test_example_of_the_package_is_its_own_urdf():
    assert find_example("planar3r").path == model_path("planar3r.urdf")


def test_unknown_example_names_the_nearest_and_lists_all():
    message = "unknown example robot 'pandaa': did you mean 'panda'"
    for function in (find_example, load_example_model, example_overview):
        with pytest.raises(UnknownNameError, match=message) as caught:
            function("pandaa")
        assert caught.value.available == example_names()
    with pytest.raises(UnknownNameError, match=message):
        Arm.from_example("pandaa", frame="panda_hand_tcp", task="xyz")


# Where their arms end


def test_panda_ends_at_its_fingers_and_its_tool_centre():
    assert set(end_frames(whole_model("panda"))) == {"panda_leftfinger", "panda_rightfinger", "panda_hand_tcp"}


@pytest.mark.parametrize(
    ("robot", "frames"), [("planar3r", ["tool"]), ("xarm7", ["link_eef"]), ("ur5", ["ee_link", "tool0"])]
)
def test_arm_ends_at_its_tool(robot, frames):
    assert end_frames(whole_model(robot)) == frames


@pytest.mark.parametrize("robot", ["baxter", "pr2", "talos", "romeo", "tiago_dual", "kinova"])
def test_end_frames_are_moved_links_that_carry_no_link(robot):
    model = whole_model(robot)
    carrying, frames = set(), list(model.frames)
    for frame in frames:
        parent = frame.parentFrame
        while frame.type == pin.FrameType.BODY and parent and frames[parent].type != pin.FrameType.BODY:
            parent = frames[parent].parentFrame
        if frame.type == pin.FrameType.BODY:
            carrying.add(frames[parent].name)
    links = [frame for frame in frames if frame.type == pin.FrameType.BODY and frame.parentJoint]
    assert end_frames(model) == [link.name for link in links if link.name not in carrying]


def arm_or_error(name, frame):
    try:
        return Arm.from_example(name, frame=frame, task=("x",))
    except ModelError as error:
        return error


@every_example
def test_every_end_frame_is_that_of_an_arm_or_has_no_mass_to_move(name):
    for frame in example_overview(name).end_frames[:3]:
        made = arm_or_error(name, frame)
        assert isinstance(made, Arm) or re.search("singular inertia matrix|no joint is left", str(made))


# How far they reach


@pytest.mark.parametrize("robot", ["panda", "pr2", "planar3r", "tiago", "ur5", "kinova", "baxter"])
def test_reach_is_an_upper_bound_of_the_distance_to_the_frame(robot):
    arm = Arm.from_example(robot, frame=FRAMES[robot], task=("x",))
    lower, upper = (np.clip(limit, -2.0 * np.pi, 2.0 * np.pi) for limit in arm.position_limits)
    rng = np.random.default_rng(1)
    postures = [arm.configuration(rng.uniform(lower, upper)) for _ in range(200)]
    skeletons = np.array([arm.skeleton(q) for q in postures])
    assert np.linalg.norm(skeletons[:, -1] - skeletons[:, 0], axis=-1).max() <= arm.reach * (1.0 + 1e-12)


def test_reach_of_the_planar_arm_is_its_length():
    assert example_arm("planar3r", "xy").reach == pytest.approx(3.0, rel=1e-15)


def test_reach_counts_the_travel_of_prismatic_joints():
    fixed = Arm.from_example("pr2", frame=FRAMES["pr2"], task="xyz", locked={"torso_lift_joint": 0.0})
    lower, upper = example_arm("pr2").position_limits
    travel = max(abs(lower[0]), abs(upper[0]))
    assert travel > 0.3
    base = np.linalg.norm(np.diff(example_arm("pr2").skeleton(pin.neutral(example_arm("pr2").model))[:2], axis=0))
    assert example_arm("pr2").reach == pytest.approx(fixed.reach + base + travel, rel=1e-14)


def test_reach_of_an_inner_prismatic_joint_is_a_bound():
    text = seven_joint_urdf().replace('<joint name="joint4" type="revolute">', '<joint name="joint4" type="prismatic">')
    arm = Arm.from_urdf_text(text, frame="tool", task="xyz")
    rng = np.random.default_rng(2)
    skeletons = np.array([arm.skeleton(rng.uniform(-3.0, 3.0, 7)) for _ in range(200)])
    distances = np.linalg.norm(skeletons[:, -1] - skeletons[:, 0], axis=-1)
    revolute = Arm.from_urdf_text(seven_joint_urdf(), frame="tool", task="xyz")
    assert distances.max() > revolute.reach
    assert distances.max() <= arm.reach == pytest.approx(revolute.reach + 3.0, rel=1e-14)
