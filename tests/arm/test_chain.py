"""The chain of an arm against the whole robot it was taken from, and against MuJoCo."""

import math
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aspect_control import Arm, Run, StraightLine, controllers, simulate
from aspect_control.arm.chain import position_limits
from aspect_control.arm.sources.examples import find_example
from aspect_control.arm.sources.urdf import mimic_joints, read_urdf
from aspect_control.exceptions import AspectControlError, JointNotFoundError, ModelError, ParameterError, ShapeError
from conftest import seven_joint_urdf
from example_arms import FRAMES, example_arm, random_motions, random_postures, serial_chain, slopes, whole_model

WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
READY = [0.0, -np.pi / 4, 0.0, -3.0 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4]

every_robot = pytest.mark.parametrize("robot", FRAMES)


def panda(task="xyz", **arguments):
    return Arm.from_example("panda", frame="panda_hand_tcp", task=task, **arguments)


def set_position(model, q, name, position):
    joint = model.joints[model.getJointId(name)]
    values = [position] if joint.nq == 1 else [math.cos(position), math.sin(position)]
    q[joint.idx_q : joint.idx_q + joint.nq] = values


def named_frame(model, name):
    """The frame of that name: the link, where a joint has the same name."""
    link = model.existFrame(name, pin.FrameType.BODY)
    return model.getFrameId(name, pin.FrameType.BODY) if link else model.getFrameId(name)


class Whole:
    """What the whole, unreduced robot does when only the joints of the arm move."""

    def __init__(self, model, arm, q, v, locked):
        full_q, full_v = pin.neutral(model), np.zeros(model.nv)
        for name, position in locked.items():
            set_position(model, full_q, name, position)
        columns = []
        for name in arm.joint_names:
            joint, own = model.joints[model.getJointId(name)], arm.model.joints[arm.model.getJointId(name)]
            full_q[joint.idx_q : joint.idx_q + joint.nq] = q[own.idx_q : own.idx_q + own.nq]
            full_v[joint.idx_v] = v[own.idx_v]
            columns.append(joint.idx_v)
        data, frame = model.createData(), named_frame(model, arm.frame)
        self.M = pin.crba(model, data, full_q, pin.Convention.LOCAL)[np.ix_(columns, columns)]
        self.nle = pin.rnea(model, data, full_q, full_v, np.zeros(model.nv))[columns]
        pin.forwardKinematics(model, data, full_q, full_v, np.zeros(model.nv))
        self.pose = pin.updateFramePlacement(model, data, frame)
        self.J = pin.computeFrameJacobian(model, data, full_q, frame, WORLD_ALIGNED)[:, columns]
        pin.forwardKinematics(model, data, full_q, full_v, np.zeros(model.nv))
        self.drift = pin.getFrameClassicalAcceleration(model, data, frame, WORLD_ALIGNED).vector


def assert_same_dynamics(arm, model, locked, seed):
    for q, v in random_motions(arm, 5, seed):
        state, whole = arm.state(q, v), Whole(model, arm, q, v, locked)
        # Sums of the same numbers in another order: rounding is relative to the largest of them.
        for name in ("M", "nle", "J", "drift"):
            expected = getattr(whole, name)
            rounding = 1e-12 * (1.0 + np.abs(expected).max())
            np.testing.assert_allclose(getattr(state, name), expected, rtol=0, atol=rounding, err_msg=name)
        np.testing.assert_allclose(state.x.homogeneous, whole.pose.homogeneous, rtol=0, atol=1e-13)


def random_locks(model, frame, seed):
    """Positions inside the limits for about a third of the joints, on the chain or off it, but not for its last."""
    rng, last = np.random.default_rng(seed), model.names[model.frames[named_frame(model, frame)].parentJoint]
    lower, upper = position_limits(model)
    locked = {}
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        low, high = max(lower[joint.idx_v], -np.pi), min(upper[joint.idx_v], np.pi)
        if rng.random() < 0.35 and name != last:
            locked[name] = float(rng.uniform(low, high))
    return locked


# Against the whole robot


@every_robot
def test_arm_is_the_chain_of_the_whole_robot(robot):
    assert_same_dynamics(example_arm(robot, "pose"), whole_model(robot), {}, seed=1)


@every_robot
@pytest.mark.parametrize("seed", [2, 3])
def test_arm_with_locked_joints_is_the_chain_of_the_whole_robot(robot, seed):
    model = whole_model(robot)
    locked = random_locks(model, FRAMES[robot], seed)
    arm = Arm.from_example(robot, frame=FRAMES[robot], task="pose", locked=locked)
    assert not set(locked) & set(arm.joint_names)
    assert_same_dynamics(arm, model, locked, seed)


