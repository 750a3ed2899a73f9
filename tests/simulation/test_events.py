"""Events that end a run, and motors that saturate."""

import re
import signal
import sys
import threading
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest

from aspect_control import Arm, Run, StraightLine, Target, controllers, simulate
from aspect_control.analysis import summarize
from aspect_control.exceptions import ParameterError, ShapeError, UnknownNameError
from aspect_control.guard import check_reach
from aspect_control.plants import RigidBodyPlant
from aspect_control.resources import model_path
from aspect_control.simulation import (
    DEFAULT_EVENTS,
    Diverged,
    Event,
    JointLimit,
    RungeKutta4,
    Sample,
    Singular,
    TorqueLimit,
    TrackingLost,
    WorkspaceLeft,
    completed,
    integrators,
)
from aspect_control.views import comparison_figure, run_figure, save_figure

ARM = Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0, 0, 0))
A = StraightLine([1.5, 1.0], duration=2.0)
Q0 = np.deg2rad([-50.0, 140.0, -140.0])
START = np.array([np.cos(np.cumsum(Q0)).sum(), np.sin(np.cumsum(Q0)).sum()])
OUTWARD = StraightLine(2.5 * START / np.linalg.norm(START), duration=2.0)
LAWS = ("pseudoinverse", "null-space-vector", "modified-null-space-vector", "jmdc")
ARRAYS = ("t", "q", "v", "tau", "x_desired", "dx_desired", "ddx_desired")
PANDA = Arm.from_example("panda", frame="panda_hand", task="xyz")
PANDA_LOWER, PANDA_UPPER = (PANDA.model.lowerPositionLimit.copy(), PANDA.model.upperPositionLimit.copy())


def law(name, **parameters):
    return controllers.create(name, ARM, **parameters)


def tip(q):
    phi = np.cumsum(q, axis=-1)
    return np.stack([np.cos(phi).sum(axis=-1), np.sin(phi).sum(axis=-1)], axis=-1)


def planar_manipulability(run):
    """The root of the sum of the squared minors, of the closed-form Jacobian of three links of one metre."""
    phi = np.cumsum(run.q, axis=1)
    columns = np.stack([-np.sin(phi), np.cos(phi)], axis=-1)
    J = np.cumsum(columns[:, ::-1], axis=1)[:, ::-1]
    minors = [J[:, i, 0] * J[:, j, 1] - J[:, i, 1] * J[:, j, 0] for i, j in ((0, 1), (1, 2), (2, 0))]
    return np.linalg.norm(minors, axis=0)


class Ended(NamedTuple):
    """A run that an event ends: what is run, by what it ends, and what the event compares with its limit.

    `measure` gives one number a sample, above `limit` at the sample that ends the run and at no other. `number` finds
    that number in the message, and `says` is what else is to be read there.
    """

    law: object
    trajectory: StraightLine
    options: dict
    event: Event
    status: str
    measure: object
    limit: float
    number: str
    says: str


