import dataclasses
import io
import json
import re
import struct
import subprocess
import sys
import tracemalloc
import zipfile
from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from aspect_control import Arm, Run, StraightLine, controllers, simulate
from aspect_control.arm.sources.examples import find_example
from aspect_control.exceptions import OutputError, RunFileError
from aspect_control.resources import model_path
from aspect_control.simulation import Diverged, RunInfo
from oracles.literal import least_acceleration_torque, null_space_terms

GEOMETRY = {"frame": "tool", "task": "xy", "gravity": (0, 0, 0)}
ARM = Arm.from_urdf(model_path("planar3r.urdf"), **GEOMETRY)
A = StraightLine([1.5, 1.0], duration=2.0)
SHORT = StraightLine([0.15, 0.1], duration=0.2)
Q0 = np.deg2rad([-50.0, 140.0, -140.0])
LAWS = ("pseudoinverse", "null-space-vector", "modified-null-space-vector", "jmdc")
ARRAYS = ("t", "q", "v", "tau", "x_desired", "dx_desired", "ddx_desired")
DERIVED = (
    "x",
    "task_error",
    "tracking_error",
    "orientation_error",
    "jacobians",
    "minors",
    "homogeneous_velocity",
    "pseudoinverse_torque",
    "maciejewski_product",
    "null_space_term_on",
)


def law(name, **parameters):
    return controllers.create(name, ARM, **parameters)


@pytest.fixture(scope="module")
def runs():
    return {name: simulate(law(name), A, q0=Q0, dt=5e-3) for name in LAWS}


@pytest.fixture(scope="module")
def modified():
    """The modified law at the paper's sampling time, and the part of it before it chatters."""
    run = simulate(law("modified-null-space-vector"), A, q0=Q0)
    return run, np.flatnonzero(run.t < 1.17)[::10]


@pytest.fixture(scope="module")
def short():
    return simulate(law("jmdc"), SHORT, q0=Q0, dt=5e-3)


