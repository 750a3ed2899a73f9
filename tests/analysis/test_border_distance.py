"""How far the border of the aspect is: along a run, and ahead of one."""

import json
import warnings

import numpy as np
import pytest

import aspect_control as ac
from aspect_control import controllers
from aspect_control.analysis import border_ahead, minor_zero_crossings, preview, summarize, warn_of_border_ahead
from aspect_control.exceptions import AspectBorderWarning
from aspect_control.redundancy import border_distance, minor_rates, minors, time_to_border
from aspect_control.scenario import load_scenario
from aspect_control.studies.paper import trajectory_a as paper
from example_arms import example_arm, random_motions, slopes

READY = [0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4]


@pytest.fixture(scope="module")
def leaving():
    """The pseudoinverse law on trajectory A, which leaves its aspect at 1.79 s."""
    return paper.run_law("pseudoinverse", 2e-3)


# Along a run


@pytest.mark.parametrize(("robot", "task"), [("planar3r", "xy"), ("panda", "xyz"), ("panda", "pose"), ("tiago", "xyz")])
def test_rates_are_the_slopes_of_the_minors_along_the_motion(robot, task):
    arm = example_arm(robot, task)
    for q, v in random_motions(arm, 4, seed=41):
        J, dJ = arm.jacobian(q), arm.jacobian_derivative(q)
        gradients = slopes(arm, lambda p: minors(arm.jacobian(p), arm.minor_columns), q)
        scale = np.abs(gradients).max()
        each = minor_rates(J, np.moveaxis(dJ, -1, 0), arm.minor_columns).T
        np.testing.assert_allclose(each, gradients, rtol=0, atol=1e-9 * scale)
        np.testing.assert_allclose(minor_rates(J, dJ @ v, arm.minor_columns), each @ v, rtol=0, atol=1e-12 * scale)


def test_rates_hold_on_a_border_too(planar):
    q = np.array([0.4, 0.7, 0.0])  # δ₂ = ℓ₂ℓ₃S₃
    J, dJ = planar.jacobian(q), planar.jacobian_derivative(q)
    expected = slopes(planar, lambda p: minors(planar.jacobian(p)), q)
    assert np.abs(minors(J)).min() < 1e-15
    np.testing.assert_allclose(minor_rates(J, np.moveaxis(dJ, -1, 0)).T, expected, rtol=0, atol=1e-9)


def test_arrays_of_a_run_are_those_of_its_samples(leaving):
    arm = leaving.arm
    assert leaving.minor_measure.shape == leaving.border_distance.shape == leaving.time_to_border.shape == (1001,)
    assert leaving.minor_rates.shape == (1001, 3)
    for i in range(0, 1001, 100):
        delta = minors(arm.jacobian(leaving.q[i]))
        assert leaving.minor_measure[i] == pytest.approx(abs(delta.prod()) ** (1 / 3), rel=1e-12)
        assert leaving.border_distance[i] == pytest.approx(min(abs(delta) / arm.minor_scales), rel=1e-12)
    # δ̇ along the recording, by central differences of its samples.
    inner = (leaving.minors[2:] - leaving.minors[:-2]) / (leaving.t[2:] - leaving.t[:-2])[:, np.newaxis]
    smooth = np.abs(leaving.t[1:-1] - 1.0) > 0.003  # the acceleration jumps at 1 s
    np.testing.assert_allclose(
        leaving.minor_rates[1:-1][smooth], inner[smooth], rtol=0, atol=1e-4 * np.abs(inner).max()
    )


def test_the_distances_find_the_border_where_the_minor_changes_sign(leaving):
    ((_, time),) = minor_zero_crossings(leaving)
    assert time == pytest.approx(1.79, abs=0.005)
    assert leaving.t[leaving.border_distance.argmin()] == pytest.approx(time, abs=leaving.info.dt)
    assert leaving.t[leaving.minor_measure.argmin()] == pytest.approx(time, abs=leaving.info.dt)
    # Near the border the time to it is what is left.
    for ahead in (0.02, 0.01):
        sample = int((time - ahead) / leaving.info.dt)
        assert leaving.time_to_border[sample] == pytest.approx(time - leaving.t[sample], rel=0.1)