CASES = {
    "diverged": Ended(
        law("null-space-vector"),
        A,
        {"q0": Q0, "dt": 0.05},
        Diverged(),
        "diverged",
        lambda run: np.abs(run.v).max(axis=1),
        1e3,
        r"joint 'joint3' at (\S+) rad/s",
        "limit 1000 rad/s",
    ),
    "diverged at a speed of one's own": Ended(
        law("null-space-vector"),
        A,
        {"q0": Q0},
        Diverged(5.0),
        "diverged",
        lambda run: np.abs(run.v).max(axis=1),
        5.0,
        r"joint 'joint3' at (\S+) rad/s",
        "limit 5 rad/s",
    ),
    "singular": Ended(
        law("pseudoinverse"),
        OUTWARD,
        {"q0": Q0},
        Singular(0.3),
        "singular",
        lambda run: -planar_manipulability(run),
        -0.3,
        r"manipulability (\S+),",
        "limit 0.3",
    ),
    "torque limit": Ended(
        law("pseudoinverse"),
        A,
        {"q0": Q0},
        TorqueLimit(20.0),
        "torque limit",
        lambda run: np.abs(run.tau).max(axis=1),
        20.0,
        r": (\S+) N m at joint 'joint1'",
        "limit 20 N m",
    ),
    "torque limit of one joint": Ended(
        law("pseudoinverse"),
        A,
        {"q0": Q0},
        TorqueLimit([np.inf, 10.0, 100.0]),
        "torque limit",
        lambda run: np.abs(run.tau[:, 1]),
        10.0,
        r": (\S+) N m at joint 'joint2'",
        "limit 10 N m",
    ),
    "joint limit": Ended(
        controllers.create("pseudoinverse", PANDA),
        StraightLine([-0.1, -0.2, 0.0], 1.0, profile="quintic"),
        {"q0": [2.8, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6], "dt": 2e-3},
        JointLimit(),
        "joint limit",
        lambda run: np.maximum(run.q - PANDA_UPPER, PANDA_LOWER - run.q).max(axis=1),
        0.0,
        r"joint 'panda_joint1' at (\S+) is outside",
        "its limits [-2.8973, 2.8973]",
    ),
    "tracking lost by weak gains": Ended(
        law("pseudoinverse", kp=0.1, kv=0.1),
        A,
        {"q0": Q0, "v0": [0.5, -0.5, 1.0]},
        TrackingLost(0.3),
        "tracking lost",
        lambda run: np.hypot(*(run.x_desired - tip(run.q)).T),
        0.3,
        r"'tool' is (\S+) m from its target",
        "limit 0.3 m; the manipulability there is ",
    ),
    "tracking lost by weak motors": Ended(
        law("pseudoinverse"),
        A,
        {"q0": Q0, "saturation": 3.0},
        TrackingLost(),
        "tracking lost",
        lambda run: np.hypot(*(run.x_desired - tip(run.q)).T),
        0.5,
        r"'tool' is (\S+) m from its target",
        "limit 0.5 m; the manipulability there is ",
    ),
    "workspace left": Ended(
        law("pseudoinverse"),
        OUTWARD,
        {"q0": Q0},
        WorkspaceLeft(),
        "workspace left",
        lambda run: np.hypot(*run.x_desired.T),
        3.0,
        r"at the worst it is (\S+) m beyond",
        "what 'planar3r' can reach",
    ),
}


@pytest.fixture(scope="module", params=CASES)
def ended(request):
    """A case, the run that its event ends, and the same run without any event."""
    case = CASES[request.param]
    runs = [simulate(case.law, case.trajectory, events=events, **case.options) for events in ([case.event], ())]
    return case, *runs


# Every event


def test_an_event_ends_the_run_with_its_status_and_the_time(ended):
    case, run, _ = ended
    assert run.status == run.info.status == case.status == case.event.status
    assert run.message.startswith(f"{case.status} at t = {run.t[-1]:.6g} s: ")


def test_only_the_last_sample_is_beyond_the_limit(ended):
    case, run, _ = ended
    measure = case.measure(run)
    assert len(run.t) > 1
    assert measure[:-1].max() <= case.limit < measure[-1]


def test_the_message_has_what_was_measured_and_the_limit(ended):
    case, run, _ = ended
    (number,) = re.search(case.number, run.message).groups()
    measured = abs(case.measure(run)[-1])
    if case.status == "joint limit":
        measured = run.q[-1, 0]
    if case.status == "workspace left":  # the end of the line, which lies ahead
        measured = np.hypot(*(START + case.trajectory.displacement)) - case.limit
    # At least three digits are printed.
    assert abs(float(number)) == pytest.approx(measured, rel=5e-3)
    assert case.says in run.message


def test_up_to_the_event_the_run_is_the_one_without_it(ended):
    _, run, whole = ended
    # A diverging motion may be over a sample later by itself.
    assert len(run.t) < len(whole.t) or whole.status == "diverged"
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(run, name), getattr(whole, name)[: len(run.t)])


def test_a_run_that_an_event_ended_is_finite_comes_back_and_is_summarised(ended, tmp_path):
    case, run, _ = ended
    assert all(np.isfinite(getattr(run, name)).all() for name in ARRAYS)
    run.save(tmp_path / "run.npz")
    loaded = Run.load(tmp_path / "run.npz")
    assert loaded == run
    assert (loaded.status, loaded.message) == (case.status, run.message)
    assert summarize(loaded) == summarize(run)
    assert (summarize(run)["status"], summarize(run)["message"]) == (case.status, run.message)