def test_gravity_is_on_in_these_comparisons():
    assert np.abs(example_arm("panda", "pose").state(READY, np.zeros(7)).nle).max() > 1.0


@every_robot
def test_arm_has_the_joints_between_root_and_frame(robot):
    model, arm = whole_model(robot), example_arm(robot)
    joint, chain = model.frames[model.getFrameId(FRAMES[robot])].parentJoint, []
    while joint:
        chain.insert(0, model.names[joint])
        joint = model.parents[joint]
    assert list(arm.joint_names) == [name for name in chain if name not in mimic_joints(arm.description.urdf)]


@every_robot
def test_limits_of_the_arm_are_those_of_its_urdf(robot):
    arm = example_arm(robot)
    joints = {joint.get("name"): joint for joint in ElementTree.fromstring(arm.description.urdf).findall("joint")}
    for i, name in enumerate(arm.joint_names):
        limit = joints[name].find("limit")
        assert arm.torque_limit[i] == float(limit.get("effort"))
        assert arm.velocity_limit[i] == float(limit.get("velocity"))
        bounded = joints[name].get("type") != "continuous"
        expected = [float(limit.get(end)) for end in ("lower", "upper")] if bounded else [-np.inf, np.inf]
        assert [bounds[i] for bounds in arm.position_limits] == expected


def test_panda_has_its_makers_torque_limits():
    assert example_arm("panda").torque_limit.tolist() == [87.0] * 4 + [12.0] * 3


def test_frame_on_an_inner_link_leaves_the_outer_joints_out():
    arm = Arm.from_example("panda", frame="panda_link5", task="xyz")
    assert arm.joint_names == tuple(f"panda_joint{i}" for i in range(1, 6))
    assert_same_dynamics(Arm.from_example("panda", frame="panda_link5", task="pose"), whole_model("panda"), {}, seed=4)


# In these robots a link and a joint have the same name.
NAMESAKES = [("so100", "gripper"), ("z1", "gripperStator"), ("anymal_c", "LF_KFE"), ("b1_z1", "gripperStator")]


@pytest.mark.parametrize(("robot", "frame"), NAMESAKES)
@pytest.mark.parametrize("seed", [20, 21])
def test_frame_is_the_link_where_a_joint_has_the_same_name(robot, frame, seed):
    model = whole_model(robot)
    locked = random_locks(model, frame, seed)
    arm = Arm.from_example(robot, frame=frame, task="pose", locked=locked)
    assert_same_dynamics(arm, model, locked, seed)
    assert [each.name for each in arm.model.frames].count(frame) == [each.name for each in model.frames].count(frame)


@pytest.mark.parametrize(("robot", "frame"), NAMESAKES)
def test_description_with_namesakes_makes_the_same_arm_again(robot, frame):
    for make in (Arm.from_example, lambda name, **rest: Arm.from_pinocchio(whole_model(name), **rest)):
        arm = make(robot, frame=frame, task="xyz")
        assert_same_arm(Arm.from_description(arm.description), arm, seed=22)