@pytest.fixture(scope="module")
def saved(short, tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "short.npz"
    short.save(path)
    return path.read_bytes()


def tip(q):
    phi = np.cumsum(q, axis=-1)
    return np.stack([np.cos(phi).sum(axis=-1), np.sin(phi).sum(axis=-1)], axis=-1)


def projector(J):
    return np.eye(3) - np.linalg.pinv(J) @ J


# Derived quantities


@pytest.mark.parametrize("name", LAWS)
def test_x_is_where_three_links_of_one_metre_reach(runs, name):
    np.testing.assert_allclose(runs[name].x, tip(runs[name].q), rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", LAWS)
def test_tracking_error_is_the_distance_from_the_desired_point(runs, name):
    run = runs[name]
    expected = np.hypot(*(run.x_desired - tip(run.q)).T)
    np.testing.assert_allclose(run.tracking_error, expected, rtol=0, atol=1e-14)


def test_jacobians_are_the_slope_of_the_tip(runs):
    run, h = runs["jmdc"], 1e-6
    steps = h * np.eye(3)
    slope = np.stack([(tip(run.q + step) - tip(run.q - step)) / (2 * h) for step in steps], axis=-1)
    # Central differences: 3 m / 6 · h² of truncation, 3 m · eps / h of rounding.
    np.testing.assert_allclose(run.jacobians, slope, rtol=0, atol=2e-9)


@pytest.mark.parametrize("name", LAWS)
def test_minors_are_the_determinants_of_pairs_of_columns(runs, name):
    run = runs[name]
    pairs = [(0, 1), (1, 2), (2, 0)]
    expected = [[np.linalg.det(J[:, pair]) for pair in pairs] for J in run.jacobians]
    np.testing.assert_allclose(run.minors, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("name", LAWS)
def test_homogeneous_velocity_is_the_projected_velocity(runs, name):
    run = runs[name]
    expected = [projector(J) @ v for J, v in zip(run.jacobians, run.v, strict=True)]
    # Rounding of J⁺J, whose condition stays below 1e3 outside the very peak of the torque.
    tolerance = 1e-12 * np.linalg.norm(run.v, axis=1).max()
    np.testing.assert_allclose(run.homogeneous_velocity, expected, rtol=0, atol=tolerance)


def commanded(run, i):
    """ẍ_d + K_v ė + K_p e − J̇θ̇ with the law's gains."""
    state = ARM.state(run.q[i], run.v[i])
    kp, kv = run.info.parameters["kp"], run.info.parameters["kv"]
    return run.ddx_desired[i] + kv * (run.dx_desired[i] - state.dx) + kp * (run.x_desired[i] - state.x) - state.drift


def assert_products_agree(run, samples, accelerations):
    for i, b in zip(samples, accelerations, strict=True):
        theta_dot_H = projector(run.jacobians[i]) @ run.v[i]
        _, _, theta_ddot_H = null_space_terms(ARM.state(run.q[i], run.v[i]), b)
        # Two routes through matrices whose condition multiplies to some 1e4: 1e-9 is generous by two orders.
        scale = np.linalg.norm(run.v[i]) * np.linalg.norm(theta_ddot_H)
        assert abs(run.maciejewski_product[i] - theta_dot_H @ theta_ddot_H) <= 1e-9 * scale


def test_maciejewski_s_product_is_that_of_the_paper_s_equations(modified):
    run, samples = modified
    assert_products_agree(run, samples, [commanded(run, i) for i in samples])


def test_maciejewski_s_product_of_jmdc_is_that_of_the_task_acceleration_it_brings_about(runs):
    run = runs["jmdc"]
    states = [ARM.state(q, v) for q, v in zip(run.q, run.v, strict=True)]
    brought_about = [s.J @ np.linalg.solve(s.M, tau - s.nle) for s, tau in zip(states, run.tau, strict=True)]
    assert_products_agree(run, range(len(run.t)), brought_about)


def test_pseudoinverse_torque_is_equation_7_with_the_law_s_gains(modified):
    run, samples = modified
    expected = [least_acceleration_torque(ARM.state(run.q[i], run.v[i]), commanded(run, i)) for i in samples]
    np.testing.assert_allclose(run.pseudoinverse_torque[samples], expected, rtol=0, atol=1e-11)


def test_the_modified_law_has_its_null_space_term_on_where_the_product_is_negative(modified):
    run, samples = modified
    moving = samples[np.abs(run.maciejewski_product[samples]) > 1e-9]
    assert len(moving) > 100
    np.testing.assert_array_equal(run.null_space_term_on[moving], run.maciejewski_product[moving] < 0.0)


def test_the_pseudoinverse_law_never_has_a_null_space_term(runs):
    assert not runs["pseudoinverse"].null_space_term_on.any()


def test_the_null_space_vector_law_always_has_one(runs):
    assert runs["null-space-vector"].null_space_term_on.all()


@pytest.mark.parametrize("name", DERIVED)
def test_derived_quantities_have_one_row_a_sample(short, name):
    assert len(getattr(short, name)) == len(short.t)


def test_a_run_without_samples_has_empty_derived_quantities(short):
    empty = dataclasses.replace(short, **{name: getattr(short, name)[:0] for name in ARRAYS})
    assert {name: getattr(empty, name).shape for name in DERIVED} == {
        name: (0, *getattr(short, name).shape[1:]) for name in DERIVED
    }


def test_repr_says_what_ran_and_how_it_ended(short):
    assert repr(short) == "Run('jmdc' on 'planar3r', 41 samples, finished at t = 0.2 s)"


# Saving and loading


def far_from_singularities(q):
    return np.abs([np.linalg.det(ARM.jacobian(q)[:, pair]) for pair in combinations(range(3), 2)]).min() > 0.05


bent = st.floats(0.4, 2.7) | st.floats(-2.7, -0.4)
starts = st.tuples(st.floats(-np.pi, np.pi), bent, bent).filter(far_from_singularities)


@settings(max_examples=30)
@given(name=st.sampled_from(LAWS), q0=starts, dt=st.sampled_from([4e-3, 0.01, 0.03]), kp=st.floats(0.0, 400.0))
def test_a_loaded_run_is_the_saved_one_bit_for_bit(tmp_path_factory, name, q0, dt, kp):
    path = tmp_path_factory.getbasetemp() / "round-trip.npz"
    run = simulate(law(name, kp=kp), SHORT, q0=q0, dt=dt)
    run.save(path)
    loaded = Run.load(path)
    assert loaded == run
    assert loaded.info == run.info
    for each in (*ARRAYS, *DERIVED):
        before, after = getattr(run, each), getattr(loaded, each)
        assert (after.dtype, after.shape, after.tobytes()) == (before.dtype, before.shape, before.tobytes())


def test_a_loaded_run_has_the_saved_one_s_arm(short, tmp_path):
    short.save(tmp_path / "run.npz")
    arm = Run.load(tmp_path / "run.npz").arm
    assert arm.description == ARM.description
    assert (arm.description.urdf, arm.frame) == (model_path("planar3r.urdf").read_text(encoding="utf-8"), "tool")
    assert (arm.task, arm.name) == (("x", "y"), "planar3r")
    np.testing.assert_array_equal(arm.gravity, np.zeros(3))
    assert arm.model == ARM.model


def test_gravity_is_saved(tmp_path):
    arm = Arm.from_urdf(model_path("planar3r.urdf"), frame="link3", task=("y", "x"), gravity=(0.1, -9.81, 0.3))
    simulate(controllers.Pseudoinverse(arm), SHORT, q0=Q0, dt=0.02).save(tmp_path / "run.npz")
    loaded = Run.load(tmp_path / "run.npz").arm
    np.testing.assert_array_equal(loaded.gravity, [0.1, -9.81, 0.3])
    assert (loaded.frame, loaded.task) == ("link3", ("y", "x"))


def test_gains_of_every_form_are_saved(tmp_path):
    run = simulate(law("pseudoinverse", kp=[100.0, 90.0], kv=[[20.0, 1.0], [1.0, 20.0]]), SHORT, q0=Q0, dt=0.02)
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").info.parameters == {"kp": [100.0, 90.0], "kv": [[20.0, 1.0], [1.0, 20.0]]}


def test_a_diverged_run_comes_back(tmp_path):
    run = simulate(law("null-space-vector"), A, q0=Q0, dt=0.2, events=[Diverged()])
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == run
    assert Run.load(tmp_path / "run.npz").status == "diverged"


def test_a_run_without_samples_comes_back(short, tmp_path):
    empty = dataclasses.replace(short, **{name: getattr(short, name)[:0] for name in ARRAYS})
    empty.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == empty


def test_the_sign_of_zero_comes_back(short, tmp_path):
    run = dataclasses.replace(short, tau=np.full_like(short.tau, -0.0))
    run.save(tmp_path / "run.npz")
    assert np.signbit(Run.load(tmp_path / "run.npz").tau).all()


def test_a_run_of_a_deleted_urdf_still_loads(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(model_path("planar3r.urdf").read_text(encoding="utf-8"), encoding="utf-8")
    run = simulate(controllers.Pseudoinverse(Arm.from_urdf(urdf, **GEOMETRY)), SHORT, q0=Q0, dt=0.02)
    run.save(tmp_path / "run.npz")
    urdf.unlink()
    loaded = Run.load(tmp_path / "run.npz")
    assert loaded == run
    np.testing.assert_array_equal(loaded.minors, run.minors)


def test_the_file_is_written_under_exactly_the_name_given(short, tmp_path):
    short.save(str(tmp_path / "run.of.today"))
    assert [path.name for path in tmp_path.iterdir()] == ["run.of.today"]
    assert Run.load(str(tmp_path / "run.of.today")) == short


def test_the_file_holds_no_pickle(saved):
    with zipfile.ZipFile(io.BytesIO(saved)) as archive:
        members = {name: np.load(io.BytesIO(archive.read(name)), allow_pickle=False) for name in archive.namelist()}
    assert set(members) == {f"{name}.npy" for name in ("header", *ARRAYS)}
    assert {array.dtype.kind for array in members.values()} == {"f", "U"}


def test_neither_saving_nor_loading_pickles(short, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("pickle was used")

    for function in ("dump", "dumps", "load", "loads"):
        monkeypatch.setattr(f"pickle.{function}", refuse)
    short.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == short


# Recordings of any arm


PANDA_START = (0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6)
TURN = np.array([0.2, -0.3, 0.4])
SHIFT = np.array([0.1, 0.15, -0.087])


def two_locked_joints():
    text = model_path("planar3r.urdf").read_text(encoding="utf-8")
    arm = Arm.from_urdf_text(text, frame="tool", task=["y"], gravity=(0, -9.81, 0), locked={"joint2": 0.7})
    return arm, (-0.8, 0.9), [0.1]


def of_a_panda():
    return Arm.from_example("panda", frame="panda_hand", task="pose"), PANDA_START, [*SHIFT, *TURN]


def of_a_panda_with_a_locked_joint():
    arm = Arm.from_example("panda", frame="panda_hand", task=["z", "x", "ry"], locked={"panda_joint3": -0.3})
    return arm, PANDA_START[:2] + PANDA_START[3:], [-0.05, 0.1, 0.2]


def of_a_pinocchio_model():
    model = pin.buildModelFromUrdf(str(model_path("planar3r.urdf")))
    model.gravity.linear = np.array([0.1, -3.7, 0.2])
    return Arm.from_pinocchio(model, frame="tool", task="xy"), Q0, [0.15, 0.1]


def of_a_kinova():
    arm = Arm.from_example("kinova", frame="j2s6s200_end_effector", task="xyz")
    return arm, (0.4, 2.8, 1.6, 0.6, 2.0, 3.0), [0.05, 0.05, 0.1]


def of_a_kinova_s_pinocchio_model():
    model = pin.buildModelFromUrdf(str(find_example("kinova").path))
    arm = Arm.from_pinocchio(model, frame="j2s6s200_end_effector", task="xyz")
    return arm, (0.4, 2.8, 1.6, 0.6, 2.0, 3.0), [0.05, 0.05, 0.1]


@pytest.fixture(
    scope="module",
    params=[
        two_locked_joints,
        of_a_panda,
        of_a_panda_with_a_locked_joint,
        of_a_pinocchio_model,
        of_a_kinova,
        of_a_kinova_s_pinocchio_model,
    ],
    ids=lambda make: make.__name__,
)
def recorded(request):
    arm, start, displacement = request.param()
    line = StraightLine(displacement, duration=0.5, profile="quintic")
    return simulate(controllers.create("jmdc", arm), line, q0=arm.configuration(start), dt=0.01)


def test_a_recording_of_any_arm_comes_back_bit_for_bit(recorded, tmp_path):
    assert recorded.status == "finished"
    recorded.save(tmp_path / "run.npz")
    loaded = Run.load(tmp_path / "run.npz")
    assert loaded == recorded
    assert loaded.arm.description == recorded.arm.description
    for each in (*ARRAYS, *DERIVED):
        before, after = getattr(recorded, each), getattr(loaded, each)
        assert (after.dtype, after.shape, after.tobytes()) == (before.dtype, before.shape, before.tobytes())


def test_a_loaded_arm_has_the_saved_one_s_model(recorded, tmp_path):
    recorded.save(tmp_path / "run.npz")
    arm, loaded = recorded.arm, Run.load(tmp_path / "run.npz").arm
    assert loaded.model == arm.model
    assert (loaded.joint_names, loaded.task, loaded.frame) == (arm.joint_names, arm.task, arm.frame)
    np.testing.assert_array_equal(loaded.gravity, arm.gravity)
    np.testing.assert_array_equal(loaded.torque_limit, arm.torque_limit)
    np.testing.assert_array_equal(loaded.minor_columns, arm.minor_columns)


def test_a_recording_of_any_arm_has_the_documented_shapes(recorded):
    arm, k = recorded.arm, 51
    m, encoded = arm.task_dim, 7 if any(axis.startswith("r") for axis in arm.task) else arm.task_dim
    shapes = [(k,), (k, arm.nq), (k, arm.nv), (k, arm.nv), (k, encoded), (k, m), (k, m)]
    assert [getattr(recorded, name).shape for name in ARRAYS] == shapes
    assert (recorded.x.shape, recorded.task_error.shape) == ((k, encoded), (k, m))
    assert recorded.tracking_error.shape == recorded.orientation_error.shape == (k,)


def test_a_recording_of_a_bare_model_needs_no_urdf(tmp_path):
    arm, start, displacement = of_a_pinocchio_model()
    simulate(controllers.Pseudoinverse(arm), StraightLine(displacement, 0.5), q0=start, dt=0.05).save(tmp_path / "run")
    loaded = Run.load(tmp_path / "run").arm
    assert loaded.description.urdf is None
    assert loaded.description.chain == arm.description.chain
    np.testing.assert_array_equal(loaded.gravity, [0.1, -3.7, 0.2])


@pytest.fixture(scope="module")
def pose_run():
    arm, start, displacement = of_a_panda()
    line = StraightLine(displacement, duration=1.0, profile="quintic")
    # Gains so weak that there is an error worth measuring.
    return simulate(
        controllers.Pseudoinverse(arm, kp=1.0, kv=1.0), line, q0=start, v0=np.full(7, 0.1), dt=0.02, events=()
    )


@pytest.fixture(scope="module")
def hand_poses(pose_run):
    """Rotations and positions of the hand, from a model of its own with the fingers locked."""
    model = pin.buildModelFromUrdf(str(find_example("panda").path))
    fingers = [model.getJointId(name) for name in model.names if "finger" in name]
    model = pin.buildReducedModel(model, fingers, pin.neutral(model))
    data, rotations, positions = model.createData(), [], []
    for q in pose_run.q:
        pin.framesForwardKinematics(model, data, q)
        pose = data.oMf[model.getFrameId("panda_hand")]
        rotations.append(pose.rotation.copy())
        positions.append(pose.translation.copy())
    return np.array(rotations), np.array(positions)


def quaternion_rotations(quaternions):
    return Rotation.from_quat(quaternions).as_matrix()


def desired_rotations(run, start):
    u = run.t / run.t[-1]
    s = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return Rotation.from_rotvec(s[:, None] * TURN).as_matrix() @ start, s


def test_desired_poses_are_position_and_unit_quaternion(pose_run, hand_poses):
    rotations, positions = hand_poses
    desired, s = desired_rotations(pose_run, rotations[0])
    assert pose_run.x_desired.shape == (51, 7)
    np.testing.assert_allclose(np.linalg.norm(pose_run.x_desired[:, 3:], axis=1), 1.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(pose_run.x_desired[:, :3], positions[0] + s[:, None] * SHIFT, rtol=0, atol=1e-15)
    np.testing.assert_allclose(quaternion_rotations(pose_run.x_desired[:, 3:]), desired, rtol=0, atol=4e-15)


def test_actual_poses_are_those_of_the_hand(pose_run, hand_poses):
    rotations, positions = hand_poses
    np.testing.assert_allclose(pose_run.x[:, :3], positions, rtol=0, atol=1e-15)
    np.testing.assert_allclose(quaternion_rotations(pose_run.x[:, 3:]), rotations, rtol=0, atol=4e-15)


def test_tracking_error_of_a_pose_is_the_distance_of_the_hand_alone(pose_run, hand_poses):
    _, positions = hand_poses
    _, s = desired_rotations(pose_run, np.eye(3))
    expected = np.linalg.norm(positions[0] + s[:, None] * SHIFT - positions, axis=1)
    assert expected.max() > 0.01
    np.testing.assert_allclose(pose_run.tracking_error, expected, rtol=0, atol=1e-14)


def test_orientation_error_of_a_pose_is_the_angle_between_the_hands(pose_run, hand_poses):
    rotations, _ = hand_poses
    desired, _ = desired_rotations(pose_run, rotations[0])
    # Rotations an angle φ apart differ by 2√2·sin(φ/2) in the Frobenius norm.
    expected = 2.0 * np.arcsin(np.linalg.norm(desired - rotations, axis=(1, 2)) / np.sqrt(8.0))
    assert expected.max() > 0.01
    np.testing.assert_allclose(pose_run.orientation_error, expected, rtol=0, atol=2e-14)


def test_task_error_of_a_pose_is_the_rotation_that_is_missing(pose_run, hand_poses):
    rotations, _ = hand_poses
    desired, _ = desired_rotations(pose_run, rotations[0])
    missing = Rotation.from_matrix(desired @ rotations.transpose(0, 2, 1)).as_rotvec()
    np.testing.assert_allclose(pose_run.task_error[:, 3:], missing, rtol=0, atol=2e-14)


def test_errors_of_a_task_of_a_few_coordinates_are_of_those_alone():
    arm, start, displacement = of_a_panda_with_a_locked_joint()
    line = StraightLine(displacement, 0.5)
    run = simulate(
        controllers.Pseudoinverse(arm, kp=1.0, kv=1.0), line, q0=start, v0=np.full(6, 0.2), dt=0.02, events=()
    )
    # The task is z, x and ry.
    position = (run.x_desired - run.x)[:, [2, 0]]
    one, other = (quaternion_rotations(x[:, 3:]) for x in (run.x_desired, run.x))
    turn = Rotation.from_matrix(one @ other.transpose(0, 2, 1)).as_rotvec()
    assert np.abs(turn[:, 1]).max() > 1e-3
    np.testing.assert_allclose(run.task_error, np.column_stack([position, turn[:, 1]]), rtol=0, atol=1e-14)
    np.testing.assert_allclose(run.tracking_error, np.hypot(*position.T), rtol=0, atol=1e-14)
    np.testing.assert_allclose(run.orientation_error, np.abs(turn[:, 1]), rtol=0, atol=1e-14)


def test_the_orientation_error_of_a_task_of_positions_is_zero(short):
    np.testing.assert_array_equal(short.orientation_error, np.zeros(41))


# Equality


@pytest.mark.parametrize("name", ARRAYS)
def test_runs_that_differ_in_the_last_bit_are_not_equal(short, name):
    changed = getattr(short, name).copy()
    changed.flat[-1] = np.nextafter(changed.flat[-1], np.inf)
    assert dataclasses.replace(short, **{name: changed}) != short
    assert dataclasses.replace(short, **{name: getattr(short, name).copy()}) == short


@pytest.mark.parametrize("name", ARRAYS)
def test_runs_of_different_lengths_are_not_equal(short, name):
    assert dataclasses.replace(short, **{name: getattr(short, name)[:-1]}) != short


@pytest.mark.parametrize(
    "change",
    [
        {"parameters": {"kp": 100.0, "kv": 20.0, "kappa": 0.0}},
        {"controller": "pseudoinverse"},
        {"dt": 1e-3},
        {"integrator": "semi-implicit-euler"},
        {"status": "diverged"},
    ],
    ids=lambda change: next(iter(change)),
)
def test_runs_that_came_about_differently_are_not_equal(short, change):
    assert dataclasses.replace(short, info=dataclasses.replace(short.info, **change)) != short


@pytest.mark.parametrize("change", [{"gravity": (0, -9.81, 0)}, {"frame": "link3"}, {"task": ("y", "x")}])
def test_runs_of_different_arms_are_not_equal(short, change):
    arm = Arm.from_urdf(model_path("planar3r.urdf"), **{**GEOMETRY, **change})
    assert dataclasses.replace(short, arm=arm) != short


def test_a_run_equals_nothing_else(short):
    assert short != "run"


# Files that are no recorded runs


@pytest.fixture(scope="module")
def saved_chain(tmp_path_factory):
    """A saved run of an arm made of a pin.Model."""
    arm, start, displacement = of_a_pinocchio_model()
    path = tmp_path_factory.mktemp("runs") / "chain.npz"
    simulate(controllers.Pseudoinverse(arm), StraightLine(displacement, 0.5), q0=start, dt=0.05).save(path)
    return path.read_bytes()


def load_apart(paths):
    """What loading runs comes to in a process of its own, so that a crash is not that of the tests."""
    code = (
        "import sys; from aspect_control import Run; from aspect_control.exceptions import RunFileError\n"
        "for path in sys.argv[1:]:\n"
        "    try:\n        Run.load(path); print('loaded')\n"
        "    except RunFileError as error:\n        print('refused:', ' '.join(str(error).split()))\n"
    )
    command = [sys.executable, "-c", code, *map(str, paths)]
    return subprocess.run(command, capture_output=True, text=True, timeout=15, check=False)


def assert_refused(path, content=None):
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RunFileError, match=path.name):
        Run.load(path)


def rewritten(saved, **changes):
    """The saved file with some of its arrays replaced, or left out where None is given."""
    with np.load(io.BytesIO(saved)) as archive:
        arrays = {**archive, **changes}
    file = io.BytesIO()
    np.savez_compressed(file, **{name: array for name, array in arrays.items() if array is not None})
    return file.getvalue()


def with_header(saved, change):
    with np.load(io.BytesIO(saved)) as archive:
        header = json.loads(str(archive["header"]))
    change(header)
    return rewritten(saved, header=np.array(json.dumps(header)))


def member(saved, name):
    with np.load(io.BytesIO(saved)) as archive:
        return archive[name]


def test_a_rewritten_file_without_changes_is_accepted(saved, short, tmp_path):
    (tmp_path / "run.npz").write_bytes(with_header(rewritten(saved), lambda header: None))
    assert Run.load(tmp_path / "run.npz") == short


def test_a_missing_file_is_refused(tmp_path):
    assert_refused(tmp_path / "missing.npz")


def test_a_folder_is_refused(tmp_path):
    assert_refused(tmp_path)


@pytest.mark.parametrize(
    "content",
    [b"", b"\0", b"PK", b"PK\x03\x04", b"hello", b"\x93NUMPY", b"\x80\x05K\x01.", bytes(range(256)) * 20],
    ids=lambda content: repr(content[:8]),
)
def test_bytes_that_are_no_archive_are_refused(tmp_path, content):
    assert_refused(tmp_path / "bad.npz", content)


@given(content=st.binary(max_size=200))
def test_random_bytes_are_refused(tmp_path_factory, content):
    assert_refused(tmp_path_factory.getbasetemp() / "random.npz", content)


def test_a_single_array_is_refused(tmp_path):
    np.save(tmp_path / "array.npy", np.zeros(3))
    assert_refused(tmp_path / "array.npy")


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9, 0.99, 0.999])
def test_a_truncated_file_is_refused(saved, tmp_path, part):
    assert_refused(tmp_path / "truncated.npz", saved[: int(part * len(saved))])


@pytest.mark.parametrize("name", ["header", *ARRAYS])
def test_a_file_without_one_of_its_arrays_is_refused(saved, tmp_path, name):
    assert_refused(tmp_path / "incomplete.npz", rewritten(saved, **{name: None}))


def test_a_flipped_bit_is_refused_or_does_not_matter(saved, short, tmp_path):
    path, escaped = tmp_path / "flipped.npz", {}
    for position in range(0, len(saved), 5):
        content = bytearray(saved)
        content[position] ^= 1 << position % 8
        path.write_bytes(content)
        try:
            assert Run.load(path) == short
        except RunFileError:
            pass
        except Exception as error:
            escaped.setdefault(f"{type(error).__module__}.{type(error).__name__}", (position, str(error)))
    assert escaped == {}


@pytest.mark.parametrize(("field", "value"), [(8, 1), (10, 99)], ids=["encrypted", "unknown compression"])
def test_an_archive_of_an_unreadable_kind_is_refused(saved, tmp_path, field, value):
    content = bytearray(saved)
    struct.pack_into("<H", content, saved.index(b"PK\x01\x02") + field, value)
    assert_refused(tmp_path / "unreadable.npz", bytes(content))


def test_an_array_with_a_damaged_description_is_refused(saved, tmp_path):
    file, description = io.BytesIO(), b"{'descr': ("
    with zipfile.ZipFile(io.BytesIO(saved)) as archive, zipfile.ZipFile(file, "w") as damaged:
        for name in archive.namelist():
            bad = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(description)) + description
            damaged.writestr(name, bad if name == "q.npy" else archive.read(name))
    assert_refused(tmp_path / "damaged.npz", file.getvalue())


@pytest.mark.parametrize("name", ["header", *ARRAYS])
def test_a_pickle_is_refused_and_not_run(saved, tmp_path, name):
    class Trap:
        def __reduce__(self):
            return Path.touch, (tmp_path / "sprung",)

    assert_refused(tmp_path / "trap.npz", rewritten(saved, **{name: np.array([Trap()], dtype=object)}))
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("number", ["2", "1.1"])
def test_a_newer_format_is_refused_by_its_name(saved, tmp_path, number):
    content = with_header(saved, lambda header: header.update(format=f"aspect-control run {number}"))
    (tmp_path / "newer.npz").write_bytes(content)
    with pytest.raises(RunFileError, match=rf"newer\.npz .*'aspect-control run {number}'.*'aspect-control run 1'"):
        Run.load(tmp_path / "newer.npz")


@pytest.mark.parametrize(
    "header",
    ["hello", "", "{", "[]", "7", "null", '"text"', "{}", "[" * 100_000],
    ids=lambda header: repr(header[:8]),
)
def test_a_header_that_is_no_json_object_is_refused(saved, tmp_path, header):
    assert_refused(tmp_path / "header.npz", rewritten(saved, header=np.array(header)))


@pytest.mark.parametrize("header", [np.array(3.0), np.array(b"{}"), np.array(["{}", "{}"]), np.zeros((2, 2))])
def test_a_header_that_is_no_text_is_refused(saved, tmp_path, header):
    assert_refused(tmp_path / "header.npz", rewritten(saved, header=header))


@pytest.mark.parametrize("key", ["format", "arm", "info"])
def test_a_header_without_one_of_its_parts_is_refused(saved, tmp_path, key):
    assert_refused(tmp_path / "header.npz", with_header(saved, lambda header: header.pop(key)))


@pytest.mark.parametrize(
    "field", [field.name for field in dataclasses.fields(RunInfo) if field.default is dataclasses.MISSING]
)
def test_a_header_without_one_of_its_infos_is_refused(saved, tmp_path, field):
    assert_refused(tmp_path / "header.npz", with_header(saved, lambda header: header["info"].pop(field)))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("urdf", "<robot"),
        ("urdf", "<html/>"),
        ("urdf", ""),
        ("urdf", None),
        ("frame", "hand"),
        ("frame", 5),
        ("task", "pose"),
        ("task", 5),
        ("gravity", [0.0]),
        ("gravity", "down"),
        ("gravity", [0.0, 0.0, float("nan")]),
        ("gravity", [0.0, 0.0, float("inf")]),
        ("gravity", [0.0, 0.0, 0.0, 0.0]),
        ("task", ["x", "w"]),
        ("task", ["x", "x"]),
        ("task", []),
        ("task", ["x", "ry"]),
        ("locked", None),
        ("locked", {"joint2": float("nan")}),
        ("locked", {"joint2": "bent"}),
        ("locked", {"joint2": 4.0}),
        ("locked", {"joint9": 0.0}),
        ("locked", {"joint2": 0.0}),
        ("locked", {"joint1": 0.0, "joint2": 0.0, "joint3": 0.0}),
        ("package_dirs", "meshes"),
    ],
)
def test_a_header_with_an_impossible_arm_is_refused(saved, tmp_path, key, value):
    assert_refused(tmp_path / "header.npz", with_header(saved, lambda header: header["arm"].update({key: value})))