@pytest.mark.parametrize("name", ["diverged", "singular", "joint limit", "workspace left"])
def test_a_run_that_an_event_ended_is_drawn(name, tmp_path):
    case = CASES[name]
    run = simulate(case.law, case.trajectory, events=[case.event], **case.options)
    save_figure(run_figure(run), tmp_path / "run.png")
    save_figure(comparison_figure({run.info.controller: run}), tmp_path / "comparison.png")


def test_an_event_that_does_not_come_changes_nothing():
    events = [Diverged(), WorkspaceLeft(), TrackingLost(), Singular(0.01), TorqueLimit(1e3), JointLimit()]
    run = simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, events=events)
    assert (run.status, run.message, len(run.t)) == ("finished", "finished at t = 2 s", 101)
    assert run == simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, events=())


def test_the_first_event_of_several_has_the_word():
    first, second = Singular(100.0), TorqueLimit(1e-3)
    for events in ([first, second], [second, first]):
        run = simulate(law("pseudoinverse"), A, q0=Q0, events=events)
        assert (run.status, len(run.t)) == (events[0].status, 1)


def test_the_earliest_event_ends_the_run_whatever_the_order():
    late, early = TorqueLimit(20.0), TorqueLimit(14.2)
    for events in ([late, early], [early, late]):
        run = simulate(law("pseudoinverse"), A, q0=Q0, events=events)
        assert "limit 14.2 N m" in run.message


def test_the_default_events_are_divergence_the_workspace_and_tracking():
    assert [type(event) for event in DEFAULT_EVENTS] == [WorkspaceLeft, Diverged, TrackingLost]
    assert (DEFAULT_EVENTS[1].speed, DEFAULT_EVENTS[2].distance) == (1e3, 0.5)


# Events by name


@pytest.mark.parametrize(
    ("given", "event"),
    [
        ({"name": "torque-limit", "limit": 5.0}, TorqueLimit(5.0)),
        ({"name": "torque-limit", "limit": "urdf"}, TorqueLimit(ARM.torque_limit)),
        ({"name": "diverged", "speed": 0.5}, Diverged(0.5)),
        ({"name": "tracking-lost", "distance": 1e-9}, TrackingLost(1e-9)),
        ({"name": "singular", "manipulability": 1e3}, Singular(1e3)),
        ("workspace-left", WorkspaceLeft()),
        ("joint-limit", JointLimit()),
    ],
)
def test_an_event_named_ends_a_run_as_the_event_itself_does(given, event):
    one, other = (simulate(law("jmdc"), OUTWARD, q0=Q0, dt=1e-2, events=each) for each in ([given], [event]))
    assert one == other


@pytest.mark.parametrize(
    ("events", "error", "words"),
    [
        ("diverged", ParameterError, "events must be a sequence of events or their names, got 'diverged'"),
        (Diverged(), ParameterError, "events must be a sequence of events or their names, got <"),
        (["divergd"], UnknownNameError, "unknown event 'divergd': did you mean 'diverged'"),
        ([3.0], UnknownNameError, "unknown event 3.0: available: 'diverged', .*; or an Event itself"),
        ([Diverged], UnknownNameError, "or an Event itself"),
        ([{"speed": 1.0}], ParameterError, "an event with parameters needs a 'name' among them"),
        ([{"name": "diverged", "sped": 1.0}], UnknownNameError, "unknown parameter 'sped' in 'diverged': .*'speed'"),
        (["singular"], ParameterError, "'singular' needs 'manipulability'; its parameters: manipulability"),
        ([{"name": "torque-limit", "limit": [1.0, 2.0]}], ShapeError, "limit must be a number or a vector of 3"),
        ([{"name": "torque-limit", "limit": "file"}], ParameterError, "limit must be a number, one a joint, 'urdf'"),
    ],
)
def test_what_is_no_event_is_refused_before_the_run(events, error, words):
    with pytest.raises(error, match=words):
        simulate(law("jmdc"), OUTWARD, q0=Q0, dt=1e-2, events=events)


