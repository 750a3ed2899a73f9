import dataclasses
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from aspect_control.arm.tasks import Task
from aspect_control.exceptions import NonFiniteError, ParameterError, ShapeError, UnknownNameError
from aspect_control.trajectories import PROFILES, Circle, Hold, StraightLine, Target, Trajectory, Waypoints
from aspect_control.trajectories.rotation_vector import angular_motion

EPS = np.finfo(np.float64).eps
START = np.array([0.3, -0.7])
END = START + np.array([1.5, 1.0])
A = StraightLine([1.5, 1.0], duration=2.0)

coordinates = st.integers(-(10**7), 10**7).map(lambda micrometres: 1e-6 * micrometres)
vectors = st.lists(coordinates, min_size=1, max_size=3).map(np.array)
durations = st.floats(0.1, 100.0)
inside_a_half = st.floats(0.002, 0.498) | st.floats(0.502, 0.998)

TASKS = [Task.parse(task) for task in ("xy", "xyz", "pose", ("x", "y", "rz"), ("rx", "ry", "rz"))]
POSE = Task.parse("pose")
ORIENTATION = Task.parse(("rx", "ry", "rz"))
POINTS = [[0.3, 0.0], [0.3, -0.4], [1.5, 0.5]]
EVERY_KIND = [
    StraightLine([0.3, -0.2], 2.0, "quintic"),
    Circle(0.2, 2.0),
    Hold(2.0),
    Waypoints(POINTS, duration=2.0),
    Waypoints(POINTS, times=[0.5, 0.7, 2.0]),
]

tasks = st.sampled_from(TASKS)
profiles = st.sampled_from(sorted(PROFILES))
lengths = st.integers(-2000, 2000).map(lambda millimetres: 1e-3 * millimetres)
turns = st.floats(-3.0, -0.1) | st.floats(0.1, 3.0)


def entries(count):
    return st.lists(lengths, min_size=count, max_size=count).map(np.array)


def starts(task):
    if not task.has_rotation:
        return entries(task.dim)
    return st.builds(lambda phi, position: pin.SE3(pin.exp3(phi), position), entries(3), entries(3))


def lines(task):
    return st.builds(StraightLine, entries(task.dim), durations, profiles)


def circles(planes=("xy", "yx")):
    return st.builds(Circle, st.floats(0.01, 2.0), durations, st.sampled_from(planes), turns, profiles)


@st.composite
def waypoints(draw, task):
    stretches = draw(st.lists(st.integers(1, 5), min_size=1, max_size=4))
    points = draw(st.lists(entries(task.dim), min_size=len(stretches), max_size=len(stretches)))
    return Waypoints(points, times=draw(durations) * np.cumsum(stretches) / sum(stretches))


@st.composite
def motions(draw):
    """A task, a start and a trajectory for it."""
    task = draw(tasks)
    kinds = [lines(task), st.builds(Hold, durations), waypoints(task)]
    if {"x", "y"} <= set(task.axes):
        kinds.append(circles())
    return task, draw(starts(task)), draw(st.one_of(kinds))


def seams(trajectory):
    """The times at which some derivative of the motion jumps."""
    inner = trajectory.times if getattr(trajectory, "times", None) is not None else ()
    return [0.0, *trajectory.breakpoints, *inner, trajectory.duration]


def change(task, later, earlier):
    """What leads from one task value to another: the rotation rows as a rotation vector in the world frame."""
    if not task.has_rotation:
        return later - earlier
    rotation = pin.log3(later.rotation @ earlier.rotation.T)
    return np.concatenate([later.translation - earlier.translation, rotation])[task.rows]


def derivative(difference, h):
    """The central difference quotient of fourth order; `difference(h)` leads from −h to h."""
    return (8.0 * difference(h) - difference(2.0 * h)) / (12.0 * h)


def same_value(task, actual, expected, atol=1e-12):
    np.testing.assert_allclose(change(task, actual, expected), 0.0, atol=atol)


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