def test_finger_belongs_to_the_arm_that_moves_it():
    arm = Arm.from_example("panda", frame="panda_leftfinger", task="xyz")
    assert arm.joint_names == (*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1")


def test_mimic_joint_on_the_chain_is_locked():
    arm = Arm.from_example("panda", frame="panda_rightfinger", task="pose")
    assert arm.joint_names == tuple(f"panda_joint{i}" for i in range(1, 8))
    assert_same_dynamics(arm, whole_model("panda"), {}, seed=5)


def test_mimic_joints_of_a_pinocchio_model_are_locked():
    model = pin.buildModelFromUrdf(str(find_example("baxter").path), mimic=True)
    assert any(joint.nv == 0 for joint in list(model.joints)[1:])
    arm = Arm.from_pinocchio(model, frame="left_gripper", task="pose")
    assert arm.joint_names == example_arm("baxter").joint_names
    assert_same_dynamics(arm, whole_model("baxter"), {}, seed=6)


# Joints of several degrees of freedom


def on_a_base(joint_type):
    """The seven-joint arm on a trunk that a joint of the given type joins to the world."""
    joint = '<joint name="base_joint" type="{}"><parent link="world"/><child link="base"/>{}</joint>'
    axis = '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="0 0 1"/>'
    trunk = f'<link name="world"/>{joint.format(joint_type, axis)}<link name="base"/>'
    return seven_joint_urdf().replace('<link name="base"/>', trunk)


@pytest.mark.parametrize("joint_type", ["floating", "planar"])
def test_base_of_several_degrees_of_freedom_is_locked(joint_type):
    arm = Arm.from_urdf_text(on_a_base(joint_type), frame="tool", task="pose")
    fixed = Arm.from_urdf_text(on_a_base("fixed"), frame="tool", task="pose")
    assert arm.joint_names == fixed.joint_names
    for q, v in random_motions(fixed, 5, seed=7):
        state, expected = arm.state(q, v), fixed.state(q, v)
        for name in ("M", "nle", "J", "drift"):
            np.testing.assert_allclose(getattr(state, name), getattr(expected, name), rtol=0, atol=1e-11)
        np.testing.assert_allclose(state.x.homogeneous, expected.x.homogeneous, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("joint_type", "freedoms"), [("floating", 6), ("planar", 3)])
def test_base_of_several_degrees_of_freedom_has_no_one_position(joint_type, freedoms):
    message = f"joint 'base_joint' has {freedoms} degrees of freedom and cannot be locked at one position"
    with pytest.raises(ParameterError, match=message):
        Arm.from_urdf_text(on_a_base(joint_type), frame="tool", task="xyz", locked={"base_joint": 0.0})


def test_frame_that_only_a_floating_base_moves_is_an_error():
    with pytest.raises(ModelError, match=r"no joint is left to move 'base': all of \['base_joint'\] are locked"):
        Arm.from_urdf_text(on_a_base("floating"), frame="base", task="xyz")


# Continuous joints


angles = arrays(np.float64, 6, elements=st.floats(-100.0, 100.0))


@given(positions=angles)
def test_positions_undo_configuration_but_for_whole_turns(positions):
    arm = example_arm("kinova")
    again = arm.positions(arm.configuration(positions))
    continuous = np.isinf(arm.position_limits[0])
    assert continuous.tolist() == [True, False, False, True, False, True]
    np.testing.assert_array_equal(again[~continuous], positions[~continuous])
    assert np.abs(again[continuous]).max() <= np.pi
    # The cosine and sine of 100 rad are as exact as the angle itself: 100 machine precisions.
    turns = (again - positions)[continuous] / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), rtol=0, atol=1e-13)


@given(positions=angles)
def test_configuration_undoes_positions(positions):
    arm = example_arm("kinova")
    q = arm.configuration(positions)
    assert q.shape == (arm.nq,) == (9,)
    np.testing.assert_allclose(arm.configuration(arm.positions(q)), q, rtol=0, atol=1e-15)


def test_configuration_of_ordinary_joints_is_their_positions():
    assert example_arm("panda").configuration(READY).tolist() == READY


OF_A_CONFIGURATION = (
    "jacobian",
    "jacobian_derivative",
    "minors_on_border",
    "positions",
    "require_within_limits",
    "skeleton",
    "skeleton_jacobians",
    "state",
    "task_position",
)


@pytest.mark.parametrize("function", OF_A_CONFIGURATION)
def test_q_that_is_not_normalised_is_refused(function):
    arm = example_arm("kinova")
    q = arm.configuration(np.full(6, 1.0))
    q[0] += 0.01
    velocity = [np.zeros(arm.nv)] if function == "state" else []
    with pytest.raises(ParameterError, match=r"cosine and sine .* must have length 1.*arm\.configuration\(positions\)"):
        getattr(arm, function)(q, *velocity)


def test_q_that_is_normalised_to_rounding_is_taken():
    arm = example_arm("kinova")
    q = arm.configuration(np.full(6, 1.0)) * (1.0 + 1e-9)
    assert np.isfinite(arm.jacobian(q)).all()


@pytest.mark.parametrize("bad", [np.zeros(5), np.zeros(7), np.zeros(9), 0.0, "abc"])
def test_configuration_of_another_number_of_positions_is_an_error(bad):
    with pytest.raises(ShapeError, match="positions must"):
        example_arm("kinova").configuration(bad)


@pytest.mark.parametrize("robot", ["kinova", "pr2", "panda"])
def test_difference_undoes_integrate_on_the_manifold(robot):
    arm = example_arm(robot)
    for q, v in random_motions(arm, 20, seed=8):
        # Continuous joints turn by less than half a turn.
        np.testing.assert_allclose(arm.difference(q, arm.integrate(q, v)), v, rtol=0, atol=1e-13)