def test_an_event_of_one_s_own_sees_every_sample_as_it_is_recorded():
    class Watch(Event):
        status = "singular"

        def __init__(self):
            self.moments = []

        def check(self, moment):
            self.moments.append(moment)
            return "seen enough" if len(self.moments) == 12 else None

    watch = Watch()
    run = simulate(law("jmdc"), A, q0=Q0, v0=[0.1, -0.2, 0.3], events=[watch])
    assert (run.status, run.message) == ("singular", "singular at t = 0.011 s: seen enough")
    assert len(run.t) == 12
    assert all(moment.arm is ARM for moment in watch.moments)
    for name in ("t", "q", "v", "tau"):
        np.testing.assert_array_equal([getattr(moment, name) for moment in watch.moments], getattr(run, name))
    np.testing.assert_array_equal([moment.target.x for moment in watch.moments], run.x_desired)


# Leaving the workspace


def crossing_of_the_circle(displacement, duration):
    """When the start plus s(t) times the displacement is 3 m from the origin; bang-bang: 2u², then 1 − 2(1 − u)²."""
    a, b, c = displacement @ displacement, 2.0 * START @ displacement, START @ START - 9.0
    s = (-b + np.sqrt(b**2 - 4.0 * a * c)) / (2.0 * a)
    return duration * (np.sqrt(s / 2.0) if s < 0.5 else 1.0 - np.sqrt((1.0 - s) / 2.0))


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("displacement", [[2.3, -0.9], [1.0, 2.9], [2.2, -0.2]])
def test_a_line_that_leaves_the_disc_ends_the_run_where_it_does(displacement, name):
    run = simulate(law(name), StraightLine(displacement, 2.0), q0=Q0, dt=2e-3)
    expected = crossing_of_the_circle(np.array(displacement), 2.0)
    assert run.status == "workspace left"
    assert 0.0 <= run.t[-1] - expected <= 2e-3
    ended, time, beyond = re.search(
        r"t = (\S+) s: the path leaves the workspace at t = (\S+) s, .* (\S+) m beyond", run.message
    ).groups()
    assert float(ended) == pytest.approx(run.t[-1], rel=1e-6)
    assert float(time) == pytest.approx(expected, abs=1e-5)
    assert float(beyond) == pytest.approx(np.hypot(*(START + displacement)) - 3.0, rel=6e-3)
    assert all(np.isfinite(getattr(run, each)).all() for each in ARRAYS)


def test_the_very_edge_of_the_workspace_belongs_to_it():
    # Half a metre up and down again with the stretched arm at its highest: 3 m, up to rounding.
    q0 = np.array([np.pi / 2 - 0.3, 0.6, -0.6])
    start = tip(q0)
    up = np.array([0.0, 3.0 * (1.0 + 1e-12)]) - start
    run = simulate(law("jmdc"), StraightLine(up, 1.0), q0=q0, events=[WorkspaceLeft()])
    assert run.status == "finished"


@pytest.mark.parametrize("name", ["pseudoinverse", "damped-null-space", "jmdc", "qp"])
@pytest.mark.parametrize("task", ["xy", "xyz", "pose"])
def test_a_calm_law_does_not_diverge_before_the_path_leaves_what_a_real_arm_can_reach(name, task):
    arm = Arm.from_example("panda", frame="panda_hand", task=task)
    q0 = np.array([0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6])
    line = StraightLine(np.array([0.5, 1.0, 0.7, 0.2, 0.1, 0.0])[: arm.task_dim], 1.0, profile="quintic")
    run = simulate(controllers.create(name, arm), line, q0=q0, dt=2e-3)
    assert run.status == "workspace left"
    # The sum of all links is farther away than the arm gets.
    x = run.x_desired[-1][: len(arm.coordinates.position_axes)]
    assert np.linalg.norm(x - arm.kinematics.first_joint_in_task) < 0.95 * arm.reach