def assert_consistent(trajectory, start, task, u):
    """Hold the velocity and the acceleration against central differences."""
    t, h = u * trajectory.duration, 1e-4 * trajectory.duration
    assume(min(abs(t - seam) for seam in seams(trajectory)) > 2.1 * h)
    target = trajectory.target(t, start, task)

    def at(delta):
        return trajectory.target(t + delta, start, task)

    dx = derivative(lambda h: change(task, at(h).x, at(-h).x), h)
    ddx = derivative(lambda h: at(h).dx - at(-h).dx, h)
    # Per duration and its square; the fastest of these motions passes 80 m and 80 rad a duration.
    np.testing.assert_allclose(target.dx * trajectory.duration, dx * trajectory.duration, rtol=1e-7, atol=1e-7)
    scale = trajectory.duration**2
    np.testing.assert_allclose(target.ddx * scale, ddx * scale, rtol=1e-6, atol=1e-6)


@given(motion=motions(), u=st.floats(0.0, 1.0))
def test_every_velocity_is_the_derivative_of_the_value_and_every_acceleration_that_of_the_velocity(motion, u):
    task, start, trajectory = motion
    assert_consistent(trajectory, start, task, u)


@pytest.mark.parametrize("task", [POSE, ORIENTATION, Task.parse(("ry", "x", "rz")), Task.parse(("rx", "ry"))], ids=str)
@given(u=st.floats(0.0, 1.0), phi=entries(3))
def test_waypoints_whose_axis_of_rotation_turns_have_consistent_rates(task, u, phi):
    points = np.array(
        [[0.9, -0.7, 0.4, 1.3, 0.2, -0.8], [-0.5, 1.1, 1.6, -0.6, 2.1, 0.3], [0.2, 0.8, -1.0, 0.4, 1.0, 2.9]]
    )
    start = pin.SE3(pin.exp3(phi), np.array([0.1, 0.2, 0.3]))
    curve = Waypoints(points[:, : task.dim], times=[0.8, 2.0, 2.5])
    assert_consistent(curve, start, task, u)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 1e-8, 1e-4, 1.5e-4, 1e-3, 0.1, 1.0, np.pi, 2 * np.pi, 20.0])
def test_the_angular_motion_is_right_at_every_angle(angle):
    axis, dphi, ddphi = np.array([0.48, -0.6, 0.64]), np.array([0.7, 1.1, -0.4]), np.array([-2.0, 0.3, 0.9])

    def velocity(t):
        # Pinocchio's is the right Jacobian: that of the inverse rotation gives world coordinates.
        return pin.Jexp3(-(angle * axis + dphi * t + ddphi * t**2 / 2.0)) @ (dphi + ddphi * t)

    omega, alpha = angular_motion(angle * axis, dphi, ddphi)
    np.testing.assert_allclose(omega, velocity(0.0), atol=1e-11)
    np.testing.assert_allclose(alpha, derivative(lambda h: velocity(h) - velocity(-h), 1e-3), atol=1e-8)


@given(motion=motions())
def test_every_motion_starts_at_the_start_and_leaves_and_arrives_at_rest(motion):
    task, start, trajectory = motion
    begin, end = (trajectory.target(t, start, task) for t in (0.0, trajectory.duration))
    same_value(task, begin.x, start)
    np.testing.assert_allclose([begin.dx * trajectory.duration, end.dx * trajectory.duration], 0.0, atol=1e-11)


@given(motion=motions(), early=st.floats(1e-9, 1e6), late=st.floats(1e-9, 1e6))
def test_every_motion_stands_still_outside(motion, early, late):
    task, start, trajectory = motion
    before = trajectory.target(-early * trajectory.duration, start, task)
    after = trajectory.target((1.0 + late) * trajectory.duration, start, task)
    np.testing.assert_array_equal([before.dx, before.ddx, after.dx, after.ddx], 0.0)
    same_value(task, before.x, start)
    same_value(task, after.x, trajectory.target(trajectory.duration, start, task).x)


@given(motion=motions())
def test_times_within_rounding_of_the_end_are_the_end(motion):
    task, start, trajectory = motion
    last, next_float = (trajectory.target(trajectory.duration * (1.0 + e), start, task) for e in (0.0, 2.0 * EPS))
    np.testing.assert_array_equal(last.ddx, next_float.ddx)