# Prismatic joints


@pytest.mark.parametrize("robot", ["pr2", "tiago", "tiago_dual"])
def test_lifting_torso_lifts_the_frame(robot):
    arm = example_arm(robot)
    assert arm.joint_names[0] == "torso_lift_joint"
    lift = 0.125 * np.eye(arm.nv)[0]
    for q in random_postures(arm, 5, seed=9):
        np.testing.assert_allclose(arm.jacobian(q)[:, 0], [0.0, 0.0, 1.0], rtol=0, atol=1e-15)
        rise = arm.task_position(arm.integrate(q, lift)) - arm.task_position(q)
        np.testing.assert_allclose(rise, [0.0, 0.0, 0.125], rtol=0, atol=1e-15)


def test_lifting_torso_carries_the_weight_of_all_above_it():
    arm, model = example_arm("pr2"), whole_model("pr2")
    torso = model.getJointId("torso_lift_joint")
    mass = sum(model.inertias[joint].mass for joint in model.subtrees[torso])
    for q in random_postures(arm, 5, seed=10):
        assert arm.state(q, np.zeros(arm.nv)).nle[0] == pytest.approx(9.81 * mass, rel=1e-13)


# The derivative of the Jacobian


@pytest.mark.parametrize("robot", ["panda", "kinova", "pr2"])
def test_jacobian_derivative_is_the_slope_of_the_jacobian(robot):
    arm = example_arm(robot, "pose")
    for q in random_postures(arm, 10, seed=11):
        # step⁴ of truncation, 1e-16, and 1e-16 / step of rounding, 1e-12.
        np.testing.assert_allclose(arm.jacobian_derivative(q), slopes(arm, arm.jacobian, q), rtol=0, atol=1e-11)


@pytest.mark.parametrize("robot", ["panda", "kinova", "pr2"])
def test_drift_is_the_jacobian_derivative_contracted_twice_with_the_velocity(robot):
    arm = example_arm(robot, "pose")
    for q, v in random_motions(arm, 20, seed=12):
        expected = np.einsum("ijk,j,k->i", arm.jacobian_derivative(q), v, v)
        np.testing.assert_allclose(arm.state(q, v).drift, expected, rtol=0, atol=1e-12)


# Against MuJoCo


def mujoco_panda():
    """Panda without meshes and with its fingers welded at zero, where the arm locks them."""
    robot = ElementTree.fromstring(read_urdf(find_example("panda").path))
    for link in robot.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for joint in robot.findall("joint"):
        if "finger" in joint.get("name"):
            joint.set("type", "fixed")
            for part in [*joint.findall("mimic"), *joint.findall("limit")]:
                joint.remove(part)
    compiler = ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler")
    compiler.set("fusestatic", "false")
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(robot, encoding="unicode"))
    return model, mujoco.MjData(model)


def test_panda_agrees_with_mujoco():
    model, data = mujoco_panda()
    arm = example_arm("panda", "pose")
    tcp = model.body("panda_hand_tcp").id
    assert model.nv == 7
    M, J = np.zeros((7, 7)), np.zeros((6, 7))
    for q, v in random_motions(arm, 50, seed=13):
        data.qpos, data.qvel = q, v
        mujoco.mj_forward(model, data)
        for column, unit in zip(M, np.eye(7), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        mujoco.mj_jacBody(model, data, J[:3], J[3:], tcp)
        state = arm.state(q, v)
        # The URDF gives orientations as roll, pitch and yaw and inertias off their principal axes; MuJoCo turns both
        # into quaternions and principal moments.
        np.testing.assert_allclose(state.M, M, rtol=0, atol=1e-9)
        np.testing.assert_allclose(state.nle, data.qfrc_bias, rtol=0, atol=1e-8)
        np.testing.assert_allclose(state.J, J, rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.x.translation, data.xpos[tcp], rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.x.rotation.ravel(), data.xmat[tcp], rtol=0, atol=1e-10)


# From a Pinocchio model and from a description


def assert_same_arm(arm, other, seed, rounding=0.0):
    assert (arm.name, arm.frame, arm.task, arm.joint_names) == (other.name, other.frame, other.task, other.joint_names)
    for name in ("gravity", "torque_limit", "velocity_limit"):
        np.testing.assert_array_equal(getattr(arm, name), getattr(other, name))
    np.testing.assert_array_equal(arm.position_limits, other.position_limits)
    for q, v in random_motions(other, 5, seed):
        state, expected = arm.state(q, v), other.state(q, v)
        for name in ("M", "nle", "J", "drift", "dx"):
            ours, theirs = getattr(state, name), getattr(expected, name)
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=rounding * np.abs(theirs).max())
        np.testing.assert_array_equal(arm.coordinates.encode(state.x), other.coordinates.encode(expected.x))