def test_joint_limits_alone_end_no_run():
    # Joint 2 would have to lean farther than it can.
    q0 = np.deg2rad([-73.0, 94.0, 8.0, -78.0, 96.0, 146.0, 120.0])
    line = StraightLine([0.008, 0.226, -0.106], 1.0, profile="quintic")
    assert check_reach(PANDA, line, q0).joint == "panda_joint2"
    assert check_reach(PANDA, line, q0, joint_limits=False).reachable
    assert simulate(controllers.create("damped-null-space", PANDA), line, q0=q0, dt=5e-3).status == "finished"


def test_a_target_alone_leaves_the_workspace_too():
    far, near = (Target(x, np.zeros(2), np.zeros(2)) for x in ([3.0, 1.0], [2.0, 1.0]))
    samples = [Sample(ARM, 0.0, Q0, np.zeros(3), np.zeros(3), target) for target in (far, near)]
    assert WorkspaceLeft().check(samples[0]) == "the target (3, 1) is 0.162 m beyond what 'planar3r' can reach"
    assert WorkspaceLeft().check(samples[1]) is None


def test_an_event_looks_at_the_motion_before_it_starts_and_carries_nothing_to_the_next():
    class Halfway(Event):
        status = "halfway"

        def __init__(self, time=None):
            self.time = time

        def begin(self, arm, trajectory, q0):
            np.testing.assert_array_equal(q0, Q0)
            return Halfway(trajectory.duration / 2.0)

        def check(self, sample):
            return "seen enough" if sample.t >= self.time else None

    event = Halfway()
    for duration in (0.2, 0.1):
        run = simulate(law("jmdc"), StraightLine([0.1, 0.1], duration), q0=Q0, dt=1e-2, events=[event])
        assert run.message == f"halfway at t = {duration / 2.0:g} s: seen enough"
    assert event.time is None


# At the first sample


@pytest.fixture(scope="module", params=LAWS)
def first_sample(request):
    return simulate(law(request.param), A, q0=Q0, events=[Singular(100.0)])


def test_a_run_that_ends_at_its_first_sample_has_that_sample(first_sample):
    assert (first_sample.status, len(first_sample.t)) == ("singular", 1)
    assert first_sample.message.startswith("singular at t = 0 s: manipulability ")
    np.testing.assert_array_equal(first_sample.q, [Q0])
    np.testing.assert_array_equal(first_sample.x_desired, [ARM.task_position(Q0)])


def test_a_run_of_one_sample_comes_back(first_sample, tmp_path):
    first_sample.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == first_sample


def test_a_run_of_one_sample_is_summarised(first_sample):
    summary = summarize(first_sample)
    assert summary["status"] == "singular"
    assert summary["peak_torque"] == np.abs(first_sample.tau[0]).tolist()
    assert summary["peak_torque_time"] == [0.0, 0.0, 0.0]
    assert summary["minor_zero_crossings"] == []
    assert summary["torque_squared_integral"] == 0.0


def test_a_run_of_one_sample_is_drawn(first_sample, tmp_path):
    save_figure(run_figure(first_sample), tmp_path / "run.png")


def test_a_run_of_one_sample_is_compared(first_sample, tmp_path):
    save_figure(comparison_figure({first_sample.info.controller: first_sample}), tmp_path / "comparison.png")


def test_a_run_that_ends_at_its_second_sample_is_drawn_and_compared(tmp_path):
    run = simulate(law("jmdc"), A, q0=Q0, events=[TorqueLimit(1.0)])
    assert len(run.t) == 2
    save_figure(run_figure(run), tmp_path / "run.png")
    save_figure(comparison_figure({"jmdc": run}), tmp_path / "comparison.png")


# Without events


@pytest.mark.parametrize(("name", "dt"), [("null-space-vector", 0.05), ("jmdc", 0.2), ("pseudoinverse", 0.2)])
def test_without_events_a_run_goes_on_until_its_state_is_not_finite(name, dt):
    run = simulate(law(name), A, q0=Q0, dt=dt, events=())
    assert run.status == "diverged"
    # The sample that is not finite has no place in a recording: the message has its time.
    assert run.message.startswith(f"diverged at t = {len(run.t) * dt:.6g} s: ")
    assert np.abs(run.v).max() > 1e3
    assert all(np.isfinite(getattr(run, each)).all() for each in ARRAYS)


