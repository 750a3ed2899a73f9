"""What a guard recognises, and the words in which it says it."""

import numpy as np
import pytest
from test_guard import DT, HOME, Told, at_home, driven

import aspect_control as ac
from aspect_control import controllers
from aspect_control.guard import AS_TOLD
from aspect_control.guard.clock import Clock
from aspect_control.guard.divergence import Growth
from example_arms import example_arm

REST = np.zeros(7)


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda", "xyz")


def said(guard, q, v, target, *, reset=True):
    """What a guard says of a first sample."""
    if reset:
        guard.reset(q, v, DT)
    tau = guard.torque(q, v, target)
    assert (np.abs(tau) <= guard.limits.torque).all()
    assert guard.status.state == "stopping"
    return guard.status.reason


# Before the first torque


def test_degrees_are_recognised_and_read_as_what_they_are(panda):
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    assert said(guard, np.rad2deg(HOME), REST, at_home(panda)) == (
        "q is in degrees, angles are in radians: joint 'panda_joint1' starts at 17.19, outside its limits "
        "[-2.897, 2.897]"
    )
    assert guard.reading == "degrees"
    np.testing.assert_allclose(guard.memory.tau, panda.state(HOME, REST).nle, atol=1e-9)


def test_degrees_inside_the_limits_are_recognised_by_the_target(planar):
    q = np.deg2rad([-5.0, 4.0, -3.0])
    target = ac.Target(planar.task_position(q), np.zeros(2), np.zeros(2))
    guard = ac.Guard(controllers.create("pseudoinverse", planar))
    reason = said(guard, np.rad2deg(q), np.zeros(3), target)
    assert reason.startswith("q is in degrees, angles are in radians: 'tool' is ")


@pytest.mark.parametrize("task", ["xyz", "pose"])
def test_millimetres_are_recognised(task):
    arm = example_arm("panda", task)
    x, m = arm.task_position(HOME), arm.task_dim
    if task == "pose":
        x.translation = 1000.0 * x.translation
    else:
        x = 1000.0 * x
    guard = ac.Guard(controllers.create("pseudoinverse", arm))
    reason = said(guard, HOME, REST, ac.Target(x, np.zeros(m), np.zeros(m)))
    assert reason.startswith(
        "the target is in millimetres, positions are in metres: the target is out of reach: it is "
    )


def test_q_and_v_that_are_swapped_are_recognised_and_swapped_back(panda):
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    reason = said(guard, REST, HOME, at_home(panda))
    assert reason.startswith("q and v are swapped: v is a posture at the target, and ")
    np.testing.assert_allclose(guard.memory.tau, panda.state(HOME, REST).nle, atol=1e-9)


def test_a_start_beyond_a_limit_is_told(panda):
    q = HOME + np.eye(7)[3] * 2.5
    target = ac.Target(panda.task_position(q), np.zeros(3), np.zeros(3))
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    assert said(guard, q, REST, target) == "joint 'panda_joint4' starts at 0.5, outside its limits [-3.072, -0.0698]"
    assert guard.reading == AS_TOLD


@pytest.mark.parametrize(("speed", "hint"), [(3.0, ""), (60.0, "; is v in degrees a second?")])
def test_a_start_that_is_too_fast_is_told(panda, speed, hint):
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    reason = said(guard, HOME, speed * np.eye(7)[1], at_home(panda))
    assert reason == f"joint 'panda_joint2' starts at {speed:g} rad/s, its speed limit is 2.175{hint}"


def test_a_posture_of_another_target_is_told(panda):
    x = panda.task_position(HOME) - [0.2, 0.0, 0.0]
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    assert said(guard, HOME, REST, ac.Target(x, np.zeros(3), np.zeros(3))) == (
        "the posture does not belong to the target: 'panda_hand_tcp' is 0.2 m from its target, 0.1 m are allowed"
    )


