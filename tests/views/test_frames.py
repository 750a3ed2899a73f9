"""Which runs and samples moving pictures show."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aspect_control import controllers, simulate
from aspect_control.exceptions import NonFiniteError, ParameterError
from aspect_control.studies.paper import trajectory_a as paper
from aspect_control.trajectories import StraightLine
from aspect_control.views.frames import (
    aspect_changes,
    finite_part,
    finite_samples,
    frame_samples,
    frame_times,
    labelled_runs,
    samples_at,
    torque_ratio,
    torque_reference,
)


@pytest.fixture(scope="module")
def whipping():
    return paper.run_law("null-space-vector", 5e-3)


@pytest.fixture(scope="module")
def calm():
    return paper.run_law("jmdc", 5e-3)


def spoilt(run, name, sample, value=np.nan):
    array = getattr(run, name).copy()
    array[sample, -1] = value
    return replace(run, **{name: array})


@given(rate=st.floats(1.0, 500.0), speed=st.floats(0.05, 20.0))
def test_frames_are_uniform_in_time_from_the_first_to_the_last_sample(calm, rate, speed):
    samples = frame_samples(calm, rate, speed)
    assert samples[0] == 0
    assert samples[-1] == len(calm.t) - 1
    due = np.arange(len(samples) - 1) * speed / rate
    behind = due - calm.t[samples[:-1]]
    assert np.all(behind > -1e-8)
    assert np.all(behind < 5e-3 + 1e-8)
    assert (len(samples) - 1) * speed / rate >= 2.0 - 1e-6 * speed / rate - 1e-12
    assert (len(samples) - 2) * speed / rate < 2.0


def test_thirty_frames_a_second_show_every_thirtieth_of_a_second(calm):
    np.testing.assert_array_equal(frame_samples(calm), np.arange(61) * 200 // 30)


@pytest.mark.parametrize(("name", "value"), [("q", np.nan), ("v", np.inf), ("tau", -np.inf)])
def test_frames_end_with_the_finite_samples(calm, name, value):
    run = spoilt(calm, name, 123, value)
    assert finite_samples(run) == 123
    assert frame_samples(run)[-1] == 122
    assert len(finite_part(run).t) == 123
    assert finite_samples(calm) == len(calm.t)
    assert finite_part(calm) is calm


def test_runs_in_step_share_their_times_and_a_short_one_waits_at_its_end(calm):
    short = finite_part(spoilt(calm, "tau", 100))
    times = frame_times([short, calm])
    np.testing.assert_array_equal(times, frame_times([calm]))
    np.testing.assert_array_equal(samples_at(short, times)[times >= short.t[-1]], 99)


def test_the_aspect_changes_where_minors_change_sign(whipping, calm):
    changes = aspect_changes(whipping)
    signs = np.sign(whipping.minors)
    after = 1 + np.flatnonzero((signs[1:] != signs[:-1]).any(axis=1))
    assert changes.shape == after.shape == (6,)
    assert np.all(changes > whipping.t[after - 1])
    assert np.all(changes <= whipping.t[after])
    assert aspect_changes(calm).shape == (0,)
    np.testing.assert_array_equal(aspect_changes(spoilt(whipping, "q", after[3])), changes[:3])


def test_torques_are_compared_with_the_limits_of_the_joints(seven):
    law = controllers.Pseudoinverse(seven)
    line = StraightLine([0.0, 0.0, 0.01], duration=0.02)
    run = simulate(law, line, q0=[0.3, -0.4, 0.5, 0.8, -0.2, 0.6, 0.1], dt=1e-3)
    np.testing.assert_allclose(torque_ratio(run), np.abs(run.tau) / 100.0, rtol=1e-15)
    np.testing.assert_allclose(torque_ratio(run, np.full(7, 3.0)), np.abs(run.tau) / 100.0, rtol=1e-15)


def test_torques_of_joints_without_a_limit_are_compared_with_the_calmest_run(whipping, calm):
    reference = torque_reference([whipping, calm])
    np.testing.assert_array_equal(reference, np.full(3, np.abs(calm.tau).max()))
    assert torque_ratio(calm, reference).max() == 1.0
    np.testing.assert_array_equal(torque_ratio(whipping, reference), np.abs(whipping.tau) / reference)
    assert torque_ratio(whipping).max() == 1.0


def test_runs_go_by_their_laws_and_by_what_tells_them_apart(whipping, calm):
    modified = [
        paper.run_law("modified-null-space-vector", 0.05, switching=switching) for switching in ("hard", "dead-beat")
    ]
    assert list(labelled_runs(calm)) == ["JMDC"]
    assert list(labelled_runs([whipping, calm, calm])) == ["null space vector", "JMDC (1)", "JMDC (2)"]
    assert list(labelled_runs(modified)) == [
        "modified null space vector, switching = hard",
        "modified null space vector, switching = dead-beat",
    ]
    assert labelled_runs({"jmdc": calm, "mine": whipping}) == {"JMDC": calm, "mine": whipping}


@pytest.mark.parametrize("runs", [[], {}, 3, "run.npz", [None], {"a": "run.npz"}])
def test_what_is_no_run_is_refused(runs):
    with pytest.raises(ParameterError, match=r"Run"):
        labelled_runs(runs)


def test_a_run_with_nothing_to_show_is_refused(calm):
    empty = replace(calm, **{name: getattr(calm, name)[:0] for name in ("t", "q", "v", "tau", "x_desired")})
    with pytest.raises(ParameterError, match="no samples"):
        frame_samples(empty)
    with pytest.raises(NonFiniteError, match="first sample"):
        frame_samples(spoilt(calm, "q", 0))


@pytest.mark.parametrize(("rate", "speed"), [(0.0, 1.0), (30.0, -1.0), (30.0, float("nan")), (30.0, "fast")])
def test_a_rate_or_a_speed_that_is_none_is_refused(calm, rate, speed):
    with pytest.raises(ParameterError, match=r"rate|speed"):
        frame_samples(calm, rate, speed)
