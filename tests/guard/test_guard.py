"""A guard around every law: what it passes on, what it refuses to pass on, and what it says."""

import copy
import json
import pickle

import numpy as np
import pytest

import aspect_control as ac
from aspect_control import controllers
from aspect_control.controllers import Controller
from aspect_control.exceptions import AspectControlError, ParameterError, ShapeError
from aspect_control.plants import RigidBodyPlant
from aspect_control.resources import scenario_paths
from aspect_control.scenario import load_scenario
from aspect_control.simulation import RungeKutta4
from example_arms import example_arm

LAWS = controllers.available()
DT = 1e-3
HOME = np.array([0.3, -0.5, 0.2, -2.0, 0.3, 1.8, 0.5])
NO_LIMITS = {"torque": None, "speed": None, "position": None, "tracking": None, "jump": None, "distance": 1e6}

every_law = pytest.mark.parametrize("name", LAWS)


class Told(Controller):
    """A law that does what it is told: `say` is called with the state."""

    name = "told"

    def __init__(self, arm, say):
        super().__init__(arm, 1, 0.0, 0.0)
        self.say = say

    def command(self, state, target):
        return self.say(state)


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda", "xyz")


def at_home(arm):
    return ac.Target(arm.task_position(HOME), np.zeros(3), np.zeros(3))


def driven(guard, samples, change=lambda i, q, v, target: (q, v, target), line=None, start=HOME, dt=DT):
    """Drive an arm with a guard, and return configurations, velocities and torques."""
    arm = guard.arm
    plant, method = RigidBodyPlant(arm), RungeKutta4()
    q, v = arm.configuration(start), np.zeros(arm.nv)
    x, rows = arm.task_position(q), []
    line = line or ac.StraightLine([0.05, 0.1, 0.05], samples * dt)
    guard.reset(q, v, dt)
    for i in range(samples):
        tau = guard.torque(*change(i, q, v, line.target(i * dt, x, arm.coordinates)))
        rows.append((q, v, tau))
        q, v = method.step(plant, q, v, tau, dt)
    return tuple(np.array(each) for each in zip(*rows, strict=True))


# What is passed on


@pytest.mark.parametrize("scenario", scenario_paths())
def test_the_laws_of_a_scenario_give_the_same_torques_to_the_last_bit_while_no_limit_holds(scenario):
    setup = load_scenario(scenario, ["simulation.dt=5e-3"]).build()
    common = {"q0": setup.q0, "v0": setup.v0, "dt": setup.dt, "plant": setup.plant, "integrator": setup.integrator}
    for label, law in setup.laws.items():
        run = ac.simulate(copy.deepcopy(law), setup.trajectory, **common)
        for limits in ({}, {**NO_LIMITS, "torque": 1e6, "torque_rate": 1e9, "acceleration": 1e6}):
            guard, states = ac.Guard(copy.deepcopy(law), **limits), list[str]()
            guarded = ac.simulate(
                guard, setup.trajectory, watch=lambda _, g=guard, s=states: s.append(g.status.state), **common
            )
            count = min(sum(state == "running" for state in states), len(run.t))
            np.testing.assert_array_equal(guarded.tau[:count], run.tau[:count], err_msg=f"{label} {limits}")
            np.testing.assert_array_equal(guarded.q[:count], run.q[:count])
            if limits and label in ("pseudoinverse", "jmdc"):
                assert guard.status == ac.guard.GuardStatus("running")
                assert count == len(run.t) == len(guarded.t)


@every_law
def test_a_guard_is_the_law_on_a_calm_motion_of_panda(panda, name):
    guard, law = ac.Guard(controllers.create(name, panda), **NO_LIMITS), controllers.create(name, panda)
    line = ac.StraightLine([0.005, 0.01, 0.005], 0.05)
    one, other = (ac.simulate(each, line, q0=HOME, dt=DT) for each in (guard, law))
    np.testing.assert_array_equal(one.tau, other.tau)
    assert guard.status.state == "running"
    assert one.info.controller == name
    assert one.info.parameters == {**law.parameters, "guard": guard.limits.parameters}
    json.dumps(one.info.parameters)


# Limits


@pytest.mark.parametrize("kind", ["shouting", "thrashing", "not a number", "raising", "wrong shape"])
@pytest.mark.parametrize("rate", [None, 1000.0])
def test_torque_and_rate_are_kept_whatever_the_law_says(panda, kind, rate):
    rng = np.random.default_rng(3)

    def say(state):
        if kind == "raising" and rng.random() < 0.1:
            raise ZeroDivisionError("mine")
        if kind == "not a number" and rng.random() < 0.1:
            return np.full(7, np.nan)
        if kind == "wrong shape" and rng.random() < 0.1:
            return np.zeros(3)
        return state.nle + {"thrashing": 1e4 * rng.normal(size=7), "shouting": np.full(7, 1e9)}.get(kind, 0.01)

    guard = ac.Guard(Told(panda, say), torque_rate=rate)
    _, _, tau = driven(guard, 150, line=ac.Hold(1.0))
    assert (np.abs(tau) <= panda.torque_limit).all()
    if rate is not None:
        gravity = panda.state(HOME, np.zeros(7)).nle
        steps = np.abs(np.diff(np.vstack([gravity, tau]), axis=0))
        assert steps.max() <= rate * DT * (1.0 + 1e-9)
    assert guard.status.state in ("stopping", "stopped")
    words = {"raising": "raised ZeroDivisionError: mine", "wrong shape": "must return shape", "not a number": "finite"}
    assert words.get(kind, "limit") in guard.status.reason


