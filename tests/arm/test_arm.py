"""The arm against a closed-form model, finite differences and MuJoCo; and what it says to bad input."""

import re

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aspect_control import Arm
from aspect_control.exceptions import FrameNotFoundError, ModelError, NonFiniteError, ShapeError, TaskError
from aspect_control.resources import model_path
from oracles import planar_reference as reference

PINNED = '<robot name="pinned"><link name="a"/><link name="b"/>{joint}</robot>'
FIXED = '<joint name="weld" type="fixed"><parent link="a"/><child link="b"/></joint>'

angles = arrays(np.float64, 3, elements=st.floats(-10.0, 10.0))
speeds = arrays(np.float64, 3, elements=st.floats(-10.0, 10.0))


def random_states(arm, count, seed):
    rng = np.random.default_rng(seed)
    return zip(rng.uniform(-np.pi, np.pi, (count, arm.nq)), rng.uniform(-3.0, 3.0, (count, arm.nv)), strict=True)


def central_difference(function, q, step):
    """Return ∂f/∂q_k along the last axis; the error is of the order step² + ε/step."""
    shifts = step * np.eye(q.size)
    return np.stack([(function(q + shift) - function(q - shift)) / (2.0 * step) for shift in shifts], axis=-1)


def load(text, frame="tool", task="xy"):
    return Arm.from_urdf_text(text, frame=frame, task=task)


# Against the closed-form arm


def test_state_agrees_with_the_closed_form_arm(planar):
    for q, v in random_states(planar, 500, seed=1):
        state = planar.state(q, v)
        np.testing.assert_allclose(state.M, reference.inertia(q), rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.nle, reference.nonlinear_effects(q, v), rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.J, reference.jacobian(q), rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.drift, reference.drift(q, v), rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.x, reference.position(q), rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.dx, reference.jacobian(q) @ v, rtol=0, atol=1e-10)


@given(q=angles, v=speeds)
def test_nonlinear_effects_agree_with_the_closed_form_arm_at_any_state(planar, q, v):
    # N grows with the square of the speed, and so does its rounding error.
    tolerance = 1e-12 * (1.0 + v @ v)
    np.testing.assert_allclose(planar.state(q, v).nle, reference.nonlinear_effects(q, v), rtol=0, atol=tolerance)


def test_gravity_adds_the_gradient_of_the_potential_energy(planar_path):
    upright = Arm.from_urdf(planar_path, frame="tool", task="xy", gravity=(0.0, -9.81, 0.0))
    for q, v in random_states(upright, 500, seed=2):
        expected = reference.nonlinear_effects(q, v, gravity=9.81)
        np.testing.assert_allclose(upright.state(q, v).nle, expected, rtol=0, atol=1e-10)


def test_gravity_is_the_earths_by_default(planar_path):
    assert Arm.from_urdf(planar_path, frame="tool", task="xy").gravity.tolist() == [0.0, 0.0, -9.81]


def test_reference_inertia_derivative_is_the_derivative_of_its_inertia():
    q = np.array([0.3, -1.1, 2.2])
    expected = central_difference(reference.inertia, q, step=1e-5)
    np.testing.assert_allclose(reference.inertia_derivative(q), expected, rtol=0, atol=1e-8)


def test_reference_gradient_is_the_derivative_of_its_minor_measure():
    q = np.array([0.3, -1.1, 2.0])
    expected = central_difference(reference.minor_measure, q, step=1e-5)
    np.testing.assert_allclose(reference.minor_measure_gradient(q), expected, rtol=0, atol=1e-8)


# Against itself


def test_jacobian_is_the_derivative_of_the_task_position(arm):
    for q, _ in random_states(arm, 20, seed=3):
        expected = central_difference(arm.task_position, q, step=1e-5)
        np.testing.assert_allclose(arm.jacobian(q), expected, rtol=0, atol=1e-8)


def test_jacobian_derivative_is_the_derivative_of_the_jacobian(arm):
    for q, _ in random_states(arm, 50, seed=4):
        expected = central_difference(arm.jacobian, q, step=1e-5)
        np.testing.assert_allclose(arm.jacobian_derivative(q), expected, rtol=0, atol=1e-8)


def test_drift_is_the_rate_of_change_of_the_jacobian_times_the_velocity(arm):
    step = 1e-5
    for q, v in random_states(arm, 100, seed=5):
        rate = (arm.jacobian(q + step * v) - arm.jacobian(q - step * v)) / (2.0 * step)
        # |q'''| step² / 6 grows with |v|³: about 1e-8 at 3 rad/s a joint.
        np.testing.assert_allclose(arm.state(q, v).drift, rate @ v, rtol=0, atol=1e-6)