@given(motion=motions(), u=st.floats(0.0, 1.0))
def test_the_acceleration_jumps_at_the_breakpoints_and_nowhere_else(motion, u):
    task, start, trajectory = motion

    def jump(t):
        before, after = (trajectory.target(t + e * trajectory.duration, start, task) for e in (-1e-9, 1e-9))
        return trajectory.duration**2 * np.linalg.norm(after.ddx - before.ddx)

    length = trajectory.duration * max(
        np.linalg.norm(trajectory.target(v * trajectory.duration, start, task).dx) for v in (0.25, 0.5, 0.75)
    )
    assert all(jump(b) >= 2.0 * length for b in trajectory.breakpoints)
    t = u * trajectory.duration
    assume(min(abs(t - b) for b in (0.0, *trajectory.breakpoints, trajectory.duration)) > 1e-8 * trajectory.duration)
    # The steepest of these motions changes its acceleration by 2e6 a duration.
    assert jump(t) < 4e-3


@given(task=tasks, data=st.data(), profile=profiles, duration=durations)
def test_every_line_ends_where_its_displacement_leads(task, data, profile, duration):
    displacement, start = data.draw(entries(task.dim)), data.draw(starts(task))
    end = StraightLine(displacement, duration, profile).target(duration, start, task)
    same_value(task, end.x, task.displaced(start, displacement))
    np.testing.assert_array_equal(end.dx, 0.0)


@given(data=st.data(), profile=profiles, u=st.floats(0.0, 1.0), task=st.sampled_from([POSE, ORIENTATION]))
def test_a_line_turns_about_one_axis_all_the_way(data, profile, u, task):
    start = data.draw(starts(task))
    displacement = data.draw(entries(task.dim))
    assume(0.01 < np.linalg.norm(displacement[-3:]) < np.pi)
    target = StraightLine(displacement, 1.0, profile).target(u, start, task)
    s, ds, dds = PROFILES[profile](u)
    turned = pin.log3(target.x.rotation @ start.rotation.T)
    np.testing.assert_allclose(turned, s * displacement[-3:], atol=1e-7)
    np.testing.assert_array_equal([target.dx, target.ddx], [ds * displacement, dds * displacement])


def test_a_task_value_that_is_a_pose_is_taken_for_the_task_pose():
    start, displacement = pin.SE3(pin.exp3(np.array([0.1, 0.2, 0.3])), np.ones(3)), np.arange(6.0) / 10.0
    line = StraightLine(displacement, 1.0)
    same_value(POSE, line.target(0.3, start).x, line.target(0.3, start, POSE).x)


def test_a_partial_rotation_leaves_the_other_coordinates_alone():
    start = pin.SE3(pin.exp3(np.array([0.4, -0.3, 0.2])), np.array([0.1, 0.2, 0.3]))
    end = StraightLine([1.0, 2.0, 4.0], 1.0).target(1.0, start, Task.parse(("x", "y", "rz"))).x
    np.testing.assert_allclose(end.translation, [1.1, 2.2, 0.3])
    np.testing.assert_allclose(end.rotation, pin.exp3(np.array([0.0, 0.0, 4.0])) @ start.rotation, atol=1e-15)


def test_the_rows_follow_the_order_of_the_task():
    start = np.array([0.1, 0.2])
    yx = Circle(0.2, 1.0, turns=0.25).target(1.0, start, Task.parse(("y", "x")))
    np.testing.assert_allclose(yx.x, [0.3, 0.4])


@given(circle=circles(("xy", "yx", "xz", "zx", "yz", "zy")), u=st.floats(0.0, 1.0), task=st.sampled_from(TASKS[1:3]))
def test_a_circle_stays_at_its_radius_from_a_centre_one_radius_along_the_first_axis(circle, u, task):
    start = np.array([0.3, -0.2, 0.5])
    value = pin.SE3(pin.exp3(np.array([0.5, -1.0, 0.2])), start) if task.has_rotation else start
    target = circle.target(u * circle.duration, value, task)
    position = target.x.translation if task.has_rotation else target.x
    first, second = ("xyz".index(axis) for axis in circle.plane)
    centre = start + circle.radius * np.eye(3)[first]
    assert np.linalg.norm(position - centre) == pytest.approx(circle.radius, rel=1e-12)
    (third,) = {0, 1, 2} - {first, second}
    assert position[third] == start[third]
    np.testing.assert_array_equal([target.dx[third], target.ddx[third]], 0.0)
    if task.has_rotation:
        np.testing.assert_array_equal(target.x.rotation, value.rotation)
        np.testing.assert_array_equal([target.dx[3:], target.ddx[3:]], 0.0)


