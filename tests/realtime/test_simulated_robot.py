"""The simulated robot in its own process, and the loop on it, end to end."""

import os
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest

import aspect_control as ac
from aspect_control import controllers
from aspect_control.exceptions import NonFiniteError, ParameterError, RobotError, ShapeError
from aspect_control.realtime import RealTimeLoop, SimulatedRobot, SimulationProcess
from aspect_control.realtime.mujoco_chain import mjcf
from aspect_control.realtime.packets import Command, Mode, pack_command
from example_arms import FRAMES, example_arm, random_motions

READY = np.array([0.0, -np.pi / 4, 0.0, -3.0 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
PATIENT = {"watchdog": 1.0}
"""A watchdog that a machine with other work does not wake."""

ROUND = ac.Circle(0.05, duration=1.0, plane="yz")


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda")


def law_of(arm):
    return controllers.create("damped-null-space", arm, kp=400.0, kv=40.0)


def states(robot, seconds):
    """What the robot says of itself for some of its seconds."""
    found, end = [], None
    while end is None or robot.time < end:
        robot.read()
        end = robot.time + seconds if end is None else end
        found.append(robot.state)
    return found


def is_alive(pid):
    try:
        if sys.platform != "linux":
            return os.kill(pid, 0) is None
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def wait_for(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


# The model


@pytest.mark.parametrize("robot", [name for name in FRAMES if name != "human"])
def test_the_chain_in_mujoco_is_the_chain_of_the_arm(robot):
    arm = example_arm(robot)
    nothing = np.zeros(arm.nv)
    model = mujoco.MjModel.from_xml_string(mjcf(arm, dt=1e-3, friction=nothing, damping=nothing))
    data, M = mujoco.MjData(model), np.zeros((arm.nv, arm.nv))
    for q, v in random_motions(arm, 5, seed=21):
        data.qpos, data.qvel = arm.positions(q), v
        mujoco.mj_forward(model, data)
        for column, unit in zip(M, np.eye(arm.nv), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        state = arm.state(q, v)
        scale = 1.0 + np.abs(state.M).max()
        # Moments that are zero are raised to SMALLEST_INERTIA of the largest, and to what MuJoCo needs.
        np.testing.assert_allclose(M, state.M, rtol=0, atol=1e-5 * scale)
        np.testing.assert_allclose(data.qfrc_bias, state.nle, rtol=0, atol=1e-4 * (1.0 + np.abs(state.nle).max()))


# End to end


def test_a_motion_is_recorded_replayed_and_analysed(panda, tmp_path):
    with SimulationProcess(panda, READY, **PATIENT) as simulation, simulation.connect() as robot:
        loop = RealTimeLoop(robot, law_of(panda))
        run = loop.follow(ROUND)
        assert run.status == "finished", run.message
        assert (run.info.plant, run.info.dt) == ("SimulatedRobot", 1e-3)
        # Friction, a sample of delay and a clock that this process does not have: it moves, and it arrives.
        assert np.linalg.norm(np.ptp(run.x, axis=0)) > 0.09
        assert run.tracking_error.max() < 0.02
        assert len(run.t) + loop.timing.samples_lost == round(run.t[-1] / 1e-3) + 1
        assert loop.timing.collections == 0
        run.save(tmp_path / "run.npz")
        assert ac.Run.load(tmp_path / "run.npz") == run
        # Its brakes hold it from then on.
        assert max(np.abs(state.v).max() for state in states(robot, 0.1)) < 0.02
        assert robot.mode is Mode.WAITING
    assert not is_alive(simulation.pid)


def test_a_stream_and_a_hold_follow_one_another(panda):
    x0 = panda.task_position(READY)
    with SimulationProcess(panda, READY, **PATIENT) as simulation, simulation.connect() as robot:
        loop = RealTimeLoop(robot, law_of(panda))
        goals = {20: x0 + np.array([0.0, 0.03, 0.0]), 150: x0 + np.array([0.0, 0.0, 0.03])}
        run = loop.stream((goals.get(k) for k in range(200)), speed=0.3, acceleration=2.0, jerk=30.0)
        assert run.status == "finished", run.message
        time.sleep(PATIENT["watchdog"] + 0.2)
        held = loop.hold(0.1)
        assert held.status == "finished", held.message
        assert np.linalg.norm(held.x[-1] - goals[150]) < 0.01


def test_the_arm_stays_where_it_is_until_the_first_command(panda):
    with SimulationProcess(panda, READY) as simulation, simulation.connect() as robot:
        found = states(robot, 0.2)
    assert {state.mode for state in found} == {Mode.WAITING}
    assert max(np.abs(state.positions - READY).max() for state in found) < 1e-6


def test_torques_saturate_at_what_the_motors_give(panda):
    with SimulationProcess(panda, READY, **PATIENT) as simulation, simulation.connect() as robot:
        robot.read()
        robot.write(np.full(7, 1e4))
        found = states(robot, 0.01)
    driven = [state for state in found if state.mode is Mode.DRIVEN]
    np.testing.assert_array_equal(driven[-1].tau, panda.torque_limit)


def test_dry_friction_holds_a_joint_against_a_small_torque(panda):
    gravity = panda.state(READY, np.zeros(7)).nle
    moved = []
    for friction in (0.0, 3.0):
        simulation = SimulationProcess(panda, READY, friction=friction, damping=0.0, watchdog=5.0)
        with simulation, simulation.connect() as robot:
            robot.read()
            robot.write(gravity + 1.0)
            moved.append(np.abs(states(robot, 0.1)[-1].v).max())
    assert moved[0] > 0.3
    assert moved[1] < 0.02


def test_the_example_writes_the_page_of_what_it_measured(tmp_path):
    example, page = Path(__file__).parents[2] / "examples" / "realtime_loop.py", tmp_path / "page.md"
    command = [sys.executable, str(example), "--duration", "0.3", "--table", str(page), "--out", str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for words in ("| scheduler | time | p50 | p99 | p99.9 | longest |", "| default | tick |", "| default | period |"):
        assert words in page.read_text(encoding="utf-8")
    assert ac.Run.load(tmp_path / "run-default.npz").info.dt == 1e-3


# The watchdog


CHILD = """
import sys
import numpy as np
import aspect_control as ac
from aspect_control.realtime import SimulatedRobot
arm = ac.Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
law = ac.controllers.create("damped-null-space", arm, kp=400.0, kv=40.0)
robot = SimulatedRobot(arm, int(sys.argv[1]))
ac.RealTimeLoop(robot, law).follow(ac.Circle(0.1, duration=10.0, plane="yz", turns=15))
"""


def test_killing_the_loop_in_the_middle_brings_the_arm_to_a_stop(panda):
    with SimulationProcess(panda, READY, watchdog=0.3) as simulation, simulation.connect() as observer:
        child = subprocess.Popen([sys.executable, "-c", CHILD, str(simulation.port)])
        try:
            wait_for(lambda: observer.read() and np.abs(observer.state.v).max() > 0.5)
        finally:
            child.send_signal(signal.SIGKILL)
            child.wait()
        found = states(observer, 1.5)
        braking = [state for state in found if state.mode is Mode.BRAKING]
        first, second = braking[0], next(state for state in braking if state.time >= braking[0].time + 0.5)
        after = [state for state in braking if state.time >= second.time]
        assert first.time - found[0].time <= 0.4
        # It slows down within half a second, and then it stays.
        assert max(np.abs(state.v).max() for state in after) < 1e-3
        assert max(np.abs(state.positions - second.positions).max() for state in after) < 1e-3
        # Only a new client moves it again.
        with simulation.connect() as robot:
            assert RealTimeLoop(robot, law_of(panda)).hold(0.05).status == "finished"


def test_a_client_that_paused_for_too_long_is_told_and_no_longer_obeyed(panda):
    with SimulationProcess(panda, READY, watchdog=0.02) as simulation, simulation.connect() as robot:
        robot.read()
        robot.write(panda.state(READY, np.zeros(7)).nle)
        with pytest.raises(RobotError, match="its watchdog brakes it"):
            states(robot, 0.2)
        robot.write(np.full(7, 50.0))
        with simulation.connect() as observer:
            assert max(np.abs(state.v).max() for state in states(observer, 0.1)) < 1e-3


# What it does not listen to


def test_nobody_else_moves_an_arm_that_is_driven(panda):
    gravity = panda.state(READY, np.zeros(7)).nle
    with SimulationProcess(panda, READY, watchdog=5.0) as simulation, simulation.connect() as robot:
        robot.read()
        robot.write(gravity)
        states(robot, 0.02)
        with simulation.connect() as other, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            other.write(np.full(7, 20.0))
            forged = Command(robot.state.session, 1000, np.full(7, 20.0))
            good = pack_command(Command(12345, 1, np.full(7, 20.0)))
            broken = [
                b"",
                b"x" * 2000,
                good[:-1],
                good + b"0",
                b"ACTQ" + os.urandom(68),
                struct.pack("<72s", good[:20]),
            ]
            for packet in (pack_command(forged), good, *broken, *[good[:-1]] * 2000):
                stranger.sendto(packet, ("127.0.0.1", simulation.port))
            found = states(robot, 0.1)
            assert max(np.abs(state.v).max() for state in found) < 1e-3
            with pytest.raises(RobotError, match="another client drives it"):
                states(other, 0.02)
        # An old command that comes late is none.
        robot._send(robot._sequence - 1, np.full(7, 20.0))
        assert max(np.abs(state.v).max() for state in states(robot, 0.05)) < 1e-3


@pytest.mark.skipif(sys.platform != "linux", reason="says where sockets listen in a file")
def test_the_simulation_listens_on_the_loopback_interface_only(panda):
    with SimulationProcess(panda, READY) as simulation:
        bound = [line.split()[1] for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
    assert [each for each in bound if each.endswith(f":{simulation.port:04X}")] == [f"0100007F:{simulation.port:04X}"]


# Its end


PARENT = """
import time
import aspect_control as ac
from aspect_control.realtime import SimulationProcess
arm = ac.Arm.from_example("planar3r", frame="tool", task="xy")
with SimulationProcess(arm, [-0.9, 2.4, -2.4]) as simulation:
    print(simulation.pid, flush=True)
    time.sleep(60)
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_nothing_is_left_behind_when_the_process_that_started_it_is_killed(number):
    with subprocess.Popen(
        [sys.executable, "-c", PARENT], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as parent:
        pid = int(parent.stdout.readline())
        assert is_alive(pid)
        parent.send_signal(number)
    wait_for(lambda: not is_alive(pid))


def test_a_loop_whose_robot_is_gone_ends_as_failed(panda):
    with SimulationProcess(panda, READY, **PATIENT) as simulation, simulation.connect() as robot:

        def watch(sample):
            if sample.t > 0.1:
                os.kill(simulation.pid, signal.SIGKILL)

        run = RealTimeLoop(robot, law_of(panda), watch=watch).follow(ROUND)
    assert run.status == "failed"
    assert isinstance(run.error, RobotError)
    assert "the simulated robot" in run.message
    assert len(run.t) > 5


def test_an_arm_that_diverges_ends_the_simulation(panda, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def shake(robot):
        for _ in range(200):
            robot.read()
            robot.write(panda.torque_limit * (-1.0) ** np.arange(7))

    simulation = SimulationProcess(panda, READY, dt=0.1, friction=0.0, damping=0.0, watchdog=60.0)
    with simulation, simulation.connect() as robot, pytest.raises(RobotError, match="the simulated robot"):
        shake(robot)
    assert list(tmp_path.iterdir()) == []


# What is refused


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"q0": [0.0]}, ShapeError),
        ({"q0": np.full(7, np.nan)}, NonFiniteError),
        ({"friction": -1.0}, ParameterError),
        ({"friction": [1.0, 2.0]}, ShapeError),
        ({"damping": "much"}, ShapeError),
        ({"watchdog": 0.0}, ParameterError),
        ({"dt": -1.0}, ParameterError),
    ],
)
def test_a_simulation_that_cannot_be_is_refused(panda, arguments, error):
    with pytest.raises(error):
        SimulationProcess(panda, **{"q0": READY, **arguments})


def test_torques_that_are_none_are_not_sent(panda):
    with SimulationProcess(panda, READY) as simulation, simulation.connect() as robot:
        for tau, error in (([0.0], ShapeError), (np.full(7, np.nan), NonFiniteError)):
            with pytest.raises(error):
                robot.write(tau)
        assert {state.mode for state in states(robot, 0.02)} == {Mode.WAITING}


def test_a_robot_that_is_not_there_is_an_error(panda):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as nobody:
        nobody.bind(("127.0.0.1", 0))
        port = nobody.getsockname()[1]
    with SimulatedRobot(panda, port) as robot, pytest.raises(RobotError, match="gone"):
        robot.read()