def test_continuous_joints_diverge_like_others():
    arm = Arm.from_example("kinova", frame="j2s6s200_end_effector", task="xyz")
    q0 = arm.configuration([0.4, 2.8, 1.6, 0.6, 2.0, 3.0])
    line = StraightLine([0.1, 0.1, 0.1], 1.0)
    for speed in (1e3, 1e8, 1e20):
        run = simulate(controllers.create("jmdc", arm), line, q0=q0, v0=np.full(6, speed), events=())
        assert run.status == "diverged"
        assert all(np.isfinite(getattr(run, each)).all() for each in ARRAYS)


# What is refused


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "fast", None, True, [1.0]])
@pytest.mark.parametrize("event", [Diverged, TrackingLost, Singular])
def test_a_limit_that_is_no_number_above_zero_is_refused(event, value):
    with pytest.raises(ParameterError, match="must be a"):
        event(value)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, [1.0, 0.0, 1.0], [1.0, np.nan, 1.0], [1.0, -np.inf, 1.0]])
def test_a_torque_limit_that_is_not_above_zero_is_refused(value):
    with pytest.raises(ParameterError, match="limit must be above 0 N m"):
        TorqueLimit(value)
    with pytest.raises(ParameterError, match="saturation must be above 0 N m"):
        simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, saturation=value)


@pytest.mark.parametrize("value", [[1.0, 2.0], [1.0] * 4, [], [[1.0, 2.0, 3.0]]])
def test_a_torque_limit_of_another_shape_is_refused(value):
    with pytest.raises(ShapeError, match="limit must"):
        simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, events=[TorqueLimit(value)])


@pytest.mark.parametrize("value", [[1.0, 2.0], [1.0] * 4, [], [[1.0, 2.0, 3.0]]])
def test_a_saturation_of_another_shape_is_refused(value):
    with pytest.raises(ShapeError, match="saturation must"):
        simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, saturation=value)


@pytest.mark.parametrize("value", ["strong", [1.0, [2.0]], 1.0 + 2.0j])
def test_a_torque_limit_that_is_no_number_is_refused_with_an_error_of_ours(value):
    with pytest.raises((ParameterError, ShapeError), match="limit must"):
        TorqueLimit(value)
    with pytest.raises((ParameterError, ShapeError), match="saturation must"):
        simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, saturation=value)


# Saturation


@pytest.mark.parametrize("integrator", integrators.available())
@pytest.mark.parametrize("saturation", [5.0, [5.0], [13.0, 5.0, 4.0], [np.inf, 5.0, np.inf]])
def test_the_recorded_torque_is_the_law_s_cut_off_and_is_what_the_plant_got(saturation, integrator):
    controller = law("pseudoinverse")
    run = simulate(controller, A, q0=Q0, dt=2e-3, saturation=saturation, events=(), integrator=integrator)
    limit, plant, method = np.broadcast_to(saturation, 3), RigidBodyPlant(ARM), integrators.create(integrator)
    asked = np.array(
        [controller.torque(q, v, A.target(t, run.x_desired[0])) for t, q, v in zip(run.t, run.q, run.v, strict=True)]
    )
    assert np.all(np.abs(run.tau) <= limit)
    assert np.all((np.abs(run.tau) == limit).any(axis=0) == np.isfinite(limit))
    np.testing.assert_array_equal(run.tau, np.where(np.abs(asked) > limit, np.copysign(limit, asked), asked))
    for i in range(len(run.t) - 1):
        q, v = method.step(plant, run.q[i], run.v[i], run.tau[i], 2e-3)
        np.testing.assert_array_equal([q, v], [run.q[i + 1], run.v[i + 1]])


def test_a_number_stands_for_all_joints():
    each = [simulate(law("jmdc"), A, q0=Q0, dt=0.02, saturation=limit) for limit in (9.0, [9.0], [9.0] * 3)]
    assert each[0] == each[1] == each[2]


@pytest.mark.parametrize("saturation", [np.inf, [np.inf] * 3, 1e9])
@pytest.mark.parametrize("name", LAWS)
def test_motors_that_are_strong_enough_change_nothing(name, saturation):
    free = simulate(law(name), A, q0=Q0, dt=4e-3)
    assert simulate(law(name), A, q0=Q0, dt=4e-3, saturation=saturation) == free