def test_drift_is_the_jacobian_derivative_contracted_twice_with_the_velocity(arm):
    for q, v in random_states(arm, 100, seed=6):
        expected = np.einsum("ijk,j,k->i", arm.jacobian_derivative(q), v, v)
        np.testing.assert_allclose(arm.state(q, v).drift, expected, rtol=0, atol=1e-11)


def test_state_and_its_own_functions_agree(arm):
    for q, v in random_states(arm, 20, seed=7):
        state = arm.state(q, v)
        np.testing.assert_allclose(state.J, arm.jacobian(q), rtol=0, atol=1e-14)
        np.testing.assert_allclose(state.x, arm.task_position(q), rtol=0, atol=1e-14)


def test_inertia_is_symmetric_and_positive_definite(arm):
    for q, v in random_states(arm, 100, seed=8):
        M = arm.state(q, v).M
        np.testing.assert_array_equal(M, M.T)
        assert np.linalg.eigvalsh(M)[0] > 0.0


def test_state_is_not_changed_by_the_next_one(arm):
    (q, v), (other_q, other_v) = random_states(arm, 2, seed=9)
    state, derivative = arm.state(q, v), arm.jacobian_derivative(q)
    names = ("M", "nle", "J", "drift", "x", "dx")
    before = [getattr(state, name).copy() for name in names]
    derivative_before = derivative.copy()
    arm.state(other_q, other_v)
    arm.jacobian_derivative(other_q)
    for name, array in zip(names, before, strict=True):
        np.testing.assert_array_equal(getattr(state, name), array)
    np.testing.assert_array_equal(derivative, derivative_before)


def test_state_is_not_changed_by_its_callers_arrays(planar):
    q, v = np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.5, 0.6])
    state = planar.state(q, v)
    q[:], v[:] = 7.0, 7.0
    assert state.q.tolist() == [0.1, 0.2, 0.3]
    assert state.v.tolist() == [0.4, 0.5, 0.6]


def test_skeleton_runs_through_the_joints_to_the_tip(planar):
    for q, _ in random_states(planar, 20, seed=10):
        angles = np.cumsum(q)
        steps = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
        expected = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
        np.testing.assert_allclose(planar.skeleton(q), expected, rtol=0, atol=1e-14)


def test_skeleton_ends_at_the_task_position(seven):
    q = np.linspace(-1.0, 1.0, 7)
    skeleton = seven.skeleton(q)
    assert skeleton.shape == (8, 3)
    np.testing.assert_array_equal(skeleton[-1], seven.task_position(q))


def test_task_rows_stand_in_the_order_given(planar, planar_path):
    swapped = Arm.from_urdf(planar_path, frame="tool", task=("y", "x"), gravity=(0.0, 0.0, 0.0))
    q, v = np.array([0.3, 0.7, -1.1]), np.array([1.0, -2.0, 0.5])
    state, other = planar.state(q, v), swapped.state(q, v)
    for name in ("J", "drift", "x", "dx"):
        np.testing.assert_array_equal(getattr(other, name), getattr(state, name)[::-1])
    np.testing.assert_array_equal(swapped.jacobian_derivative(q), planar.jacobian_derivative(q)[::-1])


@pytest.mark.parametrize(
    ("task", "axes"), [("xz", ("x", "z")), ("yz", ("y", "z")), (["z"], ("z",)), ("xyz", ("x", "y", "z"))]
)
def test_task_selects_rows_of_the_position(planar_path, task, axes):
    arm = Arm.from_urdf(planar_path, frame="tool", task=task)
    assert arm.task == axes
    assert (arm.task_dim, arm.redundancy) == (len(axes), 3 - len(axes))
    position = np.append(reference.position([0.3, 0.7, -1.1]), 0.0)
    expected = [position["xyz".index(axis)] for axis in axes]
    np.testing.assert_allclose(arm.task_position([0.3, 0.7, -1.1]), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("frame", "joints", "moved_by"), [("link2", 2, 1), ("joint3", 3, 2), ("tool_joint", 3, 3)])
def test_frame_may_be_any_link_or_joint(planar, planar_path, frame, joints, moved_by):
    arm = Arm.from_urdf(planar_path, frame=frame, task="xy")
    assert arm.joint_names == planar.joint_names[:joints]
    J = arm.jacobian([0.3, 0.7, -1.1][:joints])
    assert np.any(J != 0.0, axis=0).tolist() == [i < moved_by for i in range(joints)]


