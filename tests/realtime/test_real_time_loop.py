import gc
import os
import signal
import threading
import time
import warnings

import numpy as np
import pytest

import aspect_control as ac
from aspect_control import controllers, views
from aspect_control.analysis import summarize
from aspect_control.exceptions import ParameterError, RobotError, ShapeError
from aspect_control.realtime import ClockedRobot, RealTimeLoop, Robot
from aspect_control.realtime.safe_stop import AT_REST
from aspect_control.simulation.run_file import ARRAYS
from plant_robot import PlantRobot, UnclockedRobot

Q0 = np.deg2rad([-50.0, 140.0, -140.0])
LINE = ac.StraightLine([0.3, 0.2], duration=0.4)


class Faulty(controllers.Pseudoinverse):
    """A law that raises after some samples."""

    name = "faulty"

    def __init__(self, arm, samples, error):
        super().__init__(arm)
        self.left, self.error = samples + 20, error  # the ticks of the warm-up

    def command(self, state, target):
        self.left -= 1
        if self.left < 0:
            raise self.error
        return super().command(state, target)


def at_rest(robot):
    """Whether the robot stays where it is under its last torque."""
    before = robot.q
    for _ in range(200):
        robot.read()
    return np.abs(robot.q - before).max() < 0.01


# The loop is the loop of a simulation


@pytest.mark.parametrize("name", controllers.available())
def test_every_law_moves_a_plant_as_in_a_simulation_to_the_last_bit(planar, name):
    law = controllers.create(name, planar)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        simulated = ac.simulate(law, LINE, q0=Q0, dt=1e-3)
        run = RealTimeLoop(PlantRobot(planar, Q0), controllers.create(name, planar)).follow(LINE)
    assert run.status == simulated.status == "finished"
    for each in ARRAYS:
        np.testing.assert_array_equal(getattr(run, each), getattr(simulated, each), err_msg=each)


@pytest.mark.parametrize("name", controllers.available())
def test_warming_up_leaves_no_trace_in_a_law(planar, name):
    """The recorded torques are those of a law that was never warmed up, to the last bit."""
    run = RealTimeLoop(PlantRobot(planar, Q0), controllers.create(name, planar)).follow(LINE)
    fresh, task = controllers.create(name, planar), planar.coordinates
    fresh.reset(run.q[0], run.v[0], 1e-3)
    start = planar.task_position(run.q[0])
    for t, q, v, tau in zip(run.t, run.q, run.v, run.tau, strict=True):
        assert (fresh.torque(q, v, LINE.target(t, start, task)) == tau).all()


def test_a_law_is_warm_at_the_first_sample_and_nothing_is_sent_for_that(planar):
    ticks = []

    class Counting(controllers.Pseudoinverse):
        def command(self, state, target):
            ticks.append(len(robot.written))
            return super().command(state, target)

    robot = PlantRobot(planar, Q0)
    loop = RealTimeLoop(robot, Counting(planar))
    loop.follow(LINE)
    assert ticks[:21] == [0] * 21
    assert ticks[21] == 1
    assert loop.timing.warm_up > 0.0


def test_the_recording_is_a_run_like_any_other(planar, tmp_path):
    law = controllers.create("damped-null-space", planar)
    run = RealTimeLoop(PlantRobot(planar, Q0), law).follow(LINE)
    assert (run.info.controller, run.info.plant, run.info.trajectory) == (law.name, "PlantRobot", repr(LINE))
    run.save(tmp_path / "run.npz")
    assert ac.Run.load(tmp_path / "run.npz") == run
    assert summarize(run)["max_tracking_error"] < 1e-3
    views.replay(run, tmp_path / "run.html")
    assert (tmp_path / "run.html").stat().st_size > 100_000


def test_a_long_motion_is_recorded_in_several_blocks(planar, monkeypatch):
    monkeypatch.setattr("aspect_control.realtime.recording.BLOCK", 50)
    robot = PlantRobot(planar, Q0)
    run = RealTimeLoop(robot, controllers.create("pseudoinverse", planar)).follow(LINE)
    assert (run.tau == np.array(robot.written[: len(run.t)])).all()
    assert len(run.t) >= 400


def test_hold_stays_where_the_robot_is(planar):
    run = RealTimeLoop(PlantRobot(planar, Q0), controllers.create("damped-null-space", planar)).hold(0.2)
    assert run.status == "finished"
    assert run.tracking_error.max() < 1e-9


# How a motion ends