def test_the_limits_of_the_panda_s_urdf_cut_off_what_a_hasty_motion_asks_for():
    q0, line = np.array([0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6]), StraightLine([0.1, 0.15, -0.08], 0.1)
    np.testing.assert_array_equal(PANDA.torque_limit, [87.0] * 4 + [12.0] * 3)
    free, cut = (
        simulate(controllers.create("pseudoinverse", PANDA), line, q0=q0, saturation=saturation, events=())
        for saturation in (None, PANDA.torque_limit)
    )
    assert np.any(np.abs(free.tau) > PANDA.torque_limit)
    assert np.all(np.abs(cut.tau) <= PANDA.torque_limit)
    assert np.any(np.abs(cut.tau) == PANDA.torque_limit)


def test_the_torque_limit_event_sees_the_torque_before_it_is_cut_off():
    events = [TorqueLimit(14.2)]
    run = simulate(law("pseudoinverse"), A, q0=Q0, saturation=8.0, events=events)
    assert run.status == "torque limit"
    assert np.abs(run.tau).max() == 8.0
    state = ARM.state(run.q[-1], run.v[-1])
    b = run.ddx_desired[-1] + 20.0 * (run.dx_desired[-1] - state.dx) + 100.0 * (run.x_desired[-1] - state.x)
    asked = state.M @ np.linalg.pinv(state.J) @ (b - state.drift) + state.nle
    assert np.abs(asked).max() > 14.2
    assert f"{asked[np.abs(asked).argmax()]:.4g} N m" in run.message


def test_infinite_limits_of_the_event_are_never_reached():
    run = simulate(law("null-space-vector"), A, q0=Q0, dt=2e-3, events=[TorqueLimit([np.inf, np.inf, np.inf])])
    assert run.status == "finished"


def test_saturation_loses_energy_bookkeeping_nowhere():
    """The work of the torques as recorded is the gain in energy, cut off or not."""
    run, plant = simulate(law("pseudoinverse"), A, q0=Q0, saturation=10.0, events=()), RigidBodyPlant(ARM)
    assert np.any(np.abs(run.tau) == 10.0)
    work = np.sum(run.tau[:-1] * np.diff(run.q, axis=0))
    gain = plant.energy(run.q[-1], run.v[-1]) - plant.energy(run.q[0], run.v[0])
    kinetic = 0.5 * run.v[-1] @ pin.crba(ARM.model, ARM.model.createData(), run.q[-1]) @ run.v[-1]
    assert gain == pytest.approx(kinetic, rel=1e-12)
    assert work == pytest.approx(gain, abs=1e-8)


# What watch, events and the user raise


class Raising(Event):
    status = "never"

    def __init__(self, error, t):
        self.error, self.t = error, t

    def check(self, moment):
        if moment.t >= self.t:
            raise self.error


def raising(error, t):
    """The arguments of `simulate` by which each of its callbacks raises an error at or soon after a time."""

    def watch(moment):
        if moment.t >= t:
            raise error

    def progress(part):
        if 2.0 * part >= t:
            raise error

    return {
        "watch": {"watch": watch},
        "Raising": {"events": (Diverged(), Raising(error, t))},
        "progress": {"progress": progress},
    }


CALLBACKS = ("watch", "Raising", "progress")


@pytest.fixture(scope="module")
def whole():
    return simulate(law("jmdc"), A, q0=Q0, dt=2e-3)


def assert_beginning_of(run, whole):
    assert 1 <= len(run.t) < len(whole.t)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(run, name), getattr(whole, name)[: len(run.t)])


@pytest.mark.parametrize("by", CALLBACKS)
@pytest.mark.parametrize("error", [RuntimeError("no more"), ParameterError("no more"), ZeroDivisionError("no more")])
def test_an_error_of_the_user_s_own_code_ends_the_run_which_says_so_and_can_be_saved(whole, tmp_path, by, error):
    run = simulate(law("jmdc"), A, q0=Q0, dt=2e-3, **raising(error, 0.5)[by])
    assert_beginning_of(run, whole)
    assert (run.status, run.error) == ("failed", error)
    assert run.message == f"failed at t = {run.t[-1]:.6g} s: {by} raised {type(error).__name__}: no more"
    assert run.t[-1] == pytest.approx(0.5, abs=0.03)
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz") == run
    with pytest.raises(type(error), match="no more"):
        completed(run)