LOCKED = {
    "panda": {"panda_joint3": 0.7, "panda_finger_joint1": 0.03, "panda_finger_joint2": 0.01},
    "kinova": {"j2s6s200_joint_1": 2.5, "j2s6s200_joint_3": 2.0},
    "pr2": {"torso_lift_joint": 0.2, "r_forearm_roll_joint": -2.5, "l_forearm_roll_joint": 2.0, "head_pan_joint": 1.0},
    "talos": {"torso_1_joint": 0.4, "arm_right_2_joint": -1.5, "leg_left_4_joint": 0.9},
}


@pytest.mark.parametrize("robot", LOCKED)
@pytest.mark.parametrize("task", ["xyz", "pose"])
def test_arm_of_a_pinocchio_model_is_that_of_its_urdf(robot, task):
    model = whole_model(robot)
    # Pinocchio's model does not know which joints of the URDF are mimic joints.
    locked = LOCKED[robot]
    arm = Arm.from_pinocchio(model, frame=FRAMES[robot], task=task, locked=locked)
    # A model is written down as numbers, of which Pinocchio rounds the centre of mass once more.
    assert_same_arm(
        arm, Arm.from_example(robot, frame=FRAMES[robot], task=task, locked=locked), seed=14, rounding=1e-14
    )


@pytest.mark.parametrize("robot", LOCKED)
@pytest.mark.parametrize("locked", [False, True], ids=["free", "locked"])
@pytest.mark.parametrize("source", ["urdf", "model"])
def test_description_makes_the_same_arm_again(robot, locked, source):
    arguments = {"frame": FRAMES[robot], "task": ("rz", "x"), "gravity": (0.5, 1.0, -9.0)}
    arguments["locked"] = LOCKED[robot] if locked else None
    if source == "urdf":
        arm = Arm.from_example(robot, **arguments)
    else:
        arm = Arm.from_pinocchio(whole_model(robot), **arguments)
    assert (arm.description.urdf is None, arm.description.chain is None) == (source == "model", source == "urdf")
    again = Arm.from_description(arm.description)
    assert again.description == arm.description
    assert_same_arm(again, arm, seed=15)


def test_description_of_a_model_keeps_numbers_without_a_short_decimal():
    model = serial_chain(4)
    model.inertias[2].mass = 1.0 / 3.0
    model.jointPlacements[3].translation = np.full(3, 0.1 / 3.0)
    arm = Arm.from_pinocchio(model, frame="tip", task="xy")
    assert_same_arm(Arm.from_description(arm.description), arm, seed=16)


@pytest.mark.parametrize("limit", [np.inf, 1e308])
def test_description_of_a_model_keeps_that_it_has_no_limits(limit):
    model = serial_chain(4)
    model.lowerPositionLimit[:], model.upperPositionLimit[:], model.effortLimit[:] = -limit, limit, limit
    arm = Arm.from_pinocchio(model, frame="tip", task="xy")
    assert arm.torque_limit.tolist() == [np.inf] * 4
    assert_same_arm(Arm.from_description(arm.description), arm, seed=17)


def test_gravity_of_a_pinocchio_model_is_its_own_unless_given():
    model = serial_chain(4)
    model.gravity.linear = np.array([1.0, 2.0, 3.0])
    assert Arm.from_pinocchio(model, frame="tip", task="xy").gravity.tolist() == [1.0, 2.0, 3.0]
    given = Arm.from_pinocchio(model, frame="tip", task="xy", gravity=(0.0, 0.0, -1.0))
    assert given.gravity.tolist() == [0.0, 0.0, -1.0]
    assert model.gravity.linear.tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("locked", [None, {"joint3": 0.5}], ids=["whole", "reduced"])
def test_pinocchio_model_is_copied(locked):
    model = serial_chain(5)
    arm = Arm.from_pinocchio(model, frame="tip", task="xyz", locked=locked)
    unchanged = Arm.from_pinocchio(model.copy(), frame="tip", task="xyz", locked=locked)
    model.inertias[2].mass = 50.0
    model.jointPlacements[2].translation = np.ones(3)
    model.gravity.linear = np.zeros(3)
    model.effortLimit[:] = 1.0
    assert_same_arm(arm, unchanged, seed=18)
    assert_same_arm(Arm.from_description(arm.description), unchanged, seed=18)