def test_a_torque_limit_that_holds_is_told_and_the_law_goes_on(panda):
    told = []
    guard = ac.Guard(
        Told(panda, lambda state: state.nle + np.array([3.0, 0, 0, 0, 0, 0, 0])),
        torque=[2.0] + [87.0] * 6,
        on_change=told.append,
    )
    _, _, tau = driven(guard, 20, line=ac.Hold(1.0))
    assert guard.status == told[0]
    assert [status.state for status in told] == ["limiting"]
    assert guard.status.reason == "torque limit of joint 'panda_joint1': 3 N m asked, 2 N m allowed"
    np.testing.assert_array_equal(tau[:, 0], 2.0)


def test_a_rate_limit_holds_from_the_first_sample_on(panda):
    step = np.array([0.0, 0.5, 0, 0, 0, 0, 0])
    guard = ac.Guard(Told(panda, lambda state: state.nle + 40 * step), torque_rate=500.0)
    gravity = panda.state(HOME, np.zeros(7)).nle
    guard.reset(HOME, np.zeros(7), DT)
    tau = guard.torque(HOME, np.zeros(7), at_home(panda))
    np.testing.assert_allclose(tau, gravity + step, rtol=0.0, atol=1e-12)
    assert guard.status.reason.startswith("torque rate limit of joint 'panda_joint2': 2e+04 N m/s asked, 500 N m/s")


def test_an_acceleration_limit_scales_the_joint_acceleration_back(panda):
    wanted = np.array([8.0, 0.0, -4.0, 2.0, 0.0, 0.0, 0.0])
    guard = ac.Guard(Told(panda, lambda state: state.nle + state.M @ wanted), acceleration=2.0)
    guard.reset(HOME, np.zeros(7), DT)
    tau = guard.torque(HOME, np.zeros(7), at_home(panda))
    state = panda.state(HOME, np.zeros(7))
    np.testing.assert_allclose(np.linalg.solve(state.M, tau - state.nle), wanted / 4.0, rtol=1e-9, atol=1e-9)
    assert guard.status.reason == "acceleration limit of joint 'panda_joint1': 8 rad/s² asked, 2 rad/s² allowed"


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"torque": 0.0}, ParameterError),
        ({"torque": "file"}, ParameterError),
        ({"torque_rate": -1.0}, ParameterError),
        ({"torque_rate": "urdf"}, ParameterError),
        ({"speed": [1.0, 2.0]}, ShapeError),
        ({"position": 3.0}, ShapeError),
        ({"position": (1.0, -1.0)}, ParameterError),
        ({"acceleration": np.nan}, AspectControlError),
        ({"tracking": 0.0}, ParameterError),
        ({"jump": "far"}, ParameterError),
        ({"distance": -1.0}, ParameterError),
        ({"on_change": 3}, ParameterError),
    ],
)
def test_limits_that_are_none_are_refused(panda, given, error):
    with pytest.raises(error, match=next(iter(given))):
        ac.Guard(controllers.create("pseudoinverse", panda), **given)


def test_what_is_no_law_is_refused(panda):
    with pytest.raises(ParameterError, match="law must be a Controller"):
        ac.Guard(panda)


def test_a_joint_without_end_has_no_position_limits():
    law = controllers.create("pseudoinverse", example_arm("kinova", "xyz"))
    with pytest.raises(ParameterError, match="turns without end"):
        ac.Guard(law, position=(-6.0, 6.0))
    assert np.isinf(ac.Guard(law).limits.upper[0])


# Stages


def test_a_stop_goes_through_its_stages_without_a_bump_and_holds_the_posture(panda):
    told, at = [], 300

    def change(i, q, v, target):
        return q, v, target if i < at else ac.Target(target.x + 0.5, target.dx, target.ddx)

    guard = ac.Guard(controllers.create("damped-null-space", panda), on_change=told.append)
    q, v, tau = driven(guard, 1500, change)
    assert [status.state for status in told] == ["stopping", "stopped"]
    assert all(status.reason == "the target jumps by 0.866 m in one sample" for status in told)
    assert np.abs(np.diff(tau, axis=0)).max() < 1.0
    assert np.abs(v[at]).max() > 0.1
    assert np.abs(v[-1]).max() < 1e-3
    # All joints come to rest together, on a straight line.
    way = q[-1] - q[at]
    np.testing.assert_allclose(way / np.linalg.norm(way), v[at] / np.linalg.norm(v[at]), atol=0.05)
    held = guard.memory.stage.held
    assert np.abs(q[-1] - held).max() < 1e-3
    np.testing.assert_allclose(tau[-1], panda.state(held, np.zeros(7)).nle, atol=0.01)