@pytest.mark.parametrize("by", CALLBACKS)
def test_ctrl_c_ends_the_run_which_says_so_and_can_be_saved(whole, tmp_path, by):
    run = simulate(law("jmdc"), A, q0=Q0, dt=2e-3, **raising(KeyboardInterrupt(), 0.5)[by])
    assert_beginning_of(run, whole)
    assert run.status == "interrupted"
    assert run.message == f"interrupted at t = {run.t[-1]:.6g} s: by the user"
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").status == "interrupted"
    with pytest.raises(KeyboardInterrupt):
        completed(run)


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_real_signal_in_the_middle_of_a_sample_leaves_whole_samples():
    finer = simulate(law("jmdc"), A, q0=Q0, dt=1e-4)
    for delay in (0.01, 0.02, 0.05):
        timer = threading.Timer(delay, signal.raise_signal, [signal.SIGINT])

        def start_at_the_first_sample(moment, timer=timer):
            if moment.t == 0.0:
                timer.start()

        run = simulate(law("jmdc"), A, q0=Q0, dt=1e-4, watch=start_at_the_first_sample)
        timer.join()
        assert run.status == "interrupted"
        assert_beginning_of(run, finer)


def test_ctrl_c_before_the_first_sample_goes_on():
    class Interrupted(controllers.NullSpaceVector):
        def command(self, state, target):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(Interrupted(ARM), A, q0=Q0)


def test_an_error_of_a_law_or_a_trajectory_reaches_the_caller_as_it_is():
    class Broken(controllers.NullSpaceVector):
        def command(self, state, target):
            raise ZeroDivisionError("broken")

    class Line(StraightLine):
        def target(self, t, start, task=None):
            raise ZeroDivisionError("broken")

    for broken, line in ((Broken(ARM), A), (law("jmdc"), Line([1.5, 1.0], 2.0))):
        with pytest.raises(ZeroDivisionError, match="broken"):
            simulate(broken, line, q0=Q0)


def test_a_run_that_nothing_interrupts_has_no_error(whole):
    assert whole.error is None
    assert completed(whole) is whole


@pytest.mark.parametrize("saturation", [None, 5.0])
def test_watch_and_events_cannot_change_the_run(whole, saturation):
    class Meddling(Event):
        status = "never"

        def check(self, moment):
            watch(moment)

    def watch(moment):
        for array in (moment.q, moment.v, moment.tau, moment.target.x, moment.target.dx, moment.target.ddx):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1e3
        moment.x[:] = 1e3

    plain = simulate(law("jmdc"), A, q0=Q0, dt=2e-3, saturation=saturation)
    run = simulate(
        law("jmdc"), A, q0=Q0, dt=2e-3, saturation=saturation, watch=watch, events=(Meddling(), *DEFAULT_EVENTS)
    )
    assert run == plain


def test_the_task_value_of_a_moment_depends_on_nothing_but_its_configuration():
    seen = []

    def watch(moment):
        moment.arm.task_position(-moment.q)
        seen.append(moment)

    run = simulate(law("jmdc"), A, q0=Q0, dt=2e-2, watch=watch)
    np.testing.assert_array_equal([moment.x for moment in seen], run.x)


def test_an_integrator_and_a_law_that_use_their_arrays_again_change_no_recorded_sample(whole):
    class Reusing(RungeKutta4):
        def __init__(self):
            self.q, self.v = np.empty(3), np.empty(3)

        def step(self, plant, q, v, tau, dt):
            self.q[:], self.v[:] = super().step(plant, q, v, tau, dt)
            return self.q, self.v

    seen = []
    run = simulate(law("jmdc"), A, q0=Q0, dt=2e-3, integrator=Reusing(), watch=seen.append)
    assert run == whole
    np.testing.assert_array_equal([moment.q for moment in seen], run.q)
    np.testing.assert_array_equal([moment.v for moment in seen], run.v)
