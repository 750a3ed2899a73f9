"""Figures of merit of one run as single numbers, and the run as a table."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aspect_control import Arm, Run, StraightLine, controllers, simulate
from aspect_control.exceptions import ParameterError
from aspect_control.resources import model_path
from aspect_control.simulation.metrics import METRICS
from oracles.literal import null_space_terms

PLANAR = Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0, 0, 0))
Q0 = np.deg2rad([-50.0, 140.0, -140.0])
ARRAYS = ("t", "q", "v", "tau", "x_desired", "dx_desired", "ddx_desired")


def planar_run(law, **parameters):
    return simulate(controllers.create(law, PLANAR, **parameters), StraightLine([1.5, 1.0], 2.0), q0=Q0, dt=4e-3)


def panda_run():
    arm = Arm.from_example("panda", frame="panda_hand_tcp", task="pose")
    line = StraightLine([0.1, 0.15, -0.1, 0.2, -0.3, 0.4], 1.0, "quintic")
    return simulate(
        controllers.create("null-space-vector", arm, kp=1.0), line, q0=(0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6), dt=0.01
    )


def kinova_run():
    arm = Arm.from_example("kinova", frame="j2s6s200_end_effector", task="xyz")
    q0 = arm.configuration((0.4, 2.8, 1.6, 0.6, 2.0, 3.0))
    return simulate(controllers.create("jmdc", arm), StraightLine([0.05, 0.05, 0.1], 0.5, "quintic"), q0=q0, dt=0.01)


@pytest.fixture(scope="module")
def runs():
    """Runs that explode, stay calm, leave and keep their aspect; of positions and poses; of continuous joints."""
    return {
        "exploding": planar_run("null-space-vector"),
        "leaving": planar_run("pseudoinverse"),
        "modified": planar_run("modified-null-space-vector"),
        "panda": panda_run(),
        "kinova": kinova_run(),
    }


each_run = pytest.mark.parametrize("name", ["exploding", "leaving", "modified", "panda", "kinova"])


def literal_metrics(run):
    """The same sample by sample from the equations: projectors, determinants and the law's own state."""
    arm, rows = run.arm, []
    signs = None
    for i in range(len(run.t)):
        s = arm.state(run.q[i], run.v[i])
        minors = np.array([np.linalg.det(s.J[:, columns]) for columns in arm.minor_columns])
        drift = arm.jacobian_derivative(run.q[i]) @ run.v[i]
        exchanged = np.zeros(len(minors))
        for j, columns in enumerate(arm.minor_columns):
            for place, column in enumerate(columns):
                matrix = s.J[:, columns].copy()
                matrix[:, place] = drift[:, column]
                exchanged[j] += np.linalg.det(matrix)
        signs = np.sign(minors) if signs is None else signs
        part = run.v[i] - np.linalg.pinv(s.J) @ s.J @ run.v[i]
        b = s.J @ np.linalg.solve(s.M, run.tau[i] - s.nle)
        error = arm.coordinates.error(arm.coordinates.decode(run.x_desired[i]), s.x)
        soonest = [-d / r for d, r in zip(minors, exchanged, strict=True) if d * r < 0.0]
        rows.append(
            {
                "peak_torque": np.abs(run.tau[i]).max(),
                "peak_speed": np.abs(run.v[i]).max(),
                "self_motion": np.linalg.norm(part),
                "energy": part @ s.M @ part / 2.0,
                "margin": (signs * minors / arm.minor_scales).min(),
                "measure": np.prod(np.abs(minors)) ** (1.0 / len(minors)),
                "manipulability": math.sqrt(np.linalg.det(s.J @ s.J.T)),
                "distance": (np.abs(minors) / arm.minor_scales).min(),
                "soonest": min(soonest, default=math.inf),
                "product": part @ null_space_terms(s, b)[2],
                "error": np.linalg.norm(error[arm.coordinates.position_rows]),
                "turn": np.linalg.norm(error[arm.coordinates.rotation_rows]),
            }
        )
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