@given(radius=st.floats(0.01, 2.0), count=st.sampled_from([-3, -1, 1, 2]), duration=durations, profile=profiles)
def test_whole_turns_close_the_circle(radius, count, duration, profile):
    circle = Circle(radius, duration, "xz", turns=count, profile=profile)
    np.testing.assert_allclose(circle.target(duration, np.zeros(3)).x, 0.0, atol=1e-14)


@pytest.mark.parametrize("turns", [1, -1])
def test_a_circle_sets_off_along_the_second_axis_or_against_it(turns):
    x = Circle(0.5, 1.0, "xy", turns).target(0.5, START).x - START
    early = Circle(0.5, 1.0, "xy", turns).target(0.1, START).x - START
    np.testing.assert_allclose(x, [1.0, 0.0], atol=1e-15)
    assert np.sign(early[1]) == turns
    assert early[0] > 0.0


def test_a_circle_of_unit_speed_has_the_centripetal_acceleration():
    # Trapezoidal: at half time the angle grows at 1.5 turns a duration.
    target = Circle(0.5, 3.0, "xy", profile="trapezoidal").target(1.5, START)
    speed = np.pi * 0.5
    np.testing.assert_allclose(target.dx, [0.0, -speed], atol=1e-15)
    np.testing.assert_allclose(target.ddx, [-(speed**2) / 0.5, 0.0], atol=1e-14)


@given(motion=tasks.flatmap(lambda task: st.tuples(st.just(task), starts(task), waypoints(task))))
def test_waypoints_are_passed_at_their_times(motion):
    task, start, curve = motion
    for point, time in zip(curve.points, curve.times, strict=True):
        same_value(task, curve.target(time, start, task).x, task.displaced(start, point))


@given(data=st.data(), task=tasks, duration=durations, u=st.floats(0.0, 1.0))
def test_one_waypoint_is_the_cubic_line(data, task, duration, u):
    start, displacement = data.draw(starts(task)), data.draw(entries(task.dim))
    curve, line = Waypoints([displacement], duration), StraightLine(displacement, duration, "cubic")
    ours, theirs = (trajectory.target(u * duration, start, task) for trajectory in (curve, line))
    same_value(task, ours.x, theirs.x)
    np.testing.assert_allclose(ours.dx * duration, theirs.dx * duration, atol=1e-11)
    np.testing.assert_allclose(ours.ddx * duration**2, theirs.ddx * duration**2, atol=1e-10)


def test_waypoints_share_the_duration_in_proportion_to_the_distances():
    curve = Waypoints([[3.0, 4.0], [3.0, 14.0], [8.0, 14.0]], duration=4.0)
    for time, point in zip([1.0, 3.0, 4.0], curve.points, strict=True):
        np.testing.assert_allclose(curve.target(time, START).x, START + point)


def test_waypoints_that_are_all_at_the_start_stand_still():
    for t in (0.0, 0.3, 1.0):
        target = Waypoints(np.zeros((3, 2)), duration=1.0).target(t, START)
        np.testing.assert_array_equal([target.x, target.dx, target.ddx], [START, [0, 0], [0, 0]])


def test_a_rotation_vector_among_waypoints_may_be_longer_than_half_a_turn():
    start, task = pin.SE3.Identity(), Task.parse(("x", "y", "rz"))
    curve = Waypoints([[0.0, 0.0, 2 * np.pi], [0.0, 0.0, 4 * np.pi]], duration=1.0)
    speeds = [curve.target(t, start, task).dx for t in np.linspace(0.0, 1.0, 101)]
    np.testing.assert_array_equal(np.array(speeds)[:, :2], 0.0)
    assert np.mean(np.array(speeds)[:, 2]) == pytest.approx(4 * np.pi, rel=0.02)


@given(profile=profiles, u=st.floats(0.0, 1.0))
@example(profile="trapezoidal", u=1.0 / 3.0)
@example(profile="trapezoidal", u=2.0 / 3.0)
def test_every_profile_goes_from_zero_to_one_without_turning_back_and_as_it_came(profile, u):
    s, ds, dds = PROFILES[profile](u)
    assert -1e-14 <= s <= 1.0 + 1e-14
    assert ds >= 0.0
    assume(all(abs(u - b) > 1e-11 for b in (0.0, 1.0, *PROFILES[profile].breakpoints)))
    np.testing.assert_allclose(PROFILES[profile](1.0 - u), [1.0 - s, ds, -dds], atol=1e-12)