def test_time_to_border_is_of_the_first_minor_that_shrinks():
    delta, rate = np.array([2.0, -3.0, 1.0]), np.array([-1.0, 6.0, 5.0])
    assert time_to_border(delta, rate) == 0.5
    assert time_to_border(delta, -rate) == 0.2
    assert time_to_border(delta, np.sign(delta)) == np.inf
    assert time_to_border(delta, np.zeros(3)) == np.inf
    assert time_to_border(np.array([0.0, 1.0]), np.zeros(2)) == 0.0
    assert time_to_border(np.stack([delta, delta]), np.stack([rate, -rate])).tolist() == [0.5, 0.2]
    assert border_distance(delta, np.array([1.0, 6.0, 0.5])) == 0.5
    assert time_to_border(np.empty(0), np.empty(0)) == border_distance(np.empty(0), np.empty(0)) == np.inf


def test_the_summary_has_the_minima(leaving):
    summary = json.loads(json.dumps(summarize(leaving), allow_nan=False))
    assert summary["minor_measure_min"] == leaving.minor_measure.min()
    assert summary["border_distance_min"] == leaving.border_distance.min() < 0.01
    assert summary["border_distance_min_time"] == pytest.approx(1.79, abs=0.005)
    assert summary["time_to_border_min"] == leaving.time_to_border.min() < 0.01
    resting = ac.simulate(controllers.Pseudoinverse(leaving.arm), ac.Hold(0.1), q0=paper.Q0, dt=0.01)
    assert np.isinf(resting.time_to_border[0])


# Ahead of a run


@pytest.mark.parametrize("name", ["planar3r", "panda-xyz", "kinova-xyz"])
def test_a_prediction_says_where_the_run_will_leave_its_aspect(name):
    setup = load_scenario(name).build()
    arm, q0, trajectory = setup.arm, setup.q0, setup.trajectory
    for law in ("pseudoinverse", "jmdc"):
        controller = controllers.create(law, arm)
        coarse = preview(controller, trajectory, q0=q0)
        run = ac.simulate(controller, trajectory, q0=q0, dt=2e-3)
        assert len(coarse.t) <= 201
        ahead, actual = border_ahead(coarse), border_ahead(run)
        assert (ahead is None) == (actual is None)
        if ahead is not None and actual is not None:
            assert (ahead.minor, ahead.crossed) == (actual.minor, True)
            assert ahead.time == pytest.approx(actual.time, abs=0.02)


def test_the_warning_names_law_time_and_joints_and_points_at_the_call(planar):
    law = controllers.Pseudoinverse(planar)
    with pytest.warns(AspectBorderWarning) as caught:
        ahead = warn_of_border_ahead(law, paper.TRAJECTORY, q0=paper.Q0)
    assert str(caught[0].message) == (
        "pseudoinverse leaves its aspect at t = 1.79 s, where minor 3 (joint1, joint3) changes sign, "
        "by a coarse prediction"
    )
    assert caught[0].filename == __file__
    assert (ahead.minor, ahead.crossed, ahead.distance) == (3, True, 0.0)


def test_nothing_is_said_of_a_motion_inside_its_aspect_and_nothing_by_simulate(planar):
    assert warn_of_border_ahead(controllers.JMinorDynamicControl(planar), paper.TRAJECTORY, q0=paper.Q0) is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ac.simulate(controllers.Pseudoinverse(planar), paper.TRAJECTORY, q0=paper.Q0, dt=0.02)


def test_a_motion_that_only_comes_near_a_border_is_told_apart(planar):
    law = controllers.Pseudoinverse(planar)
    with pytest.warns(AspectBorderWarning, match=r"comes near the border of its aspect at t = .* falls to 0\.\d+ % of"):
        ahead = warn_of_border_ahead(law, ac.Hold(1.0), q0=[0.3, 0.9, 0.005], label="holding")
    assert not ahead.crossed
    assert ahead.distance == pytest.approx(np.sin(0.005) / planar.minor_scales[ahead.minor - 1], rel=1e-3)


def test_minors_without_a_sign_at_the_start_are_left_out_and_the_start_is_not_reported_twice():
    arm = example_arm("panda")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        coarse = preview(controllers.JMinorDynamicControl(arm), ac.Hold(0.2), q0=READY)
    assert coarse.border_distance[0] < 1e-12
    assert border_ahead(coarse) is None


def test_a_prediction_is_as_coarse_as_stiff_feedback_allows_and_its_failure_is_silent(planar):
    stiff = controllers.Pseudoinverse(planar, kp=1e4, kv=200.0)
    run = preview(stiff, paper.TRAJECTORY, q0=paper.Q0)
    assert run.info.dt == pytest.approx(1e-3)
    assert run.status == "finished"

    class Overflowing(controllers.NullSpaceVector):
        def command(self, state, target):
            return super().command(state, target) * np.inf

    overflowing = Overflowing(planar)
    assert warn_of_border_ahead(overflowing, paper.TRAJECTORY, q0=paper.Q0, v0=[0.1, 0.2, 0.1]) is None