def test_only_reset_leads_back_to_running(panda):
    guard = ac.Guard(controllers.create("jmdc", panda))
    guard.reset(HOME, np.zeros(7), DT)
    guard.torque(HOME, np.zeros(7), None)
    for _ in range(3):
        guard.torque(HOME, np.zeros(7), at_home(panda))
        assert guard.status.state in ("stopping", "stopped")
        assert guard.status.reason == "target must be a Target(x, dx, ddx), got NoneType"
    assert guard.status.state == "stopped"
    guard.reset(HOME, np.zeros(7), DT)
    twin = controllers.create("jmdc", panda)
    twin.reset(HOME, np.zeros(7), DT)
    np.testing.assert_array_equal(
        guard.torque(HOME, np.zeros(7), at_home(panda)), twin.torque(HOME, np.zeros(7), at_home(panda))
    )
    assert guard.status == ac.guard.GuardStatus("running")


def test_a_posture_that_is_held_comes_back_after_a_push(panda):
    guard = ac.Guard(controllers.create("pseudoinverse", panda))
    plant, method = RigidBodyPlant(panda), RungeKutta4()
    q, v = HOME, np.zeros(7)
    guard.reset(q, v, DT)
    guard.torque(q, v, None)
    for i in range(2200):
        tau = guard.torque(q, v, None)
        q, v = method.step(plant, q, v, tau + (20.0 if 50 < i < 100 else 0.0) * np.eye(7)[1], DT)
        if i == 100:
            assert abs(q[1] - HOME[1]) > 0.01
    assert np.abs(q - HOME).max() < 1e-3


def test_what_a_callback_raises_is_told_and_takes_no_torque_away(panda):
    def fails(status):
        raise RuntimeError("no printer")

    guard = ac.Guard(controllers.create("pseudoinverse", panda), on_change=fails)
    guard.reset(HOME, np.zeros(7), DT)
    assert np.isfinite(guard.torque(HOME, np.zeros(7), None)).all()
    assert guard.status.reason.endswith("got NoneType; on_change raised RuntimeError: no printer")


def test_ctrl_c_in_a_law_leaves_no_trace(panda):
    def interrupted(state):
        raise KeyboardInterrupt

    guard = ac.Guard(Told(panda, interrupted))
    guard.reset(HOME, np.zeros(7), DT)
    before = guard.memory
    with pytest.raises(KeyboardInterrupt):
        guard.torque(HOME, np.zeros(7), at_home(panda))
    assert guard.memory is before


# A law as every other


@every_law
@pytest.mark.parametrize("begun", [0, 30, 80])
def test_a_copy_gives_the_same_torque_to_the_last_bit_also_while_it_brakes(panda, name, begun):
    def sample(i):
        q = HOME + 0.2 * i * DT
        return q, np.full(7, 0.2), at_home(panda) if i < 60 else None

    guard = ac.Guard(controllers.create(name, panda))
    guard.reset(HOME, np.full(7, 0.2), DT)
    for i in range(begun):
        guard.torque(*sample(i))
    twins = pickle.loads(pickle.dumps(guard)), copy.deepcopy(guard)
    for i in range(begun, begun + 40):
        tau = guard.torque(*sample(i))
        for twin in twins:
            np.testing.assert_array_equal(twin.torque(*sample(i)), tau)
    assert all(twin.status == guard.status for twin in twins)
    assert all(twin.parameters == guard.parameters for twin in twins)


def test_a_reset_that_is_refused_leaves_no_trace(panda):
    guard = ac.Guard(controllers.create("jmdc", panda))
    guard.reset(HOME, np.zeros(7), DT)
    before = guard.memory, guard.law.memory
    for bad in ((None, np.zeros(7), DT), (HOME, np.full(7, np.nan), DT), (HOME, np.zeros(7), 0.0)):
        with pytest.raises(AspectControlError):
            guard.reset(*bad)
    assert (guard.memory, guard.law.memory) == before
    with pytest.raises(AttributeError):
        guard.law = None


def test_a_run_ends_as_stopped_when_its_guard_has_stopped_the_arm(panda):
    guard = ac.Guard(controllers.create("null-space-vector", panda), position=None)
    run = ac.simulate(guard, ac.StraightLine([0.1, 0.2, 0.1], 1.0), q0=HOME)
    assert run.status == "stopped"
    assert run.message == f"stopped at t = {run.t[-1]:.6g} s: {guard.status.reason}"
    assert "its speed limit is 2.61 rad/s" in guard.status.reason
    assert np.abs(run.tau / panda.torque_limit).max() <= 1.0
    short = ac.simulate(guard, ac.StraightLine([0.002, 0.004, 0.002], 0.01), q0=HOME)
    assert (short.status, len(short.t)) == ("stopped", 11)