@pytest.mark.parametrize("error", [ValueError("no such thing"), MemoryError(), RecursionError("deep")])
def test_an_exception_of_the_law_ends_the_motion_and_the_arm_is_braked(planar, error):
    robot = PlantRobot(planar, Q0)
    loop = RealTimeLoop(robot, Faulty(planar, 200, error))
    run = loop.follow(LINE)
    assert (run.status, run.error, len(run.t)) == ("failed", error, 200)
    assert run.message == f"failed at t = 0.2 s: {type(error).__name__}: {error}"
    assert loop.run is run
    assert np.abs(run.v[-1]).max() > 0.5
    assert np.abs(robot.v).max() <= AT_REST
    assert at_rest(robot)
    assert robot.stops == 1


def test_an_exception_of_watch_ends_the_motion(planar):
    def watch(sample):
        assert not sample.q.flags.writeable
        assert not sample.tau.flags.writeable
        if sample.t > 0.1:
            raise OSError("disk full")

    robot = PlantRobot(planar, Q0)
    run = RealTimeLoop(robot, controllers.create("jmdc", planar), watch=watch).follow(LINE)
    assert (run.status, str(run.error)) == ("failed", "disk full")
    assert at_rest(robot)


@pytest.mark.parametrize(
    ("number", "error", "status"),
    [(signal.SIGINT, KeyboardInterrupt, None), (signal.SIGTERM, SystemExit, 143)],
    ids=["SIGINT", "SIGTERM"],
)
def test_a_signal_ends_the_motion_in_good_order(planar, number, error, status):
    def watch(sample):
        if len(robot.written) == 150:
            os.kill(os.getpid(), number)

    before, robot = signal.getsignal(number), PlantRobot(planar, Q0)
    run = RealTimeLoop(robot, controllers.create("jmdc", planar), watch=watch).follow(LINE)
    assert (run.status, type(run.error)) == ("interrupted", error)
    assert run.message == f"interrupted at t = 0.15 s: by {number.name}"
    assert getattr(run.error, "code", None) == status
    assert (len(run.t), signal.getsignal(number)) == (150, before)
    assert at_rest(robot)


def test_a_second_signal_does_what_it_did_before(planar):
    def watch(sample):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    run = RealTimeLoop(PlantRobot(planar, Q0), controllers.create("jmdc", planar), watch=watch).follow(LINE)
    assert (run.status, run.message) == ("interrupted", "interrupted at t = 0 s: by KeyboardInterrupt")


def test_the_loop_runs_in_a_thread_that_gets_no_signals(planar):
    runs = []
    loop = RealTimeLoop(PlantRobot(planar, Q0), controllers.create("jmdc", planar))
    thread = threading.Thread(target=lambda: runs.append(loop.follow(LINE)))
    thread.start()
    thread.join()
    assert runs[0].status == "finished"


def test_a_law_that_has_stopped_ends_the_motion(planar):
    class Status:
        state, reason = "running", ""

    class Stopping(controllers.Pseudoinverse):
        status = Status()

        def command(self, state, target):
            if target.dx.any():
                self.status.state, self.status.reason = "stopped", "target out of reach"
            return super().command(state, target)

    run = RealTimeLoop(PlantRobot(planar, Q0), Stopping(planar)).follow(LINE)
    assert (run.status, run.message, run.error) == ("stopped", "stopped at t = 0.001 s: target out of reach", None)


def test_a_law_that_does_not_start_ends_before_the_first_command(planar):
    class Refusing(controllers.Pseudoinverse):
        class status:
            state, reason = "stopping", "joint 2 starts outside its limits"

    robot = PlantRobot(planar, Q0)
    with pytest.raises(ParameterError, match="the law does not start here: joint 2 starts outside its limits"):
        RealTimeLoop(robot, Refusing(planar)).follow(LINE)
    assert (robot.written, robot.stops) == ([], 0)


def test_what_is_wrong_before_the_first_command_is_raised_and_nothing_is_sent(planar):
    robot = PlantRobot(planar, Q0)
    loop = RealTimeLoop(robot, Faulty(planar, 0, ValueError("no")))
    with pytest.raises(ValueError, match="no"):
        loop.follow(LINE)
    robot.q = np.full(3, np.nan)
    with pytest.raises(ac.AspectControlError):
        RealTimeLoop(robot, controllers.create("jmdc", planar)).follow(LINE)
    assert (robot.written, robot.stops, loop.run) == ([], 0, None)


class Going(PlantRobot):
    """A robot that no longer answers after some readings."""

    def __init__(self, arm, readings, writes=True):
        super().__init__(arm, Q0)
        self.left, self.writes = readings, writes

    def read(self):
        self.left -= 1
        if self.left < 0:
            raise RobotError("no answer")
        return super().read()

    def write(self, tau):
        if self.left < 0 and not self.writes:
            raise RobotError("no way")
        super().write(tau)


