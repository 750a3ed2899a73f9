"""What an arm can reach of a path: closed forms of planar arms, and real arms by postures drawn at random."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aspect_control import Circle, Hold, StraightLine, Waypoints
from aspect_control.arm.inverse_kinematics import REACHED, PostureSearch
from aspect_control.arm.postures import sampling_range
from aspect_control.exceptions import NonFiniteError, ParameterError, ShapeError
from aspect_control.guard import check_reach, out_of_reach
from aspect_control.scenario import load_scenario
from example_arms import example_arm, planar_arm

TURN = (-2.0 * np.pi, 2.0 * np.pi)
ANNULUS = planar_arm([1.0, 0.3, 0.3], [TURN] * 3)  # reaches from 0.4 to 1.6 m
BENT = planar_arm([1.0, 1.0, 1.0], [TURN, (0.5, 2.5), (0.5, 2.5)])  # reaches 3 m, and inside its limits 1 + 2 cos 0.5
ELBOW_OUT = 1.0 + 2.0 * np.cos(0.5)
PANDA = example_arm("panda", "xyz")
READY = np.array([0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6])

ARMS = {
    "planar3r": "xy",
    "panda": "pose",
    "ur5": "xyz",
    "kinova": "xyz",
    "xarm7": "pose",
    "baxter": "pose",
    "pr2": "pose",
    "talos_arm": "xyz",
}


def radius(arm, q0):
    return np.linalg.norm(arm.task_position(q0))


def posture_at(arm, x):
    """A posture of a planar arm with its tip at a point, by turning the first joint of a search at the same radius."""
    found = PostureSearch(arm).anywhere(np.asarray(x), np.clip([0.3, 0.8, 0.7], *arm.position_limits))
    assert found.reached
    return found.positions


def crossing(start, displacement, circle):
    """The first part of a line at which it crosses a circle about the origin; None if it does not."""
    a, b, c = displacement @ displacement, 2.0 * start @ displacement, start @ start - circle**2
    discriminant = b * b - 4.0 * a * c
    roots = [(-b + sign * np.sqrt(discriminant)) / (2.0 * a) for sign in (-1.0, 1.0)] if discriminant > 0.0 else []
    return min((root for root in roots if 0.0 < root < 1.0), default=None)


def quintic(s):
    """When the quintic profile is at s, as a part of the duration."""
    roots = np.roots([6.0, -15.0, 10.0, 0.0, 0.0, -s])
    return next(root.real for root in roots if abs(root.imag) < 1e-9 and 0.0 <= root.real <= 1.0)


# Closed forms


points = st.tuples(st.floats(0.45, 1.55), st.floats(-np.pi, np.pi), st.floats(0.0, 2.5), st.floats(-np.pi, np.pi))


@settings(max_examples=30)
@given(points)
def test_a_line_leaves_an_annulus_where_it_crosses_one_of_its_circles(point):
    start_radius, start_angle, end_radius, end_angle = point
    start, end = (
        r * np.array([np.cos(angle), np.sin(angle)])
        for r, angle in ((start_radius, start_angle), (end_radius, end_angle))
    )
    line = StraightLine(end - start, duration=2.0, profile="quintic")
    reach = check_reach(ANNULUS, line, posture_at(ANNULUS, start))
    crossings = [crossing(start, end - start, circle) for circle in (0.4, 1.6)]
    s = min((each for each in crossings if each is not None), default=None)
    middle = np.linalg.norm(start + np.linspace(0.0, 1.0, 2001)[:, None] * (end - start), axis=1)
    beyond = max(0.0, 0.4 - middle.min(), middle.max() - 1.6)
    if s is None or beyond < 2e-3:  # what leaves for less than a step of the search may be missed
        assert reach.reachable or beyond > 1e-6
        return
    assert not reach.reachable
    assert reach.s == pytest.approx(s, abs=1e-4)
    assert reach.t == pytest.approx(2.0 * quintic(s), abs=1e-4)
    np.testing.assert_allclose(reach.point, start + s * (end - start), atol=2e-4)
    assert (reach.angle, reach.joint) == (0.0, None)
    end_radius = np.linalg.norm(end)
    assert max(0.4 - end_radius, end_radius - 1.6) - 1e-6 <= reach.distance <= 1.01 * beyond + 1e-6


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize("short", [1e-6, 1e-4, 1e-2])
def test_the_borders_are_found_to_a_micrometre(inward, short):
    """A line that ends a little before the border is reachable, one that ends a little beyond it is not."""
    q0 = posture_at(ANNULUS, [1.0, 0.0])
    border, sign = (0.4, -1.0) if inward else (1.6, 1.0)
    ends = ([border - sign * each, 0.0] for each in (short, -2.0 * short))
    inside, beyond = (StraightLine(end - ANNULUS.task_position(q0), 1.0) for end in ends)
    assert check_reach(ANNULUS, inside, q0).reachable
    reach = check_reach(ANNULUS, beyond, q0)
    assert not reach.reachable
    assert reach.distance == pytest.approx(2.0 * short, rel=1e-2)


def test_a_hole_is_passed_beside_and_not_through():
    q0 = posture_at(ANNULUS, [1.0, 0.0])
    assert not check_reach(ANNULUS, StraightLine([-2.0, 0.0], 1.0), q0).reachable
    assert check_reach(ANNULUS, Waypoints([[-1.0, 1.0], [-2.0, 0.0]], duration=1.0), q0).reachable


@pytest.mark.parametrize("turns", [0.4, 1.0, 7.0])
def test_a_circle_leaves_where_its_farthest_point_would_be(turns):
    """Of radius 0.4 m from (1, 0) on, its points are nearer than 1.6 m up to cos(angle) = ..., whatever the turns."""
    q0 = posture_at(ANNULUS, [1.0, 0.0])
    reach = check_reach(ANNULUS, Circle(0.4, 2.0, turns=turns, profile="quintic"), q0)
    # |(1.4 − 0.4 cos φ, 0.4 sin φ)|² = 1.6²  ⇔  cos φ = (1.4² + 0.4² − 1.6²) / (2 · 1.4 · 0.4)
    angle = np.arccos((1.4**2 + 0.4**2 - 1.6**2) / (2.0 * 1.4 * 0.4))
    assert not reach.reachable
    assert reach.s == pytest.approx(angle / (2.0 * np.pi * turns), rel=1e-2)
    assert reach.t == pytest.approx(2.0 * quintic(angle / (2.0 * np.pi * turns)), abs=1e-5)


# Joint limits


def test_a_path_that_only_joint_limits_keep_out_of_reach_says_which_joint():
    q0 = posture_at(BENT, [2.0, 0.0])
    line = StraightLine([0.9, 0.0], duration=1.0, profile="quintic")
    free, limited = check_reach(BENT, line, q0, joint_limits=False), check_reach(BENT, line, q0)
    assert free.reachable
    assert free.message == "'planar' can reach all of the path"
    assert not limited.reachable
    assert limited.joint in {"joint2", "joint3"}
    assert limited.s == pytest.approx((ELBOW_OUT - 2.0) / 0.9, abs=1e-5)
    assert limited.distance == pytest.approx(2.9 - ELBOW_OUT, rel=1e-3)
    assert f", with joint '{limited.joint}' at its limit; at the worst it is 0.145 m beyond what" in limited.message
    assert limited.message.endswith("inside its joint limits")


def test_what_lies_farther_out_than_any_posture_blames_no_joint():
    arm = planar_arm([1.0, 1.0, 1.0], [TURN, (0.0, 2.5), (-2.5, 2.5)])
    reach = check_reach(arm, StraightLine([2.0, 0.0], duration=1.0), posture_at(arm, [2.0, 0.0]))
    assert reach.s == pytest.approx(0.5, abs=1e-5)
    assert reach.joint is None
    assert (
        reach.message.endswith("at (3, 0); at the worst it is 1 m beyond what 'planar' can reach")
        or "(3, " in reach.message
    )


def test_a_start_beyond_the_limits_is_where_the_path_leaves():
    reach = check_reach(BENT, Hold(1.0), [0.0, 0.0, 0.0])
    assert (reach.reachable, reach.t, reach.s) == (False, 0.0, 0.0)
    assert reach.joint in {"joint2", "joint3"}
    assert reach.distance == pytest.approx(3.0 - ELBOW_OUT, rel=1e-3)


def test_a_prismatic_joint_counts_up_to_its_limits():
    setup = load_scenario("pr2-xyz").build()
    line = StraightLine([0.0, 0.0, 1.0], 1.0)
    limited, free = (check_reach(setup.arm, line, setup.q0, joint_limits=each) for each in (True, False))
    assert limited.joint == "torso_lift_joint"
    assert free.reachable


# Real arms


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("joint_limits", [True, False])
def test_no_point_that_the_arm_reaches_is_found_out_of_reach(name, joint_limits):
    """A thousand postures an arm, half with limits and half without."""
    arm = example_arm(name, ARMS[name])
    search = PostureSearch(arm, joint_limits=joint_limits)
    rng = np.random.default_rng(5)
    low, high = sampling_range(arm, search.box)
    posture = rng.uniform(low, high)
    for _ in range(500):
        x = arm.task_position(arm.configuration(rng.uniform(low, high)))
        found, limited = search.decide(x, posture)
        assert found.reached
        assert not limited
        # What was found is what it says.
        assert (
            np.linalg.norm(arm.coordinates.error(x, arm.task_position(arm.configuration(found.positions)))) <= REACHED
        )
        assert (search.box[0] <= found.positions).all()
        assert (found.positions <= search.box[1]).all()


@pytest.mark.parametrize("name", ["panda", "tiago", "baxter"])
def test_nor_is_one_of_a_posture_with_joints_at_their_limits(name):
    arm = example_arm(name, "pose")
    search, rng = PostureSearch(arm), np.random.default_rng(6)
    low, high = sampling_range(arm)
    posture = rng.uniform(low, high)
    for _ in range(40):
        pick, inner = rng.uniform(size=arm.nv), rng.uniform(low, high)
        positions = np.where(pick < 0.2, low, np.where(pick > 0.8, high, inner))
        assert search.decide(arm.task_position(arm.configuration(positions)), posture)[0].reached


@pytest.mark.parametrize(
    "name",
    [
        "planar3r",
        "panda-xyz",
        "panda-pose",
        "pr2-xyz",
        "kinova-xyz",
        "ur5-xyz",
        "talos-arm-xyz",
        "xarm7-xyz",
        "baxter-xyz",
    ],
)
def test_the_scenarios_stay_in_reach_inside_their_joint_limits(name):
    assert load_scenario(name).build(laws=()).reach().reachable


def test_a_pose_may_be_out_of_reach_by_its_orientation_alone():
    arm = example_arm("panda", "pose")
    almost_straight = [0.0, 0.9, 0.0, -0.2, 0.0, 1.0, 0.8]
    turn = StraightLine([0.0, 0.0, 0.0, 0.0, 2.5, 0.0], 1.0, profile="quintic")
    reach = check_reach(arm, turn, almost_straight)
    assert not reach.reachable
    assert isinstance(reach.point, pin.SE3)
    assert reach.angle > 0.0
    assert f"{reach.angle:.3g} rad beyond what 'panda' can reach" in reach.message
    # The position alone is where the arm is.
    assert check_reach(PANDA, Hold(1.0), almost_straight).reachable


def test_the_same_check_gives_the_same_answer():
    line = StraightLine([0.2, 0.9, 0.3], 1.0)
    one, other = (dataclasses.asdict(check_reach(PANDA, line, READY)) for _ in range(2))
    np.testing.assert_equal(one, other)


# A single target


def test_a_target_out_of_reach_says_by_how_much():
    q = posture_at(ANNULUS, [1.0, 0.0])
    assert out_of_reach(ANNULUS, np.array([0.0, 1.2]), q) is None
    assert out_of_reach(ANNULUS, [0.0, 2.0], q) == "the target (0, 2) is 0.4 m beyond what 'planar' can reach"
    assert out_of_reach(ANNULUS, [0.1, 0.0], q) == "the target (0.1, 0) is 0.3 m beyond what 'planar' can reach"
    assert out_of_reach(BENT, [2.9, 0.0], posture_at(BENT, [2.0, 0.0]), joint_limits=False) is None
    assert "inside its joint limits, with joint 'joint" in out_of_reach(BENT, [2.9, 0.0], posture_at(BENT, [2.0, 0.0]))


# What is refused


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((PANDA, StraightLine([0.1, 0.1], 1.0), READY), ShapeError, "has 2 task coordinates, the arm's task .* has 3"),
        ((PANDA, StraightLine([0.1, 0.1, 0.1], 1.0), READY[:6]), ShapeError, r"q must have shape \(7,\)"),
        ((PANDA, Hold(1.0), READY * np.nan), NonFiniteError, "q must be finite"),
        ((PANDA, "straight-line", READY), ParameterError, "reach is checked of an Arm and a Trajectory, got "),
        (("panda", Hold(1.0), READY), ParameterError, "reach is checked of an Arm and a Trajectory, got "),
        ((ANNULUS, Circle(0.1, 1.0, plane="yz"), [0.1, 0.2, 0.3]), ParameterError, "needs the task coordinates"),
    ],
)
def test_what_is_no_path_of_the_arm_is_refused(arguments, error, words):
    with pytest.raises(error, match=words):
        check_reach(*arguments)
