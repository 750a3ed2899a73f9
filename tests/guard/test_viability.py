"""After a guard has taken over, no position bound is broken, from any state in which it let a law begin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import aspect_control as ac
from aspect_control.controllers import Controller
from aspect_control.guard.viability import Viability
from aspect_control.plants import RigidBodyPlant
from aspect_control.simulation import RungeKutta4
from example_arms import example_arm


class Pushing(Controller):
    """A law that pushes every joint to one side, as hard as it may."""

    name = "pushing"

    def __init__(self, arm, torque, acceleration):
        super().__init__(arm, 1, 0.0, 0.0)
        self.torque_part, self.acceleration = torque, acceleration

    def command(self, state, target):
        return state.nle + self.torque_part + state.M @ self.acceleration


ARMS = {
    "planar": ac.Arm.from_example("planar3r", frame="tool", task="xy", gravity=(0.0, 0.0, 0.0)),
    "hanging": ac.Arm.from_example("planar3r", frame="tool", task="xy", gravity=(0.0, -9.81, 0.0)),
    "panda": example_arm("panda", "xyz"),
}
TORQUE = {"planar": np.full(3, 60.0), "hanging": np.full(3, 700.0), "panda": ARMS["panda"].torque_limit}


def cases(name):
    n = ARMS[name].nv
    parts = st.lists(st.floats(-1.0, 1.0), min_size=n, max_size=n).map(np.array)
    return st.tuples(
        st.sampled_from([0.001, 0.002, 0.005]),
        st.sampled_from([None, 0.005, 0.02, 0.1]),
        parts,
        parts,
        parts,
        st.sampled_from([0.0, 0.3, 3.0]),
        st.sampled_from([0.0, 3.0, 20.0]),
    )


@pytest.mark.parametrize("name", ARMS)
@settings(max_examples=15)
@given(data=st.data())
def test_no_position_bound_is_broken(name, data):
    dt, rise, posture, motion, side, push, acceleration = data.draw(cases(name))
    arm, torque = ARMS[name], TORQUE[name]
    lower, upper = np.clip(arm.position_limits, -2.0, 2.0)
    guard = ac.Guard(
        Pushing(arm, push * torque * side, acceleration * side),
        torque=torque,
        torque_rate=None if rise is None else torque / rise,
        speed=6.0,
        position=(lower, upper),
        distance=1e3,
    )
    q, v = (lower + upper) / 2.0 + 0.49 * (upper - lower) * posture, motion
    target = ac.Target(arm.task_position(q), np.zeros(arm.task_dim), np.zeros(arm.task_dim))
    plant, method = RigidBodyPlant(arm), RungeKutta4()
    guard.reset(q, v, dt)
    last = np.clip(arm.state(q, np.zeros(arm.nv)).nle, -torque, torque)
    for i in range(int(0.4 / dt)):
        tau = guard.torque(q, v, target)
        if i == 0 and guard.brakes:
            return  # not a state in which it lets a law begin
        assert (np.abs(tau) <= torque).all()
        assert rise is None or (np.abs(tau - last) <= torque / rise * dt * (1.0 + 1e-9)).all()
        q, v = method.step(plant, q, v, tau, dt)
        last = tau
        assert (q >= lower - 1e-9).all()
        assert (q <= upper + 1e-9).all()
        if guard.status.state == "stopped" and np.abs(v).max() < 0.01:
            return


def test_a_guard_lets_a_law_begin_nearly_everywhere_at_rest():
    """A bound that were never let come near would break no limit either."""
    arm = ARMS["panda"]
    lower, upper = arm.position_limits
    rng, begun = np.random.default_rng(0), 0
    for _ in range(60):
        q = rng.uniform(lower + 0.05, upper - 0.05)
        guard = ac.Guard(Pushing(arm, np.zeros(7), np.ones(7)))
        guard.reset(q, np.zeros(7), 1e-3)
        guard.torque(q, np.zeros(7), ac.Target(arm.task_position(q), np.zeros(3), np.zeros(3)))
        begun += not guard.brakes
    # Elsewhere the arm is stretched out.
    assert begun >= 55


def test_an_arm_may_come_near_a_limit_slowly_and_may_leave_it():
    arm = ARMS["planar"]
    guard = ac.Guard(Pushing(arm, np.zeros(3), np.zeros(3)), position=(-1.0, 1.0))
    state = arm.state([0.2, 0.97, 0.2], [0.0, 0.1, 0.0])
    assert guard._viability.plan(state, state.nle, 1e-3).reason == ""
    fast = arm.state([0.2, 0.97, 0.2], [0.0, 0.4, 0.0])
    words = "joint 'joint2' at 0.97 rad could not be stopped before 1.01"
    assert guard._viability.plan(fast, fast.nle, 1e-3).reason.startswith(words)
    leaving = arm.state([0.2, 0.999, 0.2], [0.0, -1.0, 0.0])
    assert guard._viability.plan(leaving, leaving.nle, 1e-3).reason == ""


def test_the_limit_of_the_rate_makes_an_arm_stop_earlier():
    arm = ARMS["planar"]
    state = arm.state([0.2, 0.2, 0.5], [0.0, 0.0, 2.0])
    push = state.nle + state.M @ np.array([0.0, 0.0, 2.0])
    ends = {}
    for rate in (None, 1000.0, 100.0):
        guard = ac.Guard(Pushing(arm, np.zeros(3), np.zeros(3)), torque_rate=rate, speed=20.0, position=(-3.0, 0.6))
        reason = guard._viability.plan(state, push, 1e-3).reason
        ends[rate] = float(reason.split("before ")[1].split(" rad")[0])
    assert ends[None] < ends[1000.0] < ends[100.0]


def test_what_a_certificate_covers_would_pass_a_plan_of_its_own():
    arm, rng = ARMS["panda"], np.random.default_rng(1)
    guard = ac.Guard(Pushing(arm, np.zeros(7), np.zeros(7)))
    viability: Viability = guard._viability
    lower, upper = arm.position_limits
    covered = 0
    for _ in range(60):
        q, v = rng.uniform(lower + 0.4, upper - 0.4), 0.3 * rng.normal(size=7)
        state = arm.state(q, v)
        tau = state.nle + state.M @ rng.normal(size=7)
        reason, certificate = viability.plan(state, np.clip(tau, -arm.torque_limit, arm.torque_limit), 1e-3)
        if reason or certificate is None:
            continue
        for _ in range(20):
            near = arm.state(q + 0.03 * rng.uniform(-1.0, 1.0, 7), v + 0.3 * rng.normal(size=7))
            torque = np.array(certificate.tau) + 1.5 * np.array(certificate.radii) * rng.uniform(-1.0, 1.0, 7)
            if np.linalg.norm(near.q - q) <= 0.05 and certificate.covers(near.v.tolist(), torque.tolist()):
                covered += 1
                assert (np.abs(torque) <= arm.torque_limit).all()
                assert viability.plan(near, torque, 1e-3).reason == ""
    assert covered > 30