def test_an_arm_of_neither_a_urdf_nor_a_chain_is_refused(saved_chain, tmp_path):
    content = with_header(saved_chain, lambda header: header["arm"].update(chain=None))
    assert_refused(tmp_path / "header.npz", content)


@pytest.mark.parametrize("key", ["frame", "task", "gravity", "locked"])
def test_a_description_without_one_of_its_parts_is_refused(saved, tmp_path, key):
    assert_refused(tmp_path / "header.npz", with_header(saved, lambda header: header["arm"].pop(key)))


def recorded_joints(header):
    return header["arm"]["chain"]["joints"]


def test_chains_that_are_damaged_anywhere_are_refused_or_loaded_and_crash_nothing(saved_chain, tmp_path):
    damages = [None, -1, 1e308, float("nan"), "x", [], {}]
    joints = len(recorded_joints(json.loads(str(member(saved_chain, "header")))))
    paths = []
    for joint in range(joints):
        for key in ("name", "kind", "axis", "placement", "inertia", "armature", "limits"):
            for index, damage in enumerate(damages):
                path = tmp_path / f"damaged-{joint}-{key}-{index}.npz"
                change = lambda header, j=joint, k=key, d=damage: recorded_joints(header)[j].update({k: d})  # noqa: E731
                path.write_bytes(with_header(saved_chain, change))
                paths.append(path)
    done = load_apart(paths)
    assert (done.returncode, done.stderr) == (0, "")
    outcomes = done.stdout.splitlines()
    assert len(outcomes) == len(paths)
    assert {outcome.split(":")[0] for outcome in outcomes} <= {"refused", "loaded"}
    assert all("NaN" not in outcome for outcome in outcomes)