def test_a_target_out_of_reach_and_one_that_is_too_fast_are_told(panda):
    x = panda.task_position(HOME)
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    assert said(guard, HOME, REST, ac.Target(2.0 * x, np.zeros(3), np.zeros(3))).startswith(
        "the target is out of reach"
    )
    assert "is it in millimetres?" in said(guard, HOME, REST, ac.Target(x, [100.0, 0.0, 0.0], np.zeros(3)))


def test_a_law_that_was_not_reset_is_told(panda):
    guard = ac.Guard(controllers.create("jmdc", panda))
    assert guard.status.state == "stopped"
    reason = said(guard, HOME, REST, at_home(panda), reset=False)
    assert reason == "the guard was not reset: call reset(q, v, dt) before the first torque(q, v, target)"
    guard = ac.Guard(controllers.create("jmdc", panda))
    guard.reset(HOME + 0.2, REST, DT)
    reason = said(guard, HOME, REST, at_home(panda), reset=False)
    assert reason.startswith("the law was not reset here: a joint is 0.2 rad from where ")


def test_a_guard_that_was_never_reset_and_sees_nothing_still_answers(panda):
    guard = ac.Guard(controllers.create("jmdc", panda))
    for bad in (None, np.full(7, np.nan), "home"):
        tau = guard.torque(bad, bad, bad)
        assert np.isfinite(tau).all()
        assert (np.abs(tau) <= panda.torque_limit).all()
    assert guard.status.state in ("stopping", "stopped")


# Later


MOVING = ac.StraightLine([0.05, 0.1, 0.05], 0.4)


def changed(at, change):
    """What `driven` makes of a sample: itself before `at`, changed from then on."""
    return lambda i, q, v, target: change(i, q, v, target) if i >= at else (q, v, target)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda i, q, v, t: (q * np.nan, v, t), "the sample cannot be used: q must be finite"),
        (lambda i, q, v, t: (q, v[:3], t), "the sample cannot be used: v must have shape"),
        (lambda i, q, v, t: (q + 0.5 * (i < 203), v, t), "the measured position leaps by "),
        (lambda i, q, v, t: (q, v, None), "target must be a Target"),
        (lambda i, q, v, t: (q, v, ac.Target(np.zeros(2), np.zeros(2), np.zeros(2))), "the target for the task"),
        (lambda i, q, v, t: (q, v, ac.Target(t.x + 0.05, t.dx, t.ddx)), "the target jumps by 0.08"),
    ],
)
def test_wrong_input_in_the_middle_of_a_motion_ends_in_a_stop_within_the_limits(panda, change, words):
    guard = ac.Guard(controllers.create("damped-null-space", panda), torque_rate=2000.0)
    q, v, tau = driven(guard, 500, changed(200, change), MOVING)
    assert guard.status.reason.startswith(words)
    assert np.abs(v[200]).max() > 0.3
    assert np.abs(v[-1]).max() < 0.1
    assert np.abs(np.diff(tau, axis=0)).max() <= 2000.0 * DT * (1 + 1e-9)
    assert np.abs(q[-1] - q[200]).max() < 0.3


def test_the_arm_is_braked_by_its_model_while_it_is_not_seen_and_seen_again_afterwards(panda):
    def blind(i, q, v, target):
        return (q if i > 260 else None), v, target

    guard = ac.Guard(controllers.create("damped-null-space", panda))
    q, v, _ = driven(guard, 700, changed(200, blind), MOVING)
    np.testing.assert_allclose(q[-1], guard.memory.state.q, atol=1e-9)
    assert np.abs(v[260]).max() < 0.7 * np.abs(v[200]).max()
    assert np.abs(v[-1]).max() < 0.02


def test_a_sample_that_comes_twice_is_nothing_and_one_that_comes_again_and_again_is_told(panda):
    kept = []

    for count, ends in ((2, "running"), (30, "stopped")):

        def held(i, q, v, target, count=count):
            kept.append((q, v))
            return (*(kept[0] if i < 200 + count else (q, v)), target)

        kept.clear()
        guard = ac.Guard(controllers.create("damped-null-space", panda))
        driven(guard, 900 if ends == "stopped" else 260, changed(200, held), MOVING)
        assert guard.status.state == ends
    assert guard.status.reason == "the same sample has come 6 times while the arm moves"