def test_a_robot_that_cannot_be_read_gets_a_last_command_that_carries_it(seven):
    robot = Going(seven, 100)
    robot.q, robot.v = np.full(7, 0.4), np.zeros(7)
    run = RealTimeLoop(robot, controllers.create("damped-null-space", seven)).hold(1.0)
    assert (run.status, len(run.t)) == ("failed", 99)
    assert run.message.endswith("RobotError: no answer; the arm was not braked: RobotError: no answer")
    np.testing.assert_allclose(robot.written[-1], seven.state(run.q[-1], np.zeros(7)).nle, rtol=0, atol=1e-12)


def test_a_robot_that_is_gone_is_no_exception(planar):
    run = RealTimeLoop(Going(planar, 50, writes=False), controllers.create("jmdc", planar)).follow(LINE)
    assert (run.status, len(run.t)) == ("failed", 49)


def test_the_last_torque_fades_into_the_brakes_without_a_step(seven):
    robot = PlantRobot(seven, np.full(7, 0.4))
    moving = ac.StraightLine([0.1, 0.1, 0.1], duration=0.4, profile="quintic")

    def watch(sample):
        if sample.t > 0.2:
            raise RuntimeError("stop here")

    run = RealTimeLoop(robot, controllers.create("damped-null-space", seven), watch=watch).follow(moving)
    written = np.array(robot.written)
    steps = np.abs(np.diff(written[len(run.t) - 1 :], axis=0)).max(axis=1)
    whole = np.abs(written[len(run.t) - 1] - written[len(run.t) + 50]).max()
    assert steps[0] < 1e-9
    assert steps.max() < 0.1 * whole
    assert (np.abs(np.array(robot.written)) <= seven.torque_limit).all()
    assert at_rest(robot)


def test_an_arm_with_a_load_that_nobody_told_of_is_held(seven):
    """The last command carries what the arm needed to be held, not only what the model says."""
    robot = PlantRobot(seven, np.full(7, 0.4))
    heavier = seven.model.copy()
    inertia = heavier.inertias[7]
    inertia.mass += 1.0
    heavier.inertias[7] = inertia
    robot.plant._model, robot.plant._data = heavier, heavier.createData()
    RealTimeLoop(robot, controllers.create("damped-null-space", seven)).hold(0.3)
    alone = PlantRobot(seven, robot.q)
    alone.plant._model, alone.plant._data = heavier, heavier.createData()
    alone.write(seven.state(robot.q, np.zeros(7)).nle)
    held = robot.q
    for _ in range(100):
        robot.read()
        alone.read()
    assert np.abs(robot.q - held).max() < 0.2 * np.abs(alone.q - held).max()


# Whose clock


def test_samples_that_were_lost_are_left_out_of_the_motion_and_counted(planar):
    class Losing(PlantRobot):
        def read(self):
            if len(self.written) == 100:
                for _ in range(3):
                    super().read()
            return super().read()

    loop = RealTimeLoop(Losing(planar, Q0), controllers.create("damped-null-space", planar))
    run = loop.follow(LINE)
    assert np.rint(np.diff(run.t) / 1e-3).tolist()[98:101] == [1.0, 4.0, 1.0]
    assert loop.timing.samples_lost == 3
    assert run.t[-1] <= LINE.duration * (1.0 + 1e-12)
    assert run.tracking_error.max() < 2e-3


@pytest.mark.parametrize("step", [0.0, -1e-3, 4e-4])
def test_a_clock_that_stands_still_or_is_another_one_ends_the_motion(planar, step):
    robot = PlantRobot(planar, Q0)

    def watch(sample):
        if len(robot.written) == 50:
            robot.readings += step / 1e-3 - 1.0

    run = RealTimeLoop(robot, controllers.create("jmdc", planar), watch=watch).follow(LINE)
    assert (run.status, len(run.t)) == ("failed", 50)
    assert "the robot's clock went from 0.049 s to" in run.message


def test_a_robot_without_a_clock_is_read_at_absolute_deadlines(planar):
    robot = UnclockedRobot(planar, Q0, 5e-3)
    assert isinstance(robot, Robot)
    assert not isinstance(robot, ClockedRobot)
    loop, begin = RealTimeLoop(robot, controllers.create("damped-null-space", planar), 5e-3), time.perf_counter()
    run = loop.hold(0.2)
    assert time.perf_counter() - begin >= 0.2
    # Late readings do not add up: every time is a multiple of the period, however late the sample was.
    np.testing.assert_allclose(run.t / 5e-3, np.rint(run.t / 5e-3), rtol=0, atol=1e-9)
    assert len(run.t) + loop.timing.samples_lost == round(run.t[-1] / 5e-3) + 1