@pytest.mark.parametrize(
    ("profile", "peak_speed", "peak_acceleration"),
    [("bang-bang", 2.0, 4.0), ("trapezoidal", 1.5, 4.5), ("cubic", 1.5, 6.0), ("quintic", 1.875, 10 / np.sqrt(3))],
)
def test_the_peaks_of_the_profiles_are_those_of_the_textbook(profile, peak_speed, peak_acceleration):
    progress = np.array([PROFILES[profile](u) for u in np.linspace(0.0, 1.0, 20001)])
    np.testing.assert_allclose(np.abs(progress).max(axis=0), [1.0, peak_speed, peak_acceleration], rtol=1e-7)


@given(mantissa=st.integers(1, 999), exponent=st.integers(1, 7), k=st.integers(2, 10_000))
def test_rounding_of_i_times_dt_never_changes_the_side_of_a_third(mantissa, exponent, k):
    dt = float(f"{mantissa}e-{exponent}")
    line = StraightLine([1.0], float(f"{3 * k * mantissa}e-{exponent}"), "trapezoidal")
    steps = (0, k - 1, k, 2 * k - 1, 2 * k, 3 * k, 3 * k + 1)
    assert [np.sign(line.target(i * dt, np.zeros(1)).ddx[0]) for i in steps] == [1, 1, 0, 0, -1, -1, 0]


@pytest.mark.parametrize(
    ("profile", "parts"), [("bang-bang", [1 / 2]), ("trapezoidal", [1 / 3, 2 / 3]), ("cubic", []), ("quintic", [])]
)
def test_the_breakpoints_are_those_of_the_profile(profile, parts):
    for trajectory in (StraightLine([1.0, 0.0], 3.0, profile), Circle(0.1, 3.0, profile=profile)):
        assert trajectory.breakpoints == tuple(3.0 * part for part in parts)


@given(duration=durations)
def test_the_only_breakpoint_is_halfway(duration):
    assert StraightLine([1.0], duration).breakpoints == (duration / 2.0,)


def test_task_dim_is_the_number_of_coordinates():
    assert StraightLine([1.0, 2.0, 3.0], 1.0).task_dim == 3


def test_task_dim_is_none_where_any_task_will_do():
    assert [trajectory.task_dim for trajectory in EVERY_KIND] == [2, None, None, 2, 2]


@pytest.mark.parametrize(
    ("trajectory", "shown"),
    [
        (A, "StraightLine([1.5, 1.0], duration=2.0, profile='bang-bang')"),
        (Circle(0.2, 2, "zx", -1), "Circle(0.2, duration=2.0, plane='zx', turns=-1.0, profile='quintic')"),
        (Hold(np.float64(2.0)), "Hold(duration=2.0)"),
        (Waypoints(POINTS[:1], 2), "Waypoints([[0.3, 0.0]], duration=2.0)"),
        (Waypoints(POINTS[:2], times=[1, 2]), "Waypoints([[0.3, 0.0], [0.3, -0.4]], times=[1.0, 2.0])"),
    ],
)
def test_repr_shows_the_trajectory_as_it_was_constructed(trajectory, shown):
    assert repr(trajectory) == shown
    assert repr(eval(shown)) == shown  # noqa: S307