@pytest.mark.parametrize(
    "falsify",
    [
        lambda joints: joints.clear(),
        lambda joints: joints[1].update(name=joints[0]["name"]),
        lambda joints: joints[1].update(kind="JointModelFreeFlyer"),
        lambda joints: joints[1]["inertia"].__setitem__(0, float("nan")),
        lambda joints: joints[1]["placement"].__setitem__(0, 7.0),
        lambda joints: joints.append(joints[0] | {"name": "one more"}),
    ],
)
def test_an_impossible_chain_is_refused_and_crashes_nothing(saved_chain, tmp_path, falsify):
    path = tmp_path / "impossible.npz"
    path.write_bytes(with_header(saved_chain, lambda header: falsify(recorded_joints(header))))
    done = load_apart([path])
    assert (done.returncode, done.stdout[:8]) == (0, "refused:"), done.stderr


@pytest.mark.parametrize("name", ARRAYS)
def test_an_array_of_another_length_is_refused(saved, tmp_path, name):
    assert_refused(tmp_path / "shape.npz", rewritten(saved, **{name: member(saved, name)[:-1]}))


@pytest.mark.parametrize("name", ARRAYS)
def test_an_array_with_another_number_of_dimensions_is_refused(saved, tmp_path, name):
    assert_refused(tmp_path / "shape.npz", rewritten(saved, **{name: member(saved, name)[..., None]}))


