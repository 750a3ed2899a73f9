"""Self-motions: followed for one redundant degree of freedom, sampled for several."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aspect_control import Arm, aspects
from aspect_control.exceptions import ParameterError, RankLossError, ShapeError, UnreachableError
from aspect_control.redundancy import null_vector
from example_arms import example_arm, random_posture
from oracles.planar_reference import minors as planar_minors
from oracles.planar_reference import position, postures

READY = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
PAPER = np.deg2rad([-50.0, 140.0, -140.0])


def apart(one, other):
    """The largest difference of angles modulo a turn."""
    return np.abs(np.remainder(one - other + np.pi, 2.0 * np.pi) - np.pi).max(axis=-1)


@pytest.fixture(scope="module")
def paper_curve(planar):
    return aspects.self_motion(planar, PAPER)


@pytest.fixture(scope="module")
def panda_curve():
    return aspects.self_motion(example_arm("panda", "pose"), READY)


@pytest.fixture(scope="module")
def continuous_curve():
    """Two joints that turn without end, and the torso held."""
    arm = Arm.from_example("pr2", frame="r_gripper_tool_frame", task="pose", locked={"torso_lift_joint": 0.1})
    return aspects.self_motion(arm, arm.configuration([-0.3, 0.4, -0.5, -1.2, -0.5, -0.8, 0.3]))


@pytest.fixture(scope="module")
def xarm_curve():
    return aspects.self_motion(example_arm("xarm7", "pose"), [0.3, -0.3, 0.2, 1.2, 0.3, 0.8, 0.5])


@pytest.fixture(params=["paper_curve", "panda_curve", "continuous_curve", "xarm_curve"])
def curve(request):
    return request.getfixturevalue(request.param)


# The null vector


@given(st.integers(0, 2**32 - 1))
def test_null_vector_is_the_vector_of_minors_over_the_manipulability(seed):
    J = np.random.default_rng(seed).normal(size=(2, 3))
    delta = [np.linalg.det(J[:, [1, 2]]), np.linalg.det(J[:, [2, 0]]), np.linalg.det(J[:, [0, 1]])]
    expected = np.array(delta) / np.sqrt(np.linalg.det(J @ J.T))
    np.testing.assert_allclose(null_vector(J), expected, atol=1e-9)


def test_null_vectors_of_a_stack_are_those_of_its_members():
    arm = example_arm("panda", "pose")
    rng = np.random.default_rng(3)
    J = np.array([arm.jacobian(random_posture(arm, rng)) for _ in range(5)])
    z = null_vector(J)
    assert z.shape == (5, 7)
    np.testing.assert_allclose(z, [null_vector(each) for each in J], atol=1e-14)
    assert np.abs(np.einsum("kij,kj->ki", J, z)).max() < 1e-14
    np.testing.assert_allclose(np.linalg.norm(z, axis=1), 1.0, atol=1e-14)


# The curve


def test_planar_self_motion_is_the_closed_form(paper_curve):
    x = position(PAPER)
    for posture in paper_curve.positions[::7]:
        assert min(apart(posture, each) for each in postures(x, posture[0])) < 1e-6
    for first in np.linspace(-np.pi, np.pi, 100):
        for posture in postures(x, first):
            distance = apart(paper_curve.positions, posture).min()
            assert distance <= paper_curve.length / (len(paper_curve.s) - 1)


def test_task_error_stays_below_a_billionth(curve):
    assert curve.task_error.max() < 1e-9
    x = [curve.arm.coordinates.encode(curve.arm.task_position(q)) for q in (curve.q[0], curve.q[len(curve.q) // 3])]
    np.testing.assert_allclose(x[0], x[1], atol=1e-9)


def test_curve_runs_along_the_null_vector_by_arc_length(curve):
    h = 1e-4
    for s in np.linspace(0.05, curve.s[-1] - 0.05, 12):
        tangent = (curve.at(s + h) - curve.at(s - h)) / (2.0 * h)
        z = null_vector(curve.arm.jacobian(curve.arm.configuration(curve.at(s))))
        np.testing.assert_allclose(tangent, z, atol=1e-6)


def test_closed_curve_comes_back_after_whole_turns(curve):
    assert curve.closed
    assert curve.ends == ("closed", "closed")
    turns = (curve.positions[-1] - curve.positions[0]) / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    np.testing.assert_allclose(curve.at(curve.s[-1] + 0.7) - curve.at(0.7), 2.0 * np.pi * np.round(turns), atol=1e-8)
    assert np.linalg.norm(np.diff(curve.positions, axis=0), axis=1).max() <= 0.0201


def test_aspects_of_the_planar_arm_change_where_the_closed_form_does(paper_curve):
    assert len(paper_curve.crossings) == len(paper_curve.aspects) == 6
    assert [each.minor for each in paper_curve.crossings] == [3, 2, 1, 3, 2, 1]
    for s, minor in paper_curve.crossings:
        before, at, after = (planar_minors(paper_curve.at(s + h))[minor - 1] for h in (-1e-5, 0.0, 1e-5))
        assert abs(at) < 1e-10
        assert before * after < 0.0
    for start, end, signature in paper_curve.aspects:
        for s in np.linspace(start, end, 9)[1:-1]:
            assert tuple(np.sign(planar_minors(paper_curve.at(s))).astype(int)) == signature
    assert paper_curve.aspects[-1].end == paper_curve.aspects[0].start + paper_curve.length


def test_signatures_hold_along_their_stretches(curve):
    for start, end, signature in curve.aspects:
        middle = curve.arm.jacobian(curve.arm.configuration(curve.at(start + 0.37 * (end - start))))
        values = [np.linalg.det(middle[:, columns]) for columns in curve.arm.minor_columns]
        assert tuple(np.sign(values).astype(int)) == signature
    lengths = [each.end - each.start for each in curve.aspects]
    assert sum(lengths) == pytest.approx(curve.length, abs=1e-9)


def test_every_sign_change_between_samples_is_reported(curve):
    changes = np.count_nonzero(np.diff(np.sign(curve.minors[np.abs(curve.minors).min(axis=1) > 1e-12]), axis=0), axis=0)
    reported = np.bincount([each.minor - 1 for each in curve.crossings], minlength=curve.minors.shape[1])
    # A crossing on the seam lies between no two samples.
    on_seam = [each.minor - 1 for each in curve.crossings if each.s < 1e-7]
    reported[on_seam] -= 1
    assert changes.tolist() == reported.tolist()


def test_ready_pose_of_panda_lies_on_a_border_that_its_self_motion_crosses(panda_curve):
    at_start = [each.minor for each in panda_curve.crossings if each.s < 1e-8]
    assert sorted(at_start) == [3, 5, 7]
    assert sorted(panda_curve.arm.minors_on_border(READY) + 1) == [3, 5, 7]
    first, last = panda_curve.aspects[0], panda_curve.aspects[-1]
    assert [i + 1 for i in range(7) if first.signature[i] != last.signature[i]] == [3, 5, 7]
    shares = np.abs(panda_curve.minors / panda_curve.arm.minor_scales).min(axis=1)
    assert shares[0] < 1e-12
    assert shares[10] > 0.05  # 0.2 rad further on


def test_joint_limits_are_reported_where_they_are_met(panda_curve):
    lower, upper = panda_curve.arm.position_limits
    assert [each.leaving for each in panda_curve.limit_crossings] == [True, True, True, False, False, False]
    for s, joint, leaving in panda_curve.limit_crossings:
        i = panda_curve.arm.joint_names.index(joint)
        angle = panda_curve.at(s)[i]
        turned = [angle + turn for turn in (-2 * np.pi, 0.0, 2 * np.pi)]
        assert min(min(abs(each - lower[i]), abs(each - upper[i])) for each in turned) < 1e-9
        later = panda_curve.at(s + 1e-4)[i]
        assert leaving != any(lower[i] <= later + turn <= upper[i] for turn in (-2 * np.pi, 0.0, 2 * np.pi))
    assert panda_curve.within_limits[0]
    assert not panda_curve.within_limits[len(panda_curve.s) // 2]


def test_self_motion_ends_where_it_branches(planar):
    """The arm as a rhombus folds flat: the links 1 and 3 stay parallel, so that θ = (φ, −φ, φ + π), 0 < φ < π."""
    curve = aspects.self_motion(planar, [0.5, -0.5, 0.5 + np.pi])
    assert not curve.closed
    assert curve.ends == ("rank loss", "rank loss")
    assert sorted(np.abs(curve.s[[0, -1]])) == pytest.approx(np.sqrt(3.0) * np.array([0.5, np.pi - 0.5]), abs=1e-4)
    phi = curve.positions[:, 0]
    np.testing.assert_allclose(curve.positions, np.column_stack([phi, -phi, phi + np.pi]), atol=1e-9)
    assert curve.task_error.max() < 1e-9


def test_longest_length_ends_a_curve_in_both_directions(planar, paper_curve):
    curve = aspects.self_motion(planar, PAPER, longest=3.0)
    assert (curve.ends, curve.s[0], curve.s[-1]) == (("length", "length"), -3.0, 3.0)
    np.testing.assert_allclose(curve.at(2.0), paper_curve.at(2.0), atol=1e-8)
    assert apart(curve.at(-2.0), paper_curve.at(-2.0)) < 1e-8


def test_posture_is_corrected_to_another_task_value(planar):
    x = position(PAPER) * 0.98
    curve = aspects.self_motion(planar, PAPER, x=x, longest=0.5)
    np.testing.assert_allclose(position(curve.positions[-1]), x, atol=1e-11)


@pytest.mark.parametrize(
    ("arm", "q", "options", "error", "words"),
    [
        (("panda", "xyz"), READY, {}, ParameterError, "4 redundant degrees of freedom of 7 joints: sample it"),
        (("panda", "pose"), [0, 2, 0, -2, 0, 2, 0], {}, ParameterError, "'panda_joint2' at 2 is outside its limits"),
        (("planar3r", "xy"), [0, 0, 0], {}, RankLossError, "has lost rank at q"),
        (("planar3r", "xy"), [0, 0], {}, ShapeError, r"must have shape \(3,\)"),
        (("planar3r", "xy"), PAPER, {"spacing": 0}, ParameterError, "spacing must be a finite number above 0"),
        (("planar3r", "xy"), PAPER, {"x": [4.0, 0.0]}, ParameterError, "cannot be corrected to the task value"),
        (
            ("kinova", ("x", "y", "z", "rx", "ry")),
            None,
            {},
            ParameterError,
            "take all three rotations into the task, or none",
        ),
    ],
)
def test_bad_input_of_a_self_motion(arm, q, options, error, words):
    arm = example_arm(*arm)
    q = arm.configuration([0.3, 2.6, 1.2, 0.5, 1.0, 0.3]) if q is None else q
    with pytest.raises(error, match=words):
        aspects.self_motion(arm, q, **options)


# The sample


@pytest.mark.parametrize(
    ("robot", "task", "positions"),
    [("panda", "xyz", READY), ("ur5", "xyz", [0.3, -0.9, 1.2, 1.2, 0.3, 0.8]), ("kinova", "xyz", None)],
)
def test_sampled_postures_have_the_task_value_inside_the_limits(robot, task, positions):
    arm = example_arm(robot, task)
    positions = [0.3, 2.6, 1.2, 0.5, 1.0, 0.3] if positions is None else positions
    x = arm.task_position(arm.configuration(positions))
    sample = aspects.sample_self_motion(arm, x, count=60, seed=5)
    assert sample.positions.shape == (60, arm.nv)
    assert sample.task_error.max() < 1e-9
    for posture in sample.positions:
        arm.require_within_limits(arm.configuration(posture))
        assert np.linalg.norm(arm.task_position(arm.configuration(posture)) - x) < 1e-9
    assert sum(sample.signatures.values()) == 60
    assert len(sample.signatures) > 5
    # Spread over the self-motion, not gathered about one posture.
    assert np.ptp(sample.positions, axis=0).min() > 1.0


def test_same_seed_same_sample(seven):
    x = seven.task_position(np.full(7, 0.4))
    one, other, third = (aspects.sample_self_motion(seven, x, count=20, seed=seed) for seed in (1, 1, 2))
    assert one.positions.tobytes() == other.positions.tobytes()
    assert one.positions.tobytes() != third.positions.tobytes()


def test_task_value_out_of_reach_is_an_error_with_the_distance_reached(planar):
    with pytest.raises(UnreachableError, match=r"\[2.5, 2.5\] is out of reach of 'planar3r'.*leaves 0.536 m;.*3 m"):
        aspects.sample_self_motion(planar, [2.5, 2.5])
    arm = example_arm("panda", "pose")
    with pytest.raises(UnreachableError, match=r"leaves [\d.]+ m and [\d.e-]+ rad"):
        aspects.sample_self_motion(arm, pin.SE3(np.eye(3), np.array([0.0, 0.0, -2.0])))
    with pytest.raises(ParameterError, match="count must be a whole number of at least 1, got 0"):
        aspects.sample_self_motion(planar, [1.0, 1.0], count=0)
