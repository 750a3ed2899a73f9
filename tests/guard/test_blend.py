"""From one law to another in the middle of a motion: no step in the torque, the task kept, nothing left behind."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aspect_control import Blend, Run, StraightLine, Target, controllers, simulate
from aspect_control.exceptions import AspectControlError, NonFiniteError, NotResetError, ParameterError
from aspect_control.scenario import load_scenario
from example_arms import example_arm, random_motions

DT = 1e-3
WAY = 0.02  # 20 samples
KEEPING = ("pseudoinverse", "damped-null-space", "inertia-weighted", "operational-space", "null-space-vector", "qp")
"""Laws that give the commanded task acceleration in every state."""


def quintic(u):
    return 10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5


def create(name, arm, **parameters):
    return controllers.create(name, arm, **parameters)


def motion(arm, count, seed=0):
    """States along a smooth motion that no torque depends on, and targets near them."""
    rng = np.random.default_rng(seed)
    middle, speed = rng.uniform(-0.8, 0.8, arm.nv), rng.uniform(-1.0, 1.0, arm.nv)
    for i in range(count):
        q = arm.configuration(middle + speed * i * DT)
        yield (
            q,
            speed,
            Target(arm.task_position(q) + 1e-3, rng.normal(size=arm.task_dim), rng.normal(size=arm.task_dim)),
        )


def torques(law, samples):
    return np.array([law.torque(*sample) for sample in samples])


def begun(law, sample):
    law.reset(sample[0], sample[1], DT)
    return law


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda", "xyz")


@pytest.fixture(scope="module")
def setups():
    """The scenarios with a smooth line, so that every step of the torque is a law's."""
    settings = ['trajectory.profile="quintic"']
    return {name: load_scenario(name, settings).build(laws=()) for name in ("planar3r", "panda-xyz")}


# What the torque is


@pytest.mark.parametrize(
    "names", [("damped-null-space", "jmdc"), ("jmdc", "modified-null-space-vector"), ("qp", "jmdc")]
)
def test_before_and_after_the_torque_is_the_law_s_own_to_the_last_bit(panda, names):
    samples, at = list(motion(panda, 70)), 20
    laws, alone = ([create(name, panda) for name in names] for _ in range(2))
    blend = begun(Blend(*laws, duration=WAY, switch_at=at * DT), samples[0])
    tau = torques(blend, samples)
    np.testing.assert_array_equal(tau[:at], torques(begun(alone[0], samples[0]), samples[:at]))
    # The second law is reset at the sample at which it comes in.
    np.testing.assert_array_equal(tau[at + 19 :], torques(begun(alone[1], samples[at]), samples[at:])[19:])