def test_a_tick_that_takes_longer_than_its_period_misses_its_deadline(planar):
    class Slow(controllers.Pseudoinverse):
        def command(self, state, target):
            if target.dx.any() and len(robot.written) in (10, 20):
                time.sleep(0.02)
            return super().command(state, target)

    robot = UnclockedRobot(planar, Q0, 5e-3)
    loop = RealTimeLoop(robot, Slow(planar), 5e-3)
    loop.follow(LINE)
    assert loop.timing.deadlines_missed >= 2
    assert loop.timing.samples_lost >= 6
    assert loop.timing.tick.maximum >= 0.02
    assert loop.timing.tick.p50 < 0.02


# The garbage collector


def test_no_garbage_collection_falls_into_the_motion_with_a_log_that_makes_garbage(planar):
    log, collections = [], []

    def watch(sample):
        row = {"t": sample.t, "q": sample.q.tolist(), "rows": [[k] for k in range(50)]}
        row["self"] = row  # a cycle
        log.append(row)
        assert not gc.isenabled()

    def count(phase, info):
        collections.append((phase, len(robot.written)))

    robot = PlantRobot(planar, Q0)
    loop = RealTimeLoop(robot, controllers.create("damped-null-space", planar), watch=watch)
    gc.callbacks.append(count)
    try:
        loop.follow(LINE)
    finally:
        gc.callbacks.remove(count)
    assert {written for _, written in collections if written} <= {len(robot.written)}
    assert loop.timing.collections == 0
    assert len(log) >= 400
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


def test_a_collection_that_the_user_asks_for_is_counted(planar):
    loop = RealTimeLoop(PlantRobot(planar, Q0), controllers.create("jmdc", planar), watch=lambda sample: gc.collect())
    loop.follow(ac.Hold(0.01))
    assert loop.timing.collections >= 10


def test_a_collector_that_was_off_stays_off(planar):
    gc.disable()
    gc.freeze()
    try:
        RealTimeLoop(PlantRobot(planar, Q0), controllers.create("jmdc", planar)).hold(0.01)
        assert not gc.isenabled()
        assert gc.get_freeze_count() > 0
    finally:
        gc.unfreeze()
        gc.enable()


# What it says


def test_the_loop_says_that_it_warmed_up_and_how_it_kept_its_time(planar, caplog):
    caplog.set_level("INFO")
    loop = RealTimeLoop(PlantRobot(planar, Q0), controllers.create("jmdc", planar))
    run = loop.follow(LINE)
    first, last = caplog.messages
    assert first.startswith("law warmed up in ")
    assert first.endswith("garbage collector off during the motion")
    assert last == f"{run.message}\n{loop.timing}"
    assert f"{len(run.t)} samples of 1 ms: " in last
    times = loop.timing
    assert times.tick == tuple(np.percentile(times.ticks, [50.0, 99.0, 99.9, 100.0]))
    assert len(times.periods) == len(times.ticks) - 1 == len(run.t) - 1


# What is refused


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"robot": object()}, "robot must have read"),
        ({"law": "jmdc"}, "law must be a Controller"),
        ({"dt": 0.0}, "dt must be"),
        ({"watch": 3}, "watch must be a function"),
    ],
)
def test_a_loop_of_something_else_is_refused(planar, arguments, message):
    good = {"robot": PlantRobot(planar, Q0), "law": controllers.create("jmdc", planar)}
    with pytest.raises(ParameterError, match=message):
        RealTimeLoop(**{**good, **arguments})


def test_motions_of_something_else_are_refused(planar):
    robot = PlantRobot(planar, Q0)
    loop = RealTimeLoop(robot, controllers.create("jmdc", planar))
    limits = {"speed": 1.0, "acceleration": 1.0, "jerk": 1.0}
    for call, error in (
        (lambda: loop.follow("line"), ParameterError),
        (lambda: loop.follow(ac.StraightLine([1.0, 0.0, 0.0], 1.0)), ShapeError),
        (lambda: loop.hold(-1.0), ParameterError),
        (lambda: loop.stream(3, **limits), ParameterError),
        (lambda: loop.stream([], **{**limits, "jerk": 0.0}), ParameterError),
        (lambda: loop.stream([], **{**limits, "speed": [1.0, 1.0, 1.0]}), ShapeError),
    ):
        with pytest.raises(error):
            call()
    assert robot.written == []