def test_only_waypoints_need_scipy():
    code = (
        "import sys, numpy as np, pinocchio as pin\n"
        "from aspect_control.trajectories import *\n"
        "for motion in (StraightLine(np.ones(6), 1.0), Circle(0.1, 1.0), Hold(1.0)):\n"
        "    motion.target(0.3, pin.SE3.Identity())\n"
        "assert 'scipy' not in sys.modules\n"
        "Waypoints([[1.0]], 1.0)\n"
        "assert 'scipy' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("duration", [0, -1.0, np.nan, np.inf, "long", None, True])
@pytest.mark.parametrize(
    "construct",
    [
        lambda duration: StraightLine([1.5, 1.0], duration),
        lambda duration: Circle(0.1, duration),
        Hold,
        lambda duration: Waypoints(POINTS, duration),
    ],
    ids=["StraightLine", "Circle", "Hold", "Waypoints"],
)
def test_a_duration_that_is_not_above_zero_is_refused(construct, duration):
    with pytest.raises(ParameterError, match="duration"):
        construct(duration)


@pytest.mark.parametrize("displacement", [[1.5, np.nan], [np.inf, 1.0]])
def test_a_displacement_that_is_not_finite_is_refused(displacement):
    with pytest.raises(NonFiniteError, match="displacement"):
        StraightLine(displacement, 2.0)


@pytest.mark.parametrize("displacement", [1.5, [[1.5, 1.0]], "far", [1.5, "far"], [[1.0], [1.0, 2.0]], None])
def test_a_displacement_that_is_no_vector_is_refused(displacement):
    with pytest.raises(ShapeError, match="displacement"):
        StraightLine(displacement, 2.0)


@pytest.mark.parametrize("line", [True, False])
@pytest.mark.parametrize("profile", ["trapezoid", "", None, 3, ["cubic"]])
def test_an_unknown_profile_is_refused_with_those_that_exist(line, profile):
    with pytest.raises(UnknownNameError, match=r"unknown profile .*'bang-bang', 'trapezoidal', 'cubic', 'quintic'"):
        StraightLine([1.5, 1.0], 2.0, profile) if line else Circle(0.1, 2.0, profile=profile)


@pytest.mark.parametrize("radius", [0, -0.1, np.nan, np.inf, "wide", None])
def test_a_radius_that_is_not_above_zero_is_refused(radius):
    with pytest.raises(ParameterError, match=r"radius must be a (finite )?number"):
        Circle(radius, 1.0)


@pytest.mark.parametrize("turns", [0, 0.0, -0.0, np.nan, np.inf, "once", None, True])
def test_turns_that_are_zero_or_no_number_are_refused(turns):
    with pytest.raises(ParameterError, match="turns must"):
        Circle(0.1, 1.0, turns=turns)


@pytest.mark.parametrize("plane", ["xx", "x", "xyz", "XY", "xw", "", None, 3, ["x", "y"]])
def test_an_unknown_plane_is_refused_with_those_that_exist(plane):
    with pytest.raises(UnknownNameError, match=r"unknown plane .*available: 'xy', 'xz', 'yx', 'yz', 'zx', 'zy'"):
        Circle(0.1, 1.0, plane)


@pytest.mark.parametrize(
    ("plane", "task", "start", "missing"),
    [
        ("xz", None, np.zeros(2), r"\('x', 'y'\) has no 'z'"),
        ("xy", ORIENTATION, pin.SE3.Identity(), r"has no 'x' and 'y'"),
    ],
)
def test_a_circle_in_a_plane_that_the_task_lacks_is_refused(plane, task, start, missing):
    with pytest.raises(ParameterError, match=f"plane '{plane}'.*{missing}"):
        Circle(0.1, 1.0, plane).target(0.0, start, task)


@pytest.mark.parametrize("points", [[], [[]], [1.0, 2.0], 1.0, [[[1.0]]], "far", [[1.0], [1.0, 2.0]], None])
def test_points_that_are_no_matrix_are_refused(points):
    with pytest.raises(ShapeError, match="points must"):
        Waypoints(points, 1.0)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_points_that_are_not_finite_are_refused(value):
    with pytest.raises(NonFiniteError, match="points must be finite"):
        Waypoints([[1.0, value]], 1.0)


@pytest.mark.parametrize("when", [{}, {"duration": 2.0, "times": [0.5, 1.0, 2.0]}])
def test_waypoints_take_either_a_duration_or_times(when):
    with pytest.raises(ParameterError, match="either duration or times"):
        Waypoints(POINTS, **when)


@pytest.mark.parametrize("times", [[0.0, 1.0, 2.0], [-1.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, 2.0, 1.5], [1, 2, -3]])
def test_times_that_do_not_increase_from_above_zero_are_refused(times):
    with pytest.raises(ParameterError, match="times"):
        Waypoints(POINTS, times=times)


@pytest.mark.parametrize("times", [[1.0, 2.0], [1.0, 2.0, 3.0, 4.0], 1.0, "soon"])
def test_times_that_are_not_one_a_point_are_refused(times):
    with pytest.raises(ShapeError, match="times must"):
        Waypoints(POINTS, times=times)


def test_times_that_are_not_finite_are_refused():
    with pytest.raises(NonFiniteError, match="times must be finite"):
        Waypoints(POINTS, times=[1.0, 2.0, np.inf])


@pytest.mark.parametrize("points", [[[0.0], [1.0]], [[1.0], [1.0]]])
def test_no_time_between_two_points_in_one_place_is_refused(points):
    with pytest.raises(ParameterError, match=r"must differ.*give times instead"):
        Waypoints(points, duration=1.0)


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
@pytest.mark.parametrize("t", [np.nan, np.inf, "now", None])
def test_a_time_that_is_no_finite_number_is_refused(trajectory, t):
    with pytest.raises(ParameterError, match="t must be a finite number"):
        trajectory.target(t, START)


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
@pytest.mark.parametrize("start", [0.0, [[0.0, 0.0]], "here", np.zeros(4), None])
def test_a_start_that_is_no_task_value_is_refused(trajectory, start):
    with pytest.raises(ShapeError, match="start"):
        trajectory.target(0.0, start)


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
def test_a_start_of_another_kind_than_the_task_is_refused(trajectory):
    with pytest.raises(ShapeError, match=r"start must be a pin\.SE3"):
        trajectory.target(0.0, START, POSE)
    with pytest.raises(ShapeError, match="start must"):
        trajectory.target(0.0, pin.SE3.Identity(), TASKS[0])


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
def test_a_start_that_is_not_finite_is_refused(trajectory):
    with pytest.raises(NonFiniteError, match="start must be finite"):
        trajectory.target(0.0, [0.0, np.nan])


@pytest.mark.parametrize("trajectory", [A, Waypoints(POINTS, 2.0)], ids=repr)
def test_a_task_of_another_number_of_coordinates_is_refused(trajectory):
    with pytest.raises(ShapeError, match=r"the trajectory has 2 task coordinates, the task .* has 6"):
        trajectory.target(0.0, pin.SE3.Identity())
    with pytest.raises(ShapeError, match=r"the trajectory has 2 task coordinates, the task .* has 1"):
        trajectory.target(0.0, [0.0])


def test_the_start_and_what_a_trajectory_was_made_from_are_never_changed():
    points, start = np.ones((2, 6)) * [[1.0], [2.0]], pin.SE3.Identity()
    curve = Waypoints(points, 1.0)
    x = curve.target(0.0, start).x
    x.translation = np.full(3, 9.0)
    points[:] = 9.0
    np.testing.assert_array_equal(start.homogeneous, np.eye(4))
    np.testing.assert_array_equal(curve.points[1], 2.0)


def test_a_trajectory_of_ones_own_needs_a_target_and_a_number_of_coordinates():
    with pytest.raises(TypeError, match=r"target.*task_dim|task_dim.*target"):
        Trajectory()


def test_a_target_keeps_a_copy_of_a_pose():
    pose = pin.SE3.Identity()
    target = Target(x=pose, dx=np.zeros(3), ddx=np.zeros(3))
    pose.translation = np.ones(3)
    np.testing.assert_array_equal(target.x.translation, 0.0)


def test_a_target_of_a_pose_with_unequal_rates_is_refused():
    with pytest.raises(ShapeError, match=r"target\.dx and target\.ddx must have one shape, got \(6,\), \(3,\)"):
        Target(x=pin.SE3.Identity(), dx=np.zeros(6), ddx=np.zeros(3))


def test_a_target_of_a_pose_that_is_not_finite_is_refused():
    with pytest.raises(NonFiniteError, match=r"target\.x must be finite"):
        Target(x=pin.SE3(np.eye(3), np.array([0.0, np.nan, 0.0])), dx=np.zeros(6), ddx=np.zeros(6))


def test_a_target_turns_lists_into_arrays():
    target = Target(x=[1, 2], dx=[0, 0], ddx=[0, 0])
    np.testing.assert_array_equal([target.x, target.dx, target.ddx], [[1.0, 2.0], [0.0, 0.0], [0.0, 0.0]])
    assert target.x.dtype == np.float64
    assert target.x.shape == (2,)


@pytest.mark.parametrize("trajectory", [*EVERY_KIND, StraightLine(np.ones(6), 2.0)], ids=repr)
def test_the_arrays_of_a_target_are_read_only(trajectory):
    targets = [Target(START, START, START)]
    if trajectory.task_dim != 6:
        targets.append(trajectory.target(0.3, START))
    if trajectory.task_dim != 2:
        targets.append(trajectory.target(0.3, pin.SE3.Identity()))
    for target in targets:
        for part in (target.x, target.dx, target.ddx):
            if isinstance(part, np.ndarray):
                with pytest.raises(ValueError, match="read-only"):
                    part[0] = 1.0


def test_a_target_keeps_copies_of_arrays():
    given = [np.zeros(2), np.ones(2), np.full(2, 2.0)]
    target = Target(*given)
    for array in given:
        array[:] = 9.0
    np.testing.assert_array_equal([target.x, target.dx, target.ddx], [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])


@pytest.mark.parametrize("dtype", [">f8", "<f4", ">i4", "int64", "uint8"])
@pytest.mark.parametrize("step", [1, 2])
def test_a_target_of_any_real_numbers_is_one_of_floats(dtype, step):
    vector = np.array([1, 7, 2, 7], dtype=dtype)[::step]
    target = Target(vector, vector, vector)
    for part in (target.x, target.dx, target.ddx):
        assert part.dtype == np.dtype(np.float64)
        assert part.dtype.isnative
        np.testing.assert_array_equal(part, vector)


def test_a_target_that_no_arm_could_follow_is_refused_with_its_time():
    line = StraightLine([1e45, 0.0], duration=1e-5)
    with pytest.raises(NonFiniteError, match=r"the target at t = 2\.5e-06 s must be"):
        line.target(2.5e-6, START)


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
def test_an_array_as_start_that_is_not_finite_is_to_blame_itself(trajectory):
    with pytest.raises(NonFiniteError, match="start must be finite"):
        trajectory.target(0.3, np.array([np.nan, 0.0]), TASKS[0])


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
def test_targets_share_nothing_with_one_another_nor_with_the_start(trajectory):
    start = START.copy()
    one, other = (trajectory.target(0.3, start, TASKS[0]) for _ in range(2))
    start[:] = 9.0
    for name in ("x", "dx", "ddx"):
        assert not np.shares_memory(getattr(one, name), getattr(other, name))
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
    assert not np.shares_memory(one.x, start)


def test_a_target_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        A.target(0.0, START).x = START


NO_VECTORS = {
    "complex": np.zeros(2, dtype=complex),
    "boolean": np.array([True, False]),
    "booleans in a list": [1.0, True],
    "masked": np.ma.masked_array([0.0, 0.0], [False, True]),
    "objects": np.array([0.0, 0.0], dtype=object),
    "strings": np.array(["0", "1"]),
    "a huge integer": [10**400, 0],
    "a column": np.zeros((2, 1)),
    "a mapping": {"x": 1.0},
    "nothing": None,
}


@pytest.mark.parametrize("part", ["x", "dx", "ddx"])
@pytest.mark.parametrize("value", NO_VECTORS.values(), ids=NO_VECTORS)
def test_what_is_no_vector_of_real_numbers_is_no_target(part, value):
    with pytest.raises(ShapeError, match=rf"target\.{part} must (be a vector of numbers|have shape \(any,\)), got"):
        Target(**{**dict.fromkeys(("x", "dx", "ddx"), START), part: value})


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
@pytest.mark.parametrize("value", NO_VECTORS.values(), ids=NO_VECTORS)
def test_what_is_no_vector_of_real_numbers_is_no_start(trajectory, value):
    for task in (None, TASKS[0]):
        with pytest.raises(ShapeError, match="start must"):
            trajectory.target(0.3, value, task)


@pytest.mark.parametrize("trajectory", EVERY_KIND, ids=repr)
@pytest.mark.parametrize("dtype", [">f8", "<f4", ">i4", "int8"])
def test_a_start_of_any_real_numbers_gives_the_same_target(trajectory, dtype):
    start = np.array([3, 5, -2, 5], dtype=dtype)[::2]
    expected = trajectory.target(0.3, np.array([3.0, -2.0]), TASKS[0])
    target = trajectory.target(0.3, start, TASKS[0])
    for name in ("x", "dx", "ddx"):
        assert getattr(target, name).tobytes() == getattr(expected, name).tobytes()


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
