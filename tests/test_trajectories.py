import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aspect_control import StraightLine, Target
from aspect_control.exceptions import NonFiniteError, ParameterError, ShapeError, UnknownNameError

EPS = np.finfo(np.float64).eps
START = np.array([0.3, -0.7])
END = START + np.array([1.5, 1.0])
A = StraightLine([1.5, 1.0], duration=2.0)

coordinates = st.integers(-(10**7), 10**7).map(lambda micrometres: 1e-6 * micrometres)
vectors = st.lists(coordinates, min_size=1, max_size=6).map(np.array)
durations = st.floats(0.1, 100.0)
inside_a_half = st.floats(0.002, 0.498) | st.floats(0.502, 0.998)


@given(t=st.floats(0.0, 2.0))
def test_trajectory_a_accelerates_at_one_and_a_half_and_one_and_then_brakes_as_hard(t):
    expected = [1.5, 1.0] if t < 1.0 - 1e-11 else [-1.5, -1.0]
    if abs(t - 1.0) > 1e-11:
        np.testing.assert_array_equal(A.target(t, START).ddx, expected)


def test_trajectory_a_leaves_the_start_at_rest():
    target = A.target(0.0, START)
    np.testing.assert_array_equal(target.x, START)
    np.testing.assert_array_equal(target.dx, 0.0)


def test_trajectory_a_arrives_at_rest_at_the_start_plus_the_displacement():
    target = A.target(2.0, START)
    np.testing.assert_array_equal(target.x, END)
    np.testing.assert_array_equal(target.dx, 0.0)


@given(start=coordinates, displacement=vectors, duration=durations)
def test_every_line_ends_at_the_start_plus_the_displacement(start, displacement, duration):
    start = np.full(displacement.shape, start)
    target = StraightLine(displacement, duration).target(duration, start)
    np.testing.assert_array_equal(target.x, start + displacement)
    np.testing.assert_array_equal(target.dx, 0.0)


@given(u=inside_a_half, start=coordinates, displacement=vectors, duration=durations)
def test_velocity_is_the_derivative_of_position(u, start, displacement, duration):
    start, line, t, h = np.full(displacement.shape, start), StraightLine(displacement, duration), u * duration, 1e-3
    h *= duration
    difference = (line.target(t + h, start).x - line.target(t - h, start).x) / (2.0 * h)
    # Central differences are exact on a parabola: what is left is the rounding of x, divided by 2h.
    rounding = 16.0 * EPS * (np.abs(start) + np.abs(displacement)) / h
    assert np.all(np.abs(difference - line.target(t, start).dx) <= rounding)


@given(u=inside_a_half, displacement=vectors, duration=durations)
def test_acceleration_is_the_derivative_of_velocity(u, displacement, duration):
    start, line, t, h = np.zeros(displacement.shape), StraightLine(displacement, duration), u * duration, 1e-3
    h *= duration
    difference = (line.target(t + h, start).dx - line.target(t - h, start).dx) / (2.0 * h)
    rounding = 16.0 * EPS * (2.0 * np.abs(displacement) / duration) / h
    assert np.all(np.abs(difference - line.target(t, start).ddx) <= rounding)


@given(displacement=vectors, duration=durations)
def test_position_and_velocity_are_continuous_at_the_jump(displacement, duration):
    start, line = np.zeros(displacement.shape), StraightLine(displacement, duration)
    before, after = line.target(duration * (0.5 - 1e-9), start), line.target(duration * 0.5, start)
    # Over 1e-9 of the duration the line moves on by at most twice that part of the displacement.
    assert np.all(np.abs(after.x - before.x) <= 2.1e-9 * np.abs(displacement))
    assert np.all(np.abs(after.dx - before.dx) <= 4.1e-9 * np.abs(displacement) / duration)


@given(before=st.floats(-1e6, -1e-9))
def test_before_the_start_it_stands_still(before):
    target = A.target(before, START)
    np.testing.assert_array_equal([target.x, target.dx, target.ddx], [START, [0, 0], [0, 0]])


