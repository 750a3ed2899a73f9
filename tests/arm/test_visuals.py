"""The visual geometry of arms."""

import pytest

from aspect_control import Arm
from aspect_control.arm.sources.examples import find_example, load_example_model
from aspect_control.arm.visuals import visual_geometry
from aspect_control.exceptions import ModelError


@pytest.mark.parametrize(
    ("robot", "frame"), [("planar3r", "tool"), ("panda", "panda_hand_tcp"), ("talos", "gripper_left_base_link")]
)
def test_every_shape_hangs_on_a_joint_of_the_arm_or_on_its_base(robot, frame):
    arm = Arm.from_example(robot, frame=frame, task="xy")
    joints = [shape.parentJoint for shape in visual_geometry(arm).geometryObjects]
    assert set(joints) <= set(range(arm.nv + 1))
    assert max(joints) == arm.nv


def test_a_missing_mesh_is_named_with_the_folders_that_were_searched(tmp_path):
    path = find_example("panda").path
    for folders, searched in (([tmp_path], str(tmp_path)), (None, "pass package_dirs")):
        arm = Arm.from_urdf(path, frame="panda_hand_tcp", task="xyz", package_dirs=folders)
        with pytest.raises(ModelError, match=r"link0\.dae could not be found") as caught:
            visual_geometry(arm)
        assert searched in str(caught.value)


def test_an_arm_of_a_pinocchio_model_has_no_visual_geometry():
    arm = Arm.from_pinocchio(load_example_model("panda"), frame="panda_hand_tcp", task="xyz")
    with pytest.raises(ModelError, match="no visual geometry"):
        visual_geometry(arm)