def test_rotor_inertia_of_the_chain_belongs_to_its_inertia_matrix():
    model = serial_chain(4)
    plain = Arm.from_pinocchio(model, frame="tip", task="xy", locked={"joint2": 0.3})
    model.armature[:] = [0.1, 0.2, 0.3, 0.4]
    arm = Arm.from_pinocchio(model, frame="tip", task="xy", locked={"joint2": 0.3})
    q, v = np.array([0.3, 0.7, -1.1]), np.zeros(3)
    added = arm.state(q, v).M - plain.state(q, v).M
    np.testing.assert_allclose(added, np.diag([0.1, 0.3, 0.4]), rtol=0, atol=1e-15)


@pytest.mark.parametrize("model", [None, "panda.urdf", 3, pin.Data()], ids=["None", "path", "number", "data"])
def test_what_is_no_pinocchio_model_is_an_error(model):
    with pytest.raises(ModelError, match=rf"from_pinocchio takes a pin\.Model, got {type(model).__name__}"):
        Arm.from_pinocchio(model, frame="tip", task="xy")


# Locked joints


def test_locked_joint_leaves_the_arm():
    arm = panda(locked={"panda_joint3": 0.5})
    assert arm.joint_names == tuple(f"panda_joint{i}" for i in (1, 2, 4, 5, 6, 7))
    q = np.array(READY)
    q[2] = 0.5
    expected = example_arm("panda").task_position(q)
    np.testing.assert_allclose(arm.task_position(np.delete(q, 2)), expected, rtol=0, atol=1e-14)


def test_unknown_locked_joint_names_the_nearest():
    with pytest.raises(JointNotFoundError, match="unknown joint 'panda_join3' in 'panda': did you mean 'panda_joint3'"):
        panda(locked={"panda_join3": 0.0})


@pytest.mark.parametrize("name", ["universe", "", 3, None])
def test_what_is_no_joint_cannot_be_locked(name):
    with pytest.raises(JointNotFoundError, match="unknown joint"):
        panda(locked={name: 0.0})


@pytest.mark.parametrize("bad", [True, np.nan, np.inf, -np.inf, "0.5", None, [0.5], 1j])
def test_locked_position_that_is_no_finite_number_is_an_error(bad):
    message = rf"locked\['panda_joint3'\] must be a finite number, got {re.escape(repr(bad))}"
    with pytest.raises(ParameterError, match=message):
        panda(locked={"panda_joint3": bad})


@pytest.mark.parametrize("position", [0, 1, np.float64(0.5)])
def test_locked_position_may_be_any_number(position):
    assert panda(locked={"panda_joint3": position}).nv == 6


# Panda's second joint goes from −1.7628 to 1.7628 rad, ±101 degrees.
DEGREES = {45.0: "0.785398", -90.0: "-1.5708", 101.0: "1.76278"}


@pytest.mark.parametrize(("position", "radians"), DEGREES.items())
def test_locked_position_in_degrees_is_hinted_at(position, radians):
    message = rf"= {position:g} is outside the limits \[-1\.7628, 1\.7628\]; is it in degrees\? .*radians: {radians}$"
    with pytest.raises(ParameterError, match=message):
        panda(locked={"panda_joint2": position})


@pytest.mark.parametrize("position", [1.8, -3.0, 6.0, 180.0, -102.0])
def test_locked_position_that_cannot_be_in_degrees_gets_no_hint(position):
    message = rf"locked\['panda_joint2'\] = {position:g} is outside the limits \[-1\.7628, 1\.7628\]$"
    with pytest.raises(ParameterError, match=message):
        panda(locked={"panda_joint2": position})


def test_locked_position_in_millimetres_is_hinted_at():
    message = r"locked\['torso_lift_joint'\] = 200 is outside the limits .*; is it in millimetres\? .* in metres$"
    with pytest.raises(ParameterError, match=message):
        Arm.from_example("pr2", frame=FRAMES["pr2"], task="xyz", locked={"torso_lift_joint": 200.0})


def test_locked_position_beyond_the_limits_in_millimetres_gets_no_hint():
    with pytest.raises(ParameterError, match=r"= 2000 is outside the limits \[[^]]*\]$"):
        Arm.from_example("pr2", frame=FRAMES["pr2"], task="xyz", locked={"torso_lift_joint": 2000.0})