def test_path_may_be_a_string(planar_path):
    assert Arm.from_urdf(str(planar_path), frame="tool", task="xy").description.urdf == planar_path.read_text(
        encoding="utf-8"
    )


def test_arm_names_itself(planar):
    assert repr(planar) == "Arm('planar3r', frame='tool', task=('x', 'y'), nv=3, task_dim=2)"
    assert planar.joint_names == ("joint1", "joint2", "joint3")


def test_difference_undoes_integrate(arm):
    for q, v in random_states(arm, 20, seed=11):
        np.testing.assert_allclose(arm.difference(q, arm.integrate(q, v)), v, rtol=0, atol=1e-14)


def test_state_accepts_lists(planar):
    np.testing.assert_array_equal(planar.state([1, 2, 3], [0, 0, 0]).J, planar.jacobian(np.array([1.0, 2.0, 3.0])))


# Against MuJoCo


def mujoco_model(arm):
    # MuJoCo would otherwise merge the tool into the last link.
    settings = '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    # MuJoCo asks for positive principal inertias; about a rod's own axis any value goes in planar motion.
    text = arm.description.urdf.replace('ixx="0"', 'ixx="1e-3"').replace("</robot>", settings)
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.gravity = arm.gravity
    return model, mujoco.MjData(model)


def mujoco_inertia(model, data):
    M = np.zeros((model.nv, model.nv))
    for column, unit in zip(M, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    return M


def test_dynamics_agree_with_mujoco(arm):
    model, data = mujoco_model(arm)
    for q, v in random_states(arm, 200, seed=12):
        data.qpos, data.qvel = q, v
        mujoco.mj_forward(model, data)
        state = arm.state(q, v)
        np.testing.assert_allclose(state.M, mujoco_inertia(model, data), rtol=0, atol=1e-10)
        np.testing.assert_allclose(state.nle, data.qfrc_bias, rtol=0, atol=1e-9)


def test_kinematics_agree_with_mujoco(seven):
    model, data = mujoco_model(seven)
    tool = model.body("tool").id
    for q, v in random_states(seven, 200, seed=13):
        data.qpos, data.qvel = q, v
        mujoco.mj_forward(model, data)
        J = np.zeros((3, 7))
        mujoco.mj_jacBody(model, data, J, None, tool)
        state = seven.state(q, v)
        np.testing.assert_allclose(state.x, data.xpos[tool], rtol=0, atol=1e-12)
        np.testing.assert_allclose(state.J, J, rtol=0, atol=1e-12)


# Bad descriptions


def test_missing_urdf_lists_those_beside_it(tmp_path):
    (tmp_path / "panda.urdf").touch()
    with pytest.raises(ModelError, match=r"no such URDF file: .*pnda\.urdf; that folder has panda\.urdf"):
        Arm.from_urdf(tmp_path / "pnda.urdf", frame="tool", task="xy")


def test_missing_urdf_in_an_empty_or_missing_folder_says_so(tmp_path):
    with pytest.raises(ModelError, match="there is no URDF file in"):
        Arm.from_urdf(tmp_path / "arm.urdf", frame="tool", task="xy")
    with pytest.raises(ModelError, match="there is no URDF file in"):
        Arm.from_urdf(tmp_path / "missing" / "arm.urdf", frame="tool", task="xy")


def test_unreadable_urdf_is_a_model_error(tmp_path):
    (tmp_path / "latin.urdf").write_bytes(b'<robot name="\xe9"/>')
    with pytest.raises(ModelError, match="cannot read URDF file"):
        Arm.from_urdf(tmp_path / "latin.urdf", frame="tool", task="xy")
    with pytest.raises(ModelError, match="cannot read URDF file"):
        Arm.from_urdf(tmp_path, frame="tool", task="xy")


def test_unknown_resource_lists_those_that_ship():
    with pytest.raises(ModelError, match=r"no robot description 'nosuch\.urdf'.*there are: .*planar3r\.urdf"):
        model_path("nosuch.urdf")


BROKEN = {
    "empty": ("", "not well-formed XML: no element found"),
    "cut off": ('<robot name="a"><link', "not well-formed XML"),
    "another format": ("<html/>", "not a valid URDF: Could not find the 'robot' element"),
    "no links": ('<robot name="a"/>', "not a valid URDF: No link elements"),
    "two roots": (PINNED.format(joint=""), r"Two root links found: \[a\] and \[b\]"),
    "unknown parent": (
        PINNED.format(joint=FIXED.replace('"a"', '"c"')),
        r"parent link \[c\] of joint \[weld\] not found",
    ),
    "unknown joint type": (PINNED.format(joint=FIXED.replace("fixed", "glued")), r"no known type \[glued\]"),
    "no joint that moves": (PINNED.format(joint=FIXED), "'pinned' has no joints that move"),
}


@pytest.mark.parametrize(("text", "message"), BROKEN.values(), ids=BROKEN)
def test_broken_urdf_is_a_model_error_and_prints_nothing(capfd, text, message):
    with pytest.raises(ModelError, match=message):
        load(text, frame="b")
    assert capfd.readouterr() == ("", "")


def test_broken_urdf_is_named_by_its_path(tmp_path):
    (tmp_path / "broken.urdf").write_text("<html/>")
    with pytest.raises(ModelError, match=re.escape(str(tmp_path / "broken.urdf"))):
        Arm.from_urdf(tmp_path / "broken.urdf", frame="tool", task="xy")


def test_massless_last_link_is_a_model_error(planar):
    start = planar.description.urdf.index("<inertial>", planar.description.urdf.index('<link name="link3">'))
    end = planar.description.urdf.index("</inertial>", start) + len("</inertial>")
    with pytest.raises(ModelError, match="'planar3r' has a singular inertia matrix"):
        load(planar.description.urdf[:start] + planar.description.urdf[end:])


def test_mass_that_is_no_number_is_a_model_error_and_prints_nothing(planar, capfd):
    with pytest.raises(ModelError, match="ten"):
        load(planar.description.urdf.replace('<mass value="10"/>', '<mass value="ten"/>', 1))
    assert capfd.readouterr() == ("", "")


# Bad arguments


@pytest.mark.parametrize("frame", ["tol", "Tool", "tool0"])
def test_unknown_frame_names_the_nearest_and_lists_all(planar, frame):
    with pytest.raises(FrameNotFoundError, match=rf"unknown frame '{frame}'.*did you mean 'tool.*available: .*'link3'"):
        load(planar.description.urdf, frame=frame)


@pytest.mark.parametrize("task", ["", "zz", "poses", "x", "xyx", [], (), ["w"], ("x", "w")])
def test_unknown_task_lists_the_known_ones(planar, task):
    with pytest.raises(TaskError, match=r"unknown task .*available: 'xy', 'xz', 'yz', 'xyz', 'pose'"):
        load(planar.description.urdf, task=task)


def test_task_with_a_coordinate_twice_is_an_error(planar):
    with pytest.raises(TaskError, match="distinct coordinates"):
        load(planar.description.urdf, task=("x", "x"))


@pytest.mark.parametrize("gravity", [(0.0, 0.0), -9.81, np.zeros((3, 1)), "down", (0.0, 0.0, 0.0, 0.0)])
def test_gravity_of_another_shape_is_an_error(planar_path, gravity):
    with pytest.raises(ShapeError, match="gravity must"):
        Arm.from_urdf(planar_path, frame="tool", task="xy", gravity=gravity)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_gravity_that_is_not_finite_is_an_error(planar_path, bad):
    with pytest.raises(NonFiniteError, match="gravity must be finite"):
        Arm.from_urdf(planar_path, frame="tool", task="xy", gravity=(0.0, 0.0, bad))


@pytest.mark.parametrize("bad", [np.zeros(2), np.zeros(4), np.zeros((3, 1)), 0.0, [[0.0, 0.0, 0.0]], "abc", [None, {}]])
def test_wrong_shapes_of_q_and_v_are_errors(planar, bad):
    for function in (planar.jacobian, planar.jacobian_derivative, planar.task_position, planar.skeleton):
        with pytest.raises(ShapeError, match="q must"):
            function(bad)
    with pytest.raises(ShapeError, match="q must"):
        planar.state(bad, np.zeros(3))
    with pytest.raises(ShapeError, match="v must"):
        planar.state(np.zeros(3), bad)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_nonfinite_q_and_v_are_errors(planar, bad):
    wrong = np.array([0.0, bad, 0.0])
    for function in (planar.jacobian, planar.jacobian_derivative, planar.task_position, planar.skeleton):
        with pytest.raises(NonFiniteError, match="q must be finite"):
            function(wrong)
    with pytest.raises(NonFiniteError, match="q must be finite"):
        planar.state(wrong, np.zeros(3))
    with pytest.raises(NonFiniteError, match="v must be finite"):
        planar.state(np.zeros(3), wrong)