@each_run
def test_metrics_equal_those_of_the_literal_equations(runs, name):
    run, expected = runs[name], literal_metrics(runs[name])
    found = run.metrics()
    extremes = {
        "peak_torque": expected["peak_torque"].max(),
        "peak_speed": expected["peak_speed"].max(),
        "self_motion_max": expected["self_motion"].max(),
        "self_motion_energy_max": expected["energy"].max(),
        "margin": expected["margin"].min(),
        "minor_measure_min": expected["measure"].min(),
        "border_distance_min": expected["distance"].min(),
        "time_to_border_min": expected["soonest"].min(),
        "maciejewski_product_max": expected["product"].max(),
        "tracking_error_max": expected["error"].max(),
        "tracking_error_rms": np.sqrt((expected["error"] ** 2).mean()),
        "tracking_error_end": expected["error"][-1],
        "orientation_error_max": expected["turn"].max(),
    }
    # What is next to nothing is compared with the size of what it is the difference of.
    for key, value in extremes.items():
        assert found[key] == pytest.approx(value, rel=1e-7, abs=1e-11), key
    # √det(JJᵀ) has half the digits of the norm of the minors.
    assert found["manipulability_min"] == pytest.approx(expected["manipulability"].min(), rel=1e-6)
    assert (found["end"], found["samples"]) == (run.t[-1], len(run.t))
    assert found["torque_squared_integral"] == pytest.approx((run.tau[:-1] ** 2).sum() * run.info.dt)
    assert found["torque_total_variation"] == pytest.approx(np.abs(run.tau[1:] - run.tau[:-1]).sum())


@each_run
def test_a_time_is_when_the_extreme_occurs(runs, name):
    run, found = runs[name], runs[name].metrics()
    for key, values in (
        ("peak_torque", np.abs(run.tau).max(axis=1)),
        ("border_distance_min", run.border_distance),
        ("maciejewski_product_max", run.maciejewski_product),
    ):
        (sample,) = np.flatnonzero(np.isclose(run.t, found[f"{key}_time"], rtol=0, atol=1e-9))
        assert values[sample] == found[key]
    joint = run.arm.joint_names.index(found["peak_torque_joint"])
    assert np.abs(run.tau[:, joint]).max() == found["peak_torque"]


@each_run
def test_metrics_are_flat_in_the_documented_order_and_fit_into_json(runs, name):
    found = runs[name].metrics()
    assert list(found) == list(METRICS)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert {key: type(value) for key, value in found.items() if value is not None} == {
        key: kind for key, kind in METRICS.items() if found[key] is not None
    }


@each_run
def test_a_saved_run_has_the_same_metrics_to_the_last_bit(runs, name, tmp_path):
    runs[name].save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").metrics() == runs[name].metrics()


def test_an_aspect_is_left_when_a_minor_vanishes(runs):
    found = runs["leaving"].metrics()
    assert (found["aspect_preserved"], runs["modified"].metrics()["aspect_preserved"]) == (False, True)
    assert found["sign_changes"] > 0
    before, after = (runs["leaving"].minors[np.searchsorted(runs["leaving"].t, found["left_at"]) + i] for i in (-1, 0))
    assert np.any(before * after < 0.0)
    assert found["margin"] < 0.0 < runs["modified"].metrics()["margin"]
    assert runs["modified"].metrics()["left_at"] is None


bent = st.floats(0.4, 2.7) | st.floats(-2.7, -0.4)


@settings(max_examples=40, deadline=None)
@given(
    law=st.sampled_from(["pseudoinverse", "null-space-vector", "jmdc"]),
    q0=st.tuples(st.floats(-math.pi, math.pi), bent, bent),
    v0=st.tuples(*[st.floats(-6.0, 6.0)] * 3),
    bound=st.floats(0.0, 1.0),
)
def test_what_holds_for_the_metrics_of_every_run(law, q0, v0, bound):
    run = simulate(
        controllers.create(law, PLANAR), StraightLine([0.3, 0.2], 0.5), q0=q0, v0=v0, dt=0.01, events=["diverged"]
    )
    found = run.metrics()
    kept = found["aspect_preserved"]
    assert kept == (found["left_at"] is None) == (found["sign_changes"] == 0)
    assert kept == (found["margin"] >= 0.0)
    assert found["peak_torque_inside"] <= found["peak_torque"]
    assert not kept or found["peak_torque_inside"] == found["peak_torque"]
    # A torque that passes a threshold inside the aspect does so before the first sign change.
    threshold = bound * found["peak_torque"]
    first = run.t[np.argmax(np.abs(run.tau).max(axis=1) > threshold)] if threshold < found["peak_torque"] else math.inf
    until = math.inf if kept else found["left_at"]
    assert (found["peak_torque_inside"] > threshold) == (first < until)
    assert found["tracking_error_end"] <= found["tracking_error_max"]
    assert found["tracking_error_rms"] <= found["tracking_error_max"] * (1.0 + 1e-12)
    assert found["border_distance_min"] <= abs(found["margin"]) or not kept