def test_locked_joint_may_stand_at_its_limit():
    assert panda(locked={"panda_joint2": 1.7628, "panda_finger_joint1": 0.0}).nv == 6


def test_locked_continuous_joint_may_stand_anywhere():
    arm = Arm.from_example("kinova", frame=FRAMES["kinova"], task="xyz", locked={"j2s6s200_joint_1": 100.0})
    assert_same_arm(
        Arm.from_example("kinova", frame=FRAMES["kinova"], task="xyz", locked={"j2s6s200_joint_1": 100.0}), arm, seed=19
    )
    q = np.concatenate([[100.0], np.full(5, 1.0)])
    expected = example_arm("kinova").task_position(example_arm("kinova").configuration(q))
    np.testing.assert_allclose(arm.task_position(arm.configuration(q[1:])), expected, rtol=0, atol=1e-13)


def test_locking_every_joint_of_the_chain_is_an_error():
    locked = {f"panda_joint{i}": -1.0 if i == 4 else 1.0 for i in range(1, 8)}
    with pytest.raises(ModelError, match=r"no joint is left to move 'panda_hand_tcp': all of \['panda_joint1', .*7'\]"):
        panda(locked=locked)


# Bad frames and descriptions


@pytest.mark.parametrize("frame", ["panda_link0", "universe"])
def test_frame_on_the_base_is_an_error(frame):
    with pytest.raises(ModelError, match=rf"frame '{frame}' of 'panda' is on the base.*; try 'panda_hand_tcp'"):
        Arm.from_example("panda", frame=frame, task="xyz")


def test_massless_chain_is_an_error():
    text = re.sub(r"<inertial>.*?</inertial>", "", seven_joint_urdf(), flags=re.DOTALL)
    with pytest.raises(ModelError, match=r"'seven' has a singular inertia matrix .*every joint must move a mass"):
        Arm.from_urdf_text(text, frame="tool", task="xyz")


def test_mass_off_the_chain_does_not_make_up_for_none_on_it():
    massless = '<link name="tip"/>{}'.format(
        '<joint name="tip_joint" type="revolute"><parent link="tool"/><child link="tip"/><axis xyz="0 0 1"/>'
        '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
    )
    text = seven_joint_urdf().replace("</robot>", massless + "</robot>")
    assert Arm.from_urdf_text(text, frame="tool", task="xyz").nv == 7
    with pytest.raises(ModelError, match="singular inertia matrix"):
        Arm.from_urdf_text(text, frame="tip", task="xyz")


def test_broken_urdf_of_a_description_is_a_model_error():
    description = example_arm("panda").description
    with pytest.raises(ModelError, match="the recorded URDF is not well-formed XML"):
        Arm.from_description(replace(description, urdf=description.urdf[:1000]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kind": "JointModelFreeFlyer"}, "unknown kind 'JointModelFreeFlyer'"),
        ({"kind": "Model"}, "unknown kind 'Model'"),
        ({"name": "universe"}, "a name of its own"),
        ({"placement": [0.0] * 12}, "no rotation matrix"),
        ({"limits": [0.0, 1.0]}, "four limits"),
        ({"limits": [0.0, 1.0, np.nan, 1.0]}, "four limits"),
        ({"axis": [1.0, 0.0, 0.0]}, "the axis of 'joint1' must have shape"),
        ({"placement": [0.0] * 11}, "the placement of 'joint1' must have shape"),
        ({"inertia": [np.nan] * 13}, "the inertia of 'joint1' must be finite"),
        ({"inertia": [0.0] * 13}, "singular inertia matrix"),
    ],
)
def test_a_recorded_chain_that_is_none_is_an_error(changes, words):
    description = Arm.from_pinocchio(serial_chain(1), frame="tip", task=("x",)).description
    joints = [replace(description.chain.joints[0], **{"name": "joint1", **changes})]
    with pytest.raises(AspectControlError, match=re.escape(words)):
        Arm.from_description(replace(description, chain=replace(description.chain, joints=joints)))


def test_description_without_a_model_is_a_model_error():
    with pytest.raises(ModelError, match="neither a URDF nor a chain"):
        Arm.from_description(replace(example_arm("panda").description, urdf=None))


# Joint limits


def test_posture_inside_the_limits_is_accepted():
    example_arm("panda").require_within_limits(READY)


def test_posture_at_its_limits_is_accepted():
    arm = example_arm("panda")
    for bounds in arm.position_limits:
        arm.require_within_limits(bounds)