def test_on_the_way_the_torque_is_the_weighted_mean_of_both(panda):
    samples, at = list(motion(panda, 60)), 20
    blend = begun(Blend(create("jmdc", panda), create("qp", panda), duration=WAY, switch_at=at * DT), samples[0])
    shares = []
    tau = []
    for sample in samples:
        tau.append(blend.torque(*sample))
        shares.append(blend.share)
    first = torques(begun(create("jmdc", panda), samples[0]), samples)
    second = torques(begun(create("qp", panda), samples[at]), samples[at:])
    u = np.clip(np.arange(1, 61) - at, 0, 20) / 20.0
    np.testing.assert_allclose(shares, quintic(u), atol=1e-14)
    s = quintic(u)[at:, None]
    np.testing.assert_allclose(np.array(tau)[at:], (1.0 - s) * first[at:] + s * second, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("dt", [1e-3, 0.7e-3, 3e-3])
@pytest.mark.parametrize("duration", [1e-4, 0.02, 0.0215])
def test_the_way_takes_its_time_whatever_the_sampling(panda, dt, duration):
    blend = Blend(create("pseudoinverse", panda), create("inertia-weighted", panda), duration=duration)
    sample = next(motion(panda, 1))
    blend.reset(*sample[:2], dt)
    blend.torque(*sample)
    assert blend.share == 0.0
    blend.switch()
    count = 0
    while blend.share < 1.0:
        blend.torque(*sample)
        count += 1
    assert (count - 1) * dt < duration <= count * dt * (1.0 + 1e-9)


# No step


def of_both(name, arm, **parameters):
    """A law that notes every torque."""

    class Noting(controllers.find(name)):
        def command(self, state, target):
            tau = super().command(state, target)
            self.noted.append(tau)
            return tau

    law = Noting(arm, **parameters)
    law.noted = []
    return law


PAIRS = [
    ("damped-null-space", "modified-null-space-vector"),
    ("damped-null-space", "jmdc"),
    ("pseudoinverse", "operational-space"),
    ("jmdc", "damped-null-space"),
]


@pytest.mark.parametrize("scenario", ["planar3r", "panda-xyz"])
@pytest.mark.parametrize("names", PAIRS)
def test_going_over_adds_no_step_to_what_the_laws_do_by_themselves(setups, scenario, names):
    setup, duration = setups[scenario], 0.2
    first, second = (of_both(name, setup.arm) for name in names)
    at = setup.trajectory.duration / 2.0
    run = simulate(Blend(first, second, duration=duration, switch_at=at), setup.trajectory, q0=setup.q0, dt=DT)
    assert run.status == "finished"
    begin, steps = round(at / DT), round(duration / DT)
    way = slice(begin, begin + steps - 1)
    tau_1, tau_2 = np.array(first.noted)[way], np.array(second.noted)[: steps - 1]
    apart = np.abs(tau_2 - tau_1).max()
    own = np.maximum(np.abs(np.diff(tau_1, axis=0)), np.abs(np.diff(tau_2, axis=0)))
    added = np.abs(np.diff(run.tau[way], axis=0)) - own
    assert added.max() <= 1.875 * apart * DT / duration + 1e-9
    # The very first sample: by a step from one law to the other it would be all of the difference.
    hard = np.abs(tau_2[0] - tau_1[0]).max()
    soft = np.abs(run.tau[begin] - tau_1[0]).max()
    assert soft <= 1e-4 * hard


def test_the_largest_step_between_smooth_laws_is_that_of_the_motion_itself(setups):
    for scenario, by_step in (("planar3r", 5.0), ("panda-xyz", 1.0)):
        setup = setups[scenario]
        steps = {}
        for duration in (DT, 0.2):
            blend = Blend(
                create("damped-null-space", setup.arm), create("jmdc", setup.arm), duration=duration, switch_at=0.5
            )
            run = simulate(blend, setup.trajectory, q0=setup.q0, dt=DT)
            steps[duration] = np.abs(np.diff(run.tau, axis=0)).max()
        smooth = simulate(create("jmdc", setup.arm), setup.trajectory, q0=setup.q0, dt=DT)
        own = np.abs(np.diff(smooth.tau, axis=0)).max()
        assert steps[DT] > by_step
        assert steps[0.2] < 1.5 * own


# The task is kept


@given(st.data())
def test_the_task_acceleration_is_the_commanded_one_at_every_share(data):
    name = data.draw(st.sampled_from(["planar3r", "panda", "kinova", "pr2"]))
    arm = example_arm(name, "xy" if name == "planar3r" else "xyz")
    first, second = (create(data.draw(st.sampled_from(KEEPING)), arm) for _ in range(2))
    q, v = random_motions(arm, 1, data.draw(st.integers(0, 10_000)))[0]
    state = arm.state(q, v)
    if np.linalg.cond(state.J @ state.J.T) > 1e6:
        return
    rng = np.random.default_rng(1)
    target = Target(arm.task_position(q) + 0.01, rng.normal(size=arm.task_dim), rng.normal(size=arm.task_dim))
    blend = Blend(first, second, duration=WAY)
    blend.reset(q, v, DT)
    blend.switch()
    commanded = first.commanded_acceleration(state, target) + state.drift
    for _ in range(data.draw(st.integers(1, 20))):
        tau = blend.torque(q, v, target)
    task_acceleration = state.J @ np.linalg.solve(state.M, tau - state.nle) + state.drift
    scale = 1.0 + np.abs(commanded).max() + np.abs(np.linalg.pinv(state.J)).max() * np.abs(tau).max() * 1e-6
    np.testing.assert_allclose(task_acceleration, commanded, atol=1e-7 * scale)


@pytest.mark.parametrize("scenario", ["planar3r", "panda-xyz"])
@pytest.mark.parametrize("names", PAIRS)
def test_the_tracking_error_is_no_larger_than_with_either_law(setups, scenario, names):
    setup = setups[scenario]
    laws = [create(name, setup.arm) for name in names]
    errors = [simulate(law, setup.trajectory, q0=setup.q0, dt=DT).tracking_error.max() for law in laws]
    for share in (0.2, 0.5, 0.8):
        blend = Blend(*laws, duration=0.2, switch_at=share * setup.trajectory.duration)
        run = simulate(blend, setup.trajectory, q0=setup.q0, dt=DT)
        assert run.status == "finished"
        assert run.tracking_error.max() <= 1.02 * max(errors)


# Switching


def test_it_waits_for_the_call_and_goes_back_with_a_second(panda):
    samples = list(motion(panda, 100))
    blend = begun(Blend(create("jmdc", panda), create("damped-null-space", panda), duration=WAY), samples[0])
    shares = []
    for i, sample in enumerate(samples):
        if i in (10, 60):
            blend.switch()
        blend.torque(*sample)
        shares.append(blend.share)
    assert set(shares[:10]) == {0.0}
    assert all(a < b for a, b in pairwise(shares[9:30]))
    assert set(shares[29:60]) == {1.0}
    np.testing.assert_allclose(shares[59:80], shares[9:30][::-1], atol=1e-14)
    assert set(shares[79:]) == {0.0}
    # The first law was reset where it came in again.
    again = begun(create("jmdc", panda), samples[60])
    np.testing.assert_array_equal(torques(blend, samples[:5]), [*torques(again, samples[60:] + samples[:5])[-5:]])


def test_it_turns_round_half_way_without_a_step(panda):
    sample = next(motion(panda, 1))
    blend = begun(Blend(create("pseudoinverse", panda), create("inertia-weighted", panda), duration=WAY), sample)
    shares = [blend.share]
    for i in range(20):
        if i in (0, 8):
            blend.switch()
        blend.torque(*sample)
        shares.append(blend.share)
    assert max(np.abs(np.diff(shares))) <= 1.875 / 20.0
    assert shares[8] == max(shares)
    np.testing.assert_allclose(shares[8:17], shares[8::-1], atol=1e-14)
    assert shares[-1] == 0.0


def test_a_reset_begins_with_the_first_law_and_its_time_again(panda):
    samples = list(motion(panda, 40))
    blend = Blend(create("damped-null-space", panda), create("jmdc", panda), duration=WAY, switch_at=0.01)
    one, other = (torques(begun(blend, samples[0]), samples) for _ in range(2))
    np.testing.assert_array_equal(one, other)
    blend.reset(*samples[0][:2], DT)
    assert blend.share == 0.0


def test_a_refused_call_leaves_a_switch_pending(panda):
    samples = list(motion(panda, 30))
    blend, twin = (begun(Blend(create("jmdc", panda), create("qp", panda), duration=WAY), samples[0]) for _ in range(2))
    for i, (q, v, target) in enumerate(samples):
        if i == 5:
            blend.switch()
            twin.switch()
        if i % 3 == 2:
            with pytest.raises(AspectControlError):
                blend.torque(q, v * np.nan, target)
        np.testing.assert_array_equal(blend.torque(q, v, target), twin.torque(q, v, target))
    assert blend.share == 1.0


def test_a_law_that_fails_on_the_way_leaves_no_trace(panda):
    class Failing(controllers.find("jmdc")):
        fails = False

        def command(self, state, target):
            tau = super().command(state, target)
            return tau * np.nan if self.fails else tau

    samples = list(motion(panda, 30))
    failing = Failing(panda)
    blend = begun(Blend(create("modified-null-space-vector", panda), failing, duration=WAY, switch_at=0.0), samples[0])
    twin = begun(
        Blend(create("modified-null-space-vector", panda), create("jmdc", panda), duration=WAY, switch_at=0.0),
        samples[0],
    )
    for sample in samples:
        failing.fails = True
        with pytest.raises(NonFiniteError, match=r"^blend: the torque is not finite"):
            blend.torque(*sample)
        failing.fails = False
        np.testing.assert_array_equal(blend.torque(*sample), twin.torque(*sample))


# Made, recorded, refused


def test_what_is_recorded_makes_it_again(panda, tmp_path):
    line = StraightLine([0.05, 0.1, 0.0], 0.1)
    q0 = [0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6]
    blend = Blend(create("jmdc", panda, kappa=0.1), create("damped-null-space", panda), duration=WAY, switch_at=0.03)
    run = simulate(blend, line, q0=q0, dt=DT)
    run.save(tmp_path / "run.npz")
    recorded = json.loads(json.dumps(Run.load(tmp_path / "run.npz").info.parameters))
    assert recorded == blend.parameters
    laws = [
        controllers.create(law.pop("name"), panda, **law) for law in (recorded.pop("first"), recorded.pop("second"))
    ]
    assert simulate(Blend(*laws, **recorded), line, q0=q0, dt=DT) == run
    assert run.info.controller == "blend"


def test_it_has_the_gains_of_the_stiffer_law_and_switches_if_one_does(panda):
    calm = create("damped-null-space", panda)
    stiff = create("modified-null-space-vector", panda, kp=400.0, kv=40.0)
    for laws in ((calm, stiff), (stiff, calm)):
        blend = Blend(*laws)
        assert (blend.kp.tolist(), blend.kv.tolist()) == (stiff.kp.tolist(), stiff.kv.tolist())
        assert blend.switches
    assert not Blend(calm, calm).switches


@pytest.mark.parametrize("parameter", ["first", "second", "duration", "switch_at"])
def test_its_parameters_are_fixed(panda, parameter):
    blend = Blend(create("pseudoinverse", panda), create("damped-null-space", panda), switch_at=1.0)
    with pytest.raises(AttributeError, match=f"{parameter} is fixed when a law is made"):
        setattr(blend, parameter, 2.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"first": "jmdc"}, "first must be a Controller, got 'jmdc'"),
        ({"second": None}, "second must be a Controller, got None"),
        ({"duration": 0.0}, "duration must be a finite number above 0 s, got 0.0"),
        ({"duration": float("inf")}, "duration must be a finite number above 0 s"),
        ({"switch_at": -1.0}, "switch_at must be a finite number of at least 0 s, got -1.0"),
        ({"switch_at": "now"}, "switch_at must be"),
    ],
)
def test_what_it_cannot_be_made_of_is_refused(panda, change, words):
    given = {"first": create("pseudoinverse", panda), "second": create("jmdc", panda), **change}
    with pytest.raises(ParameterError, match=words):
        Blend(**given)


def test_two_arms_are_refused(panda):
    with pytest.raises(ParameterError, match="both laws must be of one arm"):
        Blend(create("pseudoinverse", panda), create("pseudoinverse", example_arm("panda", "xy")))


def test_it_must_be_reset_before_it_is_switched_or_asked(panda):
    blend, sample = Blend(create("pseudoinverse", panda), create("jmdc", panda)), next(motion(panda, 1))
    with pytest.raises(NotResetError, match="call reset"):
        blend.switch()
    with pytest.raises(NotResetError, match="call reset"):
        blend.torque(*sample)
    assert blend.share == 0.0