@pytest.mark.parametrize("name", ARRAYS[1:])
def test_an_array_that_does_not_fit_the_arm_is_refused(saved, tmp_path, name):
    assert_refused(tmp_path / "shape.npz", rewritten(saved, **{name: member(saved, name)[:, :-1]}))


def test_arrays_that_do_not_fit_the_task_are_refused(saved, tmp_path):
    assert_refused(tmp_path / "shape.npz", with_header(saved, lambda header: header["arm"].update(task="xyz")))


@pytest.mark.parametrize("dtype", [np.int64, np.float32, np.complex128, str])
@pytest.mark.parametrize("name", ARRAYS)
def test_an_array_of_another_type_is_refused(saved, tmp_path, name, dtype):
    assert_refused(tmp_path / "type.npz", rewritten(saved, **{name: member(saved, name).astype(dtype)}))


# Files that cannot be written


def test_a_missing_folder_is_an_output_error(short, tmp_path):
    with pytest.raises(OutputError, match="No such file or directory"):
        short.save(tmp_path / "missing" / "run.npz")


def test_a_folder_in_the_way_is_an_output_error(short, tmp_path):
    (tmp_path / "run.npz").mkdir()
    with pytest.raises(OutputError, match=r"run\.npz"):
        short.save(tmp_path / "run.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


def test_a_disk_that_fills_up_leaves_the_existing_file_untouched(short, tmp_path, monkeypatch):
    def fill_up(file, **_):
        file.write(b"half a run")
        raise OSError(28, "No space left on device")

    (tmp_path / "run.npz").write_bytes(b"the old run")
    monkeypatch.setattr(np, "savez_compressed", fill_up)
    with pytest.raises(OutputError, match="No space left on device"):
        short.save(tmp_path / "run.npz")
    assert (tmp_path / "run.npz").read_bytes() == b"the old run"
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


def test_an_existing_run_is_replaced(short, tmp_path):
    (tmp_path / "run.npz").write_bytes(b"the old run")
    short.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == short


# Archives that claim or unpack to more than a recording may hold


def with_zeros(saved, name, shape, blocks):
    """The saved file with an array that says it has a shape, and whose data are zeros in blocks of 1 MiB."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        with zipfile.ZipFile(io.BytesIO(saved)) as source:
            for other in set(source.namelist()) - {f"{name}.npy"}:
                archive.writestr(other, source.read(other))
        with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
            np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
            for _ in range(blocks):
                file.write(bytes(2**20))
    return content.getvalue()


def peak_of_refusing(path, words):
    """The memory that Python and NumPy take while a file is refused, in bytes."""
    tracemalloc.start()
    try:
        with pytest.raises(RunFileError, match=words):
            Run.load(path)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_an_array_of_3_gib_in_a_small_archive_is_refused_before_it_is_unpacked(saved, tmp_path):
    (tmp_path / "bomb.npz").write_bytes(with_zeros(saved, "q", (2**27, 3), 3072))
    assert (tmp_path / "bomb.npz").stat().st_size < 20e6
    with zipfile.ZipFile(tmp_path / "bomb.npz") as archive:
        assert archive.getinfo("q.npy").file_size > 3 * 2**30
    samples = len(member(saved, "t"))
    words = (
        rf"bomb\.npz is damaged: q must be float64 of shape \({samples}, 3\), found float64 of shape \(134217728, 3\)"
    )
    assert peak_of_refusing(tmp_path / "bomb.npz", words) < 20e6


def test_more_samples_than_can_be_recorded_are_refused_before_they_are_unpacked(saved, tmp_path):
    (tmp_path / "bomb.npz").write_bytes(with_zeros(saved, "t", (2**25,), 256))
    words = r"t must have one entry a sample, at most 20,000,000, found float64 of shape \(33554432,\)"
    assert peak_of_refusing(tmp_path / "bomb.npz", words) < 20e6


@pytest.mark.parametrize(("shape", "blocks"), [((2**17,), 0), ((4,), 64), ((2**40, 2**40), 0)])
def test_an_array_that_is_not_as_large_as_its_header_says_is_refused_before_it_is_unpacked(
    saved, tmp_path, shape, blocks
):
    (tmp_path / "liar.npz").write_bytes(with_zeros(saved, "t", shape, blocks))
    words = rf"t is [\d,]+ bytes, not the [\d,]+ of float64 of shape {re.escape(str(shape))}"
    assert peak_of_refusing(tmp_path / "liar.npz", words) < 20e6


def test_a_header_that_unpacks_to_more_than_a_description_is_refused(saved, tmp_path):
    (tmp_path / "bomb.npz").write_bytes(rewritten(saved, header=np.array(" " * (2**24 + 1))))
    assert (tmp_path / "bomb.npz").stat().st_size < 1e6
    words = r"header must be one text of at most 67,108,864 bytes, found <U16777217 of shape \(\)"
    assert peak_of_refusing(tmp_path / "bomb.npz", words) < 20e6


def test_a_description_that_could_not_be_read_again_is_not_written(short, tmp_path):
    info = dataclasses.replace(short.info, message="x" * 2**24)
    with pytest.raises(OutputError, match="characters, too many"):
        dataclasses.replace(short, info=info).save(tmp_path / "run.npz")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t[::-1].copy(),
        lambda t: np.where(t == t[2], t[1], t),
        lambda t: np.zeros_like(t),
        lambda t: np.append(t[:-1], -1.0),
    ],
    ids=["backwards", "standing", "zero", "back at the end"],
)
def test_a_time_that_does_not_increase_is_refused(saved, tmp_path, change):
    (tmp_path / "run.npz").write_bytes(rewritten(saved, t=change(member(saved, "t"))))
    with pytest.raises(RunFileError, match=r"run\.npz is damaged: t must increase from sample to sample"):
        Run.load(tmp_path / "run.npz")


@pytest.mark.parametrize(
    ("index", "value", "words"),
    [(0, -1.0, "a negative mass"), (4, -1.0, "a negative principal moment"), (12, 9.0, "the triangle inequality")],
)
def test_a_chain_of_an_impossible_inertia_is_refused_with_the_joint(saved_chain, tmp_path, index, value, words):
    change = lambda header: recorded_joints(header)[1]["inertia"].__setitem__(index, value)  # noqa: E731
    (tmp_path / "run.npz").write_bytes(with_header(saved_chain, change))
    with pytest.raises(RunFileError, match=rf"run\.npz is damaged: what joint '.*' moves .*{words}"):
        Run.load(tmp_path / "run.npz")