def test_posture_in_degrees_names_the_joint_and_the_unit():
    message = (
        r"joint 'panda_joint2' at -45 is outside its limits \[-1\.7628, 1\.7628\]; is it in degrees\? .* -0\.785398$"
    )
    with pytest.raises(ParameterError, match=message):
        example_arm("panda").require_within_limits(np.rad2deg(READY))


def test_posture_just_outside_a_limit_names_the_joint():
    with pytest.raises(ParameterError, match=r"joint 'panda_joint6' at -0\.5 is outside its limits \[[^]]*\]$"):
        example_arm("panda").require_within_limits([*READY[:5], -0.5, READY[6]])


def test_posture_in_millimetres_names_the_joint_and_the_unit():
    arm = example_arm("pr2")
    q = arm.configuration(np.array([200.0, *np.zeros(4), 0.0, -1.0, 0.0]))
    with pytest.raises(ParameterError, match=r"joint 'torso_lift_joint' at 200 .*; is it in millimetres\?"):
        arm.require_within_limits(q)


def test_continuous_joints_have_no_limits():
    arm = example_arm("kinova")
    for angle in np.linspace(-10.0, 10.0, 21):
        arm.require_within_limits(arm.configuration([angle, 3.0, 3.0, angle, 3.0, angle]))


def test_a_hand_made_model_without_joint_frames_can_have_joints_locked():
    model = pin.Model()
    for i in range(3):
        joint = model.addJoint(i, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.2, 0.0, 0.1])), f"j{i}")
        model.appendBodyToJoint(joint, pin.Inertia.FromBox(1.0, 0.1, 0.2, 0.3), pin.SE3.Identity())
    model.addFrame(pin.Frame("tip", 3, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    locked = Arm.from_pinocchio(model, frame="tip", task=("x", "z"), locked={"j1": 0.1})
    whole = Arm.from_pinocchio(model, frame="tip", task=("x", "z"))
    np.testing.assert_allclose(locked.jacobian([0.3, 0.5]), whole.jacobian([0.3, 0.1, 0.5])[:, [0, 2]], atol=1e-14)
    assert np.isinf([*locked.torque_limit, *locked.velocity_limit, *locked.position_limits[1]]).all()


# A continuous joint about an axis that is none of x, y and z

SLANTED = """
  <joint name="{name}" type="continuous">
    <parent link="{parent}"/><child link="{child}"/><origin xyz="0.3 0.1 0.2" rpy="0.1 {turn} 0.3"/><axis xyz="{axis}"/>
  </joint>
  <link name="{child}"><inertial>
    <origin xyz="0.1 0.05 0.02"/><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>
  </inertial></link>"""


def slanted_urdf(seed, joints=8):
    axes = np.random.default_rng(seed).normal(size=(joints, 3))
    axes[1] = [0.0, 0.0, -1.0]
    parts = [
        SLANTED.format(
            name=f"joint{i}",
            parent=f"link{i - 1}" if i else "base",
            child=f"link{i}",
            turn=i,
            axis=" ".join(map(repr, axis)),
        )
        for i, axis in enumerate(axes.tolist())
    ]
    return f'<robot name="slanted"><link name="base"/>{"".join(parts)}</robot>'


@pytest.mark.parametrize("seed", range(5))
def test_continuous_joints_about_slanted_axes_can_be_taken_from_a_pinocchio_model(seed, tmp_path):
    text = slanted_urdf(seed)
    model = pin.buildModelFromXML(text)
    assert "JointModelRevoluteUnboundedUnaligned" in {joint.shortname() for joint in model.joints}
    options = {"frame": "link7", "task": "xyz"}
    arm, read = Arm.from_pinocchio(model, **options), Arm.from_urdf_text(text, **options)
    line = StraightLine([0.02, 0.01, 0.0], 0.1)
    run = simulate(controllers.create("pseudoinverse", arm), line, q0=arm.configuration(np.linspace(0, 1, 8)), dt=0.02)
    run.save(tmp_path / "run.npz")
    loaded = Run.load(tmp_path / "run.npz").arm
    rng = np.random.default_rng(seed)
    for _ in range(20):
        q, v = arm.configuration(rng.uniform(-np.pi, np.pi, 8)), rng.normal(size=8)
        ours, again, reference = arm.state(q, v), loaded.state(q, v), read.state(q, v)
        for name in ("M", "nle", "J", "drift", "x"):
            assert np.array_equal(getattr(ours, name), getattr(again, name))
            assert np.allclose(getattr(ours, name), getattr(reference, name), rtol=1e-12, atol=1e-12)
