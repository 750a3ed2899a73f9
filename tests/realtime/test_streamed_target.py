"""Targets that arrive irregularly: the motion towards them keeps its limits and makes no step."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import aspect_control as ac
from aspect_control import controllers
from aspect_control.arm.tasks import Task
from aspect_control.exceptions import NonFiniteError, ShapeError
from aspect_control.realtime import RealTimeLoop, StreamedTarget
from plant_robot import PlantRobot

DT = 1e-3
LIMITS = {"speed": 0.5, "acceleration": 2.0, "jerk": 20.0}
arrivals = st.lists(
    st.tuples(st.floats(0.0, 0.4), st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=2)), min_size=1, max_size=5
)


def motion(streamed, arriving, encode):
    """Every target at the period DT, while others arrive (time since the last, value), until it stands still."""
    rows, t, k = [], 0.0, 0
    due = np.cumsum([wait for wait, _ in arriving]) if arriving else []
    waiting = list(zip(due, (value for _, value in arriving), strict=True))
    while waiting or not streamed.arrived(t):
        while waiting and waiting[0][0] <= t:
            streamed.go_to(t, waiting.pop(0)[1])
        target = streamed.target(t)
        rows.append((encode(target.x), target.dx, target.ddx))
        k += 1
        t = k * DT
    return [np.array(each) for each in zip(*rows, strict=True)]


@given(arrivals)
def test_the_motion_keeps_its_limits_and_ends_at_the_last_target(arriving):
    x, dx, ddx = motion(StreamedTarget(Task(("x", "y")), np.zeros(2), **LIMITS), arriving, np.array)
    assert np.abs(dx).max(initial=0.0) <= LIMITS["speed"] * (1 + 1e-9)
    assert np.abs(ddx).max(initial=0.0) <= LIMITS["acceleration"] * (1 + 1e-9)
    if len(x) > 1:
        assert np.abs(np.diff(ddx, axis=0)).max() <= LIMITS["jerk"] * DT * (1 + 1e-6)
        # What it says of velocity and acceleration is what the position does.
        middle = (dx[1:] + dx[:-1]) / 2 * DT
        np.testing.assert_allclose(np.diff(x, axis=0), middle, rtol=0, atol=LIMITS["jerk"] * DT**3)
        np.testing.assert_allclose(x[-1], arriving[-1][1], rtol=0, atol=1e-3)


@settings(max_examples=8)
@given(st.lists(st.tuples(st.floats(0.0, 0.3), st.integers(0, 2**32 - 1)), min_size=1, max_size=4))
def test_an_orientation_turns_without_a_step(arriving):
    """Angular velocity and acceleration are the derivatives of the orientation, whenever another target comes."""
    task, limits = Task.parse("pose"), {"speed": 4.0, "acceleration": 40.0, "jerk": 800.0}
    poses = [(wait, pin.SE3(pin.Quaternion(*turn(seed)).matrix(), np.zeros(3))) for wait, seed in arriving]
    streamed = StreamedTarget(task, pin.SE3.Identity(), **limits)
    R, dx, ddx = motion(streamed, poses, lambda pose: pose.rotation.copy())
    omega, alpha = dx[:, 3:], ddx[:, 3:]
    for before, after, w0, w1 in zip(R, R[1:], omega, omega[1:], strict=False):
        np.testing.assert_allclose(pin.log3(after @ before.T) / DT, (w0 + w1) / 2, rtol=0, atol=2e-3)
    # The entries of the rotation vector keep the limits; what the angular motion adds to them is of second order.
    assert np.linalg.norm(omega, axis=1).max(initial=0.0) <= np.sqrt(3.0) * limits["speed"] * (1 + 1e-9)
    np.testing.assert_allclose(np.diff(omega, axis=0) / DT, (alpha[1:] + alpha[:-1]) / 2, rtol=0, atol=0.5)
    np.testing.assert_allclose(R[-1], poses[-1][1].rotation, rtol=0, atol=5e-3)


def turn(seed):
    numbers = np.random.default_rng(seed).normal(size=4)
    return numbers / np.linalg.norm(numbers)


def test_every_coordinate_has_its_own_limit():
    streamed = StreamedTarget(
        Task(("x", "y")), np.zeros(2), speed=[0.1, 0.5], acceleration=[10.0, 10.0], jerk=[500.0, 500.0]
    )
    _, dx, _ = motion(streamed, [(0.0, [1.0, 1.0])], np.array)
    np.testing.assert_allclose(np.abs(dx).max(axis=0)[0], 0.1, rtol=1e-9)
    assert dx[:, 1].max() <= 0.5


@pytest.mark.parametrize("x", [np.zeros(3), "here", [np.nan, 0.0], pin.SE3.Identity()])
def test_a_target_that_is_none_is_refused(x):
    streamed = StreamedTarget(Task(("x", "y")), np.zeros(2), **LIMITS)
    with pytest.raises((ShapeError, NonFiniteError)):
        streamed.go_to(0.0, x)


def test_a_loop_follows_targets_that_arrive_irregularly(planar):
    q0 = np.deg2rad([-50.0, 140.0, -140.0])
    x0 = planar.task_position(q0)
    goals = {k: x0 + np.array(way) for k, way in ((40, [0.05, 0.0]), (55, [0.05, 0.08]), (300, [-0.03, 0.0]))}
    law = controllers.create("damped-null-space", planar)
    robot = PlantRobot(planar, q0)
    run = RealTimeLoop(robot, law).stream((goals.get(k) for k in range(301)), **LIMITS)
    assert run.status == "finished"
    assert run.info.trajectory == "stream(speed=0.5, acceleration=2.0, jerk=20.0)"
    assert np.abs(run.dx_desired).max() <= 0.5 * (1 + 1e-9)
    np.testing.assert_allclose(run.x_desired[-1], goals[300], rtol=0, atol=1e-5)
    assert run.tracking_error.max() < 1e-3


def test_a_streamed_target_that_is_none_ends_the_motion_at_rest(planar):
    q0 = np.deg2rad([-50.0, 140.0, -140.0])
    targets = iter([None, planar.task_position(q0) + 0.1, *[None] * 200, [np.nan, 0.0]])
    run = RealTimeLoop(PlantRobot(planar, q0), controllers.create("jmdc", planar)).stream(targets, **LIMITS)
    assert run.status == "failed"
    assert "NonFiniteError: the streamed target must be finite" in run.message


def test_a_stream_that_never_had_a_target_has_no_motion(planar):
    robot = PlantRobot(planar, np.deg2rad([-50.0, 140.0, -140.0]))
    with pytest.raises(ac.AspectControlError, match="the motion has no sample"):
        RealTimeLoop(robot, controllers.create("jmdc", planar)).stream([], **LIMITS)