@given(after=st.floats(1e-9, 1e6))
def test_after_the_end_it_stands_still(after):
    target = A.target(2.0 + after, START)
    np.testing.assert_array_equal([target.x, target.dx, target.ddx], [END, [0, 0], [0, 0]])


def test_at_the_jump_the_acceleration_is_the_one_that_follows():
    np.testing.assert_array_equal(A.target(1.0, START).ddx, [-1.5, -1.0])


def test_at_the_end_the_acceleration_is_the_one_that_was():
    np.testing.assert_array_equal(A.target(2.0, START).ddx, [-1.5, -1.0])


@given(mantissa=st.integers(1, 999), exponent=st.integers(1, 7), k=st.integers(1, 10_000))
def test_rounding_of_i_times_dt_never_changes_the_side_of_the_jump_or_of_the_end(mantissa, exponent, k):
    dt = float(f"{mantissa}e-{exponent}")
    line = StraightLine([1.0], duration=float(f"{2 * k * mantissa}e-{exponent}"))
    signs = [np.sign(line.target(i * dt, np.zeros(1)).ddx[0]) for i in (0, k - 1, k, 2 * k, 2 * k + 1)]
    assert signs == [1, 1, -1, -1, 0]


@given(duration=durations)
def test_the_only_breakpoint_is_halfway(duration):
    assert StraightLine([1.0], duration).breakpoints == (duration / 2.0,)


def test_task_dim_is_the_number_of_coordinates():
    assert StraightLine([1.0, 2.0, 3.0], 1.0).task_dim == 3


def test_repr_shows_the_line_as_it_was_constructed():
    assert repr(A) == "StraightLine([1.5, 1.0], duration=2.0, profile='bang-bang')"


@pytest.mark.parametrize("duration", [0, -1.0, np.nan, np.inf, "long", None])
def test_a_duration_that_is_not_above_zero_is_refused(duration):
    with pytest.raises(ParameterError, match="duration"):
        StraightLine([1.5, 1.0], duration)


@pytest.mark.parametrize("displacement", [[1.5, np.nan], [np.inf, 1.0]])
def test_a_displacement_that_is_not_finite_is_refused(displacement):
    with pytest.raises(NonFiniteError, match="displacement"):
        StraightLine(displacement, 2.0)


@pytest.mark.parametrize("displacement", [1.5, [[1.5, 1.0]], "far", [1.5, "far"], [[1.0], [1.0, 2.0]], None])
def test_a_displacement_that_is_no_vector_is_refused(displacement):
    with pytest.raises(ShapeError, match="displacement"):
        StraightLine(displacement, 2.0)


def test_an_unknown_profile_is_refused_with_those_that_exist():
    with pytest.raises(UnknownNameError, match=r"profile 'trapezoid'.*'bang-bang'"):
        StraightLine([1.5, 1.0], 2.0, profile="trapezoid")


def test_a_target_turns_lists_into_arrays():
    target = Target(x=[1, 2], dx=[0, 0], ddx=[0, 0])
    assert target.x.dtype == np.float64
    assert target.x.shape == (2,)


def test_a_target_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        A.target(0.0, START).x = START


@pytest.mark.parametrize("odd", ["x", "dx", "ddx"])
def test_a_target_of_unequal_shapes_is_refused(odd):
    vectors = {"x": [0.0, 0.0], "dx": [0.0, 0.0], "ddx": [0.0, 0.0], odd: [0.0, 0.0, 0.0]}
    with pytest.raises(ShapeError, match="one shape"):
        Target(**vectors)


@pytest.mark.parametrize("odd", ["x", "dx", "ddx"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_target_that_is_not_finite_is_refused(odd, value):
    vectors = {"x": [0.0, 0.0], "dx": [0.0, 0.0], "ddx": [0.0, 0.0], odd: [0.0, value]}
    with pytest.raises(NonFiniteError, match=rf"target\.{odd} must be finite"):
        Target(**vectors)


@pytest.mark.parametrize("value", [0.0, [[0.0, 0.0]], "here"])
def test_a_target_that_is_no_vector_is_refused(value):
    with pytest.raises(ShapeError, match=r"target\.x"):
        Target(x=value, dx=[0.0, 0.0], ddx=[0.0, 0.0])