@pytest.mark.parametrize(
    ("pace", "words"), [(3.0, "samples are lost, or the loop is slower"), (0.3, "or the loop is faster than the dt")]
)
def test_a_clock_that_runs_away_is_told(panda, pace, words):
    def elsewhere(i, q, v, target):
        return q, v / pace, target

    guard = ac.Guard(controllers.create("damped-null-space", panda), tracking=None)
    driven(guard, 400, changed(200, elsewhere), ac.StraightLine([0.03, 0.06, 0.03], 0.4))
    assert guard.status.reason.startswith("the clock runs away: the joints move ")
    assert words in guard.status.reason


def test_a_clock_that_is_a_little_out_is_not_told(panda):
    clock = Clock()
    for i in range(20):
        state = panda.state(HOME + 1.2 * 0.025 * i * np.ones(7) * 0.4, 0.4 * np.ones(7))
        clock, reason = clock.after(panda, state, 0.025)
        assert reason == ""


def test_a_self_motion_that_grows_by_a_factor_is_told_and_one_that_grows_with_the_task_is_not():
    M, Vt, task = np.eye(3), np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([0.5, 0.0, 0.0])
    growing, steady, reasons = Growth(), Growth(), []
    for i in range(12):
        growing, reason = growing.after(np.array([0.5, 0.0, 0.1 * 1.5**i]), M, Vt, task)
        reasons.append(reason)
        steady, calm = steady.after(np.array([2.0, 0.0, 0.2 * i]), M, Vt, 3.0 * task)
        assert calm == ""
    first = next(i for i, reason in enumerate(reasons) if reason)
    assert 3.0 < 0.1 * 1.5**first < 5.0
    assert reasons[first].startswith(
        "the motion diverges: the self-motion has grown to 3.84 rad/s and the kinetic energy"
    )


@pytest.mark.parametrize("name", ["null-space-vector", "inertia-weighted"])
def test_a_law_that_builds_up_self_motion_is_stopped_long_before_it_explodes(planar, name):
    """Without limits: by the growth alone."""
    line = ac.StraightLine([1.5, 1.0], duration=2.0, profile="bang-bang")
    guard = ac.Guard(controllers.create(name, planar), torque=None, speed=None, position=None)
    run = ac.simulate(guard, line, q0=np.deg2rad([-50, 140, -140]))
    assert run.status == "stopped"
    assert "the motion diverges" in run.message
    assert np.abs(run.tau).max() < 600.0
    bare = ac.simulate(guard.law, line, q0=np.deg2rad([-50, 140, -140]))
    assert np.abs(bare.tau).max() > 1500.0


@pytest.mark.parametrize("duration", [4.0, 20.0])
def test_an_arm_is_stopped_before_its_target_leads_it_out_of_its_reach(panda, duration):
    guard = ac.Guard(controllers.create("damped-null-space", panda))
    run = ac.simulate(guard, ac.StraightLine([0.4, 0.5, 0.1], duration), q0=HOME, dt=4e-3)
    assert run.status == "stopped"
    words = ("would reach", "losing its rank", "cannot be followed", "could not be stopped")
    assert any(each in run.message for each in words)
    assert (np.abs(run.v) <= 1.05 * panda.velocity_limit).all()
    singular = np.linalg.svd(panda.jacobian(run.q[-1]), compute_uv=False)
    assert singular[-1] > 0.005 * singular[0]


def test_a_joint_that_its_motor_can_hardly_carry_is_told(panda):
    guard = ac.Guard(Told(panda, lambda state: state.nle), torque=[87.0, 87.0, 87.0, 22.0, 12.0, 12.0, 12.0])
    reason = said(guard, HOME, REST, at_home(panda))
    assert reason.startswith("joint 'panda_joint4' has hardly any torque left to be braked with: 21.")