def test_what_overflows_is_none_and_says_nothing(runs):
    run = runs["modified"]
    fast = run.v.copy()
    fast[-1] = 1e200
    found = dataclasses.replace(run, v=fast).metrics()
    assert found["self_motion_energy_max"] is None
    assert found["peak_speed"] == 1e200
    assert found["peak_torque"] == run.metrics()["peak_torque"]
    json.dumps(found, allow_nan=False)


def test_a_start_without_any_sign_has_no_margin():
    run = simulate(controllers.create("pseudoinverse", PLANAR), StraightLine([-0.1, 0.0], 0.2), q0=np.zeros(3), dt=0.02)
    found = run.metrics()
    assert (found["margin"], found["minors_on_border_at_start"], found["aspect_preserved"]) == (None, 3, True)
    assert (found["minor_measure_min"], found["border_distance_min"]) == (0.0, 0.0)
    json.dumps(found, allow_nan=False)


def test_a_run_without_samples_has_no_metrics(runs):
    empty = dataclasses.replace(runs["modified"], **{name: getattr(runs["modified"], name)[:0] for name in ARRAYS})
    with pytest.raises(ParameterError, match="without samples"):
        empty.metrics()
    assert len(empty.to_frame()) == 0
    assert list(empty.to_frame()) == list(runs["modified"].to_frame())


# The run as a table


@each_run
def test_a_frame_holds_the_recording_by_joint_and_by_axis(runs, name):
    run, frame = runs[name], runs[name].to_frame()
    arm = run.arm
    assert len(frame) == len(run.t)
    assert frame.columns.is_unique
    assert {str(kind) for kind in frame.dtypes} == {"float64"}
    np.testing.assert_array_equal(frame["t"], run.t)
    for i, joint in enumerate(arm.joint_names):
        np.testing.assert_array_equal(frame[f"v.{joint}"], run.v[:, i])
        np.testing.assert_array_equal(frame[f"tau.{joint}"], run.tau[:, i])
        np.testing.assert_array_equal(frame[f"q.{joint}"], [arm.positions(q)[i] for q in run.q])
    for i, axis in enumerate(arm.task):
        np.testing.assert_array_equal(frame[f"dx_desired.{axis}"], run.dx_desired[:, i])
        np.testing.assert_array_equal(frame[f"ddx_desired.{axis}"], run.ddx_desired[:, i])
    position = frame[["x.x", "x.y"]].to_numpy()
    np.testing.assert_array_equal(position, run.x[:, :2])
    error = (
        frame[[f"x.{axis}" for axis in "xyz" if f"x.{axis}" in frame]].to_numpy()
        - run.x_desired[:, : len(arm.task)][:, :3]
    )
    np.testing.assert_allclose(frame["tracking_error"], np.linalg.norm(error, axis=1), rtol=0, atol=1e-12)


@each_run
def test_the_extremes_of_a_frame_are_the_metrics(runs, name):
    frame, found = runs[name].to_frame(), runs[name].metrics()
    for column, key, extreme in (
        ("tracking_error", "tracking_error_max", "max"),
        ("orientation_error", "orientation_error_max", "max"),
        ("minor_measure", "minor_measure_min", "min"),
        ("manipulability", "manipulability_min", "min"),
        ("border_distance", "border_distance_min", "min"),
        ("time_to_border", "time_to_border_min", "min"),
        ("self_motion", "self_motion_max", "max"),
        ("self_motion_energy", "self_motion_energy_max", "max"),
        ("maciejewski_product", "maciejewski_product_max", "max"),
    ):
        assert getattr(frame[column], extreme)() == found[key]
    minors = frame[[f"minor.{i + 1}" for i in range(len(runs[name].arm.minor_columns))]].to_numpy()
    np.testing.assert_array_equal(minors, runs[name].minors)


def test_a_pose_is_a_position_and_a_quaternion(runs):
    frame = runs["panda"].to_frame()
    names = ["x", "y", "z", "qx", "qy", "qz", "qw"]
    np.testing.assert_array_equal(frame[[f"x_desired.{name}" for name in names]], runs["panda"].x_desired)
    np.testing.assert_allclose(np.linalg.norm(frame[[f"x.{name}" for name in names[3:]]], axis=1), 1.0)
