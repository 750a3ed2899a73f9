"""Replays without a browser: what goes into the page, the live server, and bad input."""

import asyncio
import base64
import gzip
import json
import re
import signal
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import umsgpack
from tornado.websocket import websocket_connect

import aspect_control as ac
from aspect_control import views
from aspect_control.arm.sources.examples import find_example
from aspect_control.exceptions import (
    DrawingWarning,
    NonFiniteError,
    OutputError,
    ParameterError,
    UnknownNameError,
)
from aspect_control.trajectories import Hold, StraightLine
from aspect_control.views.replays.scene.command_recorder import CommandRecorder
from aspect_control.views.replays.scene.robot import Robot, joint_poses
from example_arms import example_arm

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
START = np.deg2rad([-50.0, 140.0, -140.0])
MEGABYTE = 1e6


@pytest.fixture(scope="module")
def run(planar):
    line = StraightLine(displacement=[1.5, 1.0], duration=2.0, profile="bang-bang")
    return ac.simulate(ac.controllers.create("jmdc", planar), line, q0=START, dt=4e-3)


def data_of(page):
    return json.loads(re.search(r'id="replay-data">(.*?)</script>', page, re.DOTALL)[1])


def commands_of(page):
    packed = gzip.decompress(base64.b64decode(re.search(r'id="replay-commands">(.*?)</script>', page)[1]))
    ends = np.cumsum(data_of(page)["lengths"])
    return [umsgpack.unpackb(packed[start:end]) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def objects_of(page):
    return [command for command in commands_of(page) if command["type"] == "set_object"]


def test_a_planar_replay_is_small_and_has_thirty_frames_a_second(run, planar):
    page = views.replay(run).page
    (shown,) = data_of(page)["runs"]
    assert len(page) < 5 * MEGABYTE
    assert len(shown["samples"]) == 61
    finer = ac.simulate(
        ac.controllers.create("jmdc", planar),
        StraightLine(displacement=[1.5, 1.0], duration=2.0, profile="bang-bang"),
        q0=START,
        dt=5e-4,
    )
    assert len(data_of(views.replay(finer).page)["runs"][0]["samples"]) == 61
    assert len(data_of(views.replay(run, speed=0.25).page)["runs"][0]["samples"]) == 241


def test_the_animation_holds_the_joint_frames_of_forward_kinematics(run):
    page = views.replay(run).page
    (animation,) = [command for command in commands_of(page) if command["type"] == "set_animation"]
    samples = np.searchsorted(run.t, [sample["t"] for sample in data_of(page)["runs"][0]["samples"]])
    poses = joint_poses(run.arm, run.q[samples])
    assert len(animation["animations"]) == run.arm.nv
    for joint, clip in enumerate(animation["animations"]):
        assert clip["path"] == f"/meshcat/run0/robot/joint{joint + 1}"
        tracks = {track["name"]: [key["value"] for key in track["keys"]] for track in clip["clip"]["tracks"]}
        np.testing.assert_array_equal(tracks[".position"][:-1], poses[:, joint, :3])
        np.testing.assert_array_equal(tracks[".quaternion"][:-1], poses[:, joint, 3:])
        assert tracks[".position"][-1] == tracks[".position"][-2]
    tips = [sample["tip"][:2] for sample in data_of(page)["runs"][0]["samples"]]
    np.testing.assert_allclose(tips, run.x[samples], atol=1e-5)


def test_runs_of_one_arm_share_their_meshes_and_runs_of_two_arms_do_not(run):
    alone, twice = views.replay(run).page, views.replay([run, run]).page
    assert len(objects_of(alone)) == len(objects_of(twice))
    assert data_of(twice)["copies"] == [["/meshcat/run0/robot", "/meshcat/run1/robot"]]
    ur5 = example_arm("ur5")
    other = ac.simulate(ac.controllers.create("pseudoinverse", ur5), Hold(0.1), q0=[0, -1, 1, 0.3, 0.4, 0], dt=1e-2)
    both = views.replay([run, other]).page
    assert data_of(both)["copies"] == []
    assert {command["path"].split("/")[2] for command in objects_of(both)} == {"run0", "run1"}


@pytest.mark.parametrize("robot", ["panda", "xarm7", "talos", "ur5"])
def test_robots_are_drawn_with_their_own_meshes(robot):
    robot_drawing = Robot(example_arm(robot))
    recorder = CommandRecorder()
    assert robot_drawing.draw(recorder.visualizer()["robot"]) is None
    drawn = [umsgpack.unpackb(command) for command in recorder.commands]
    objects = [command["object"] for command in drawn if command["type"] == "set_object"]
    assert len(objects) == len(robot_drawing.geometry.geometryObjects)
    meshes = [part for each in objects for part in (*each["geometries"], each["object"]) if "_meshfile" in part["type"]]
    assert len(meshes) >= 7


def test_a_robot_whose_meshes_are_gone_is_a_stick_figure_and_says_so(tmp_path):
    path = find_example("panda").path
    arm = ac.Arm.from_urdf(path, frame="panda_hand_tcp", task="xyz", package_dirs=[tmp_path])
    law = ac.controllers.create("pseudoinverse", arm)
    run = ac.simulate(law, Hold(0.05), q0=[0.1, -0.5, 0.2, -2.0, 0.1, 1.6, 0.7], dt=1e-2)
    with pytest.warns(DrawingWarning, match=r"link0\.dae could not be found.*stick figure"):
        page = views.replay(run)
    paths = {command["path"].split("/")[4] for command in objects_of(page.page)}
    assert {f"joint{joint}" for joint in range(1, 8)} <= paths
    assert "stick figure" in page.notes[0]


def test_a_run_that_is_not_finite_to_its_end_is_clipped_and_marked(run):
    broken = replace(run, q=np.where(run.t[:, None] > 1.0, np.nan, run.q))
    (shown,) = data_of(views.replay(broken).page)["runs"]
    assert shown["samples"][-1]["t"] == pytest.approx(1.0, abs=5e-3)
    assert shown["end"] == "not finite after t = 1 s"
    diverged = replace(run, info=replace(run.info, status="diverged", message="diverged at t = 2 s: too fast"))
    assert data_of(views.replay(diverged).page)["runs"][0]["end"] == "diverged at t = 2 s: too fast"
    assert data_of(views.replay(run).page)["runs"][0]["end"] is None


def test_labels_cannot_break_out_of_the_page(run):
    label = "</script><script>alert(1)</script>{{commands}}"
    page = views.replay({label: run}).page
    assert page.count("<script") == views.replay(run).page.count("<script")
    assert data_of(page)["runs"][0]["label"] == label
    assert len(commands_of(page)) > 0


def test_a_notebook_shows_the_page_in_a_frame(run):
    shown = views.replay(run)._repr_html_()
    assert shown.startswith("<iframe srcdoc=")
    assert "&lt;!DOCTYPE html&gt;" in shown


@pytest.mark.parametrize(
    ("runs", "message"),
    [([], "no runs"), (["run.npz"], r"expected a Run, got 'run.npz'; Run\.load"), (7, "expected a Run")],
)
def test_what_is_no_run_is_refused(runs, message):
    with pytest.raises(ParameterError, match=message):
        views.replay(runs)


def test_empty_runs_bad_speeds_and_bad_paths_are_refused(run, tmp_path):
    empty = replace(run, **{name: getattr(run, name)[:0] for name in ("t", "q", "v", "tau")})
    with pytest.raises(ParameterError, match="no samples"):
        views.replay(empty)
    with pytest.raises(NonFiniteError, match="first sample"):
        views.replay(replace(run, q=run.q * np.nan))
    with pytest.raises(ParameterError, match="speed"):
        views.replay(run, speed=0.0)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        views.replay(run, tmp_path / "file" / "replay.html")


def command(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False)


def test_the_command_writes_one_page_of_several_runs(run, tmp_path):
    run.save(tmp_path / "one.npz")
    done = command("replay", tmp_path / "one.npz", tmp_path / "one.npz", "--out", tmp_path / "two.html", "--speed", 0.5)
    assert (done.returncode, done.stderr) == (0, "")
    assert "open it in a browser" in done.stdout
    data = data_of((tmp_path / "two.html").read_text())
    assert [shown["label"] for shown in data["runs"]] == ["JMDC (1)", "JMDC (2)"]
    assert data["speed"] == 0.5


def test_the_command_refuses_what_is_no_run_in_one_line(tmp_path):
    (tmp_path / "no.npz").write_text("no run")
    for file, message in (("no.npz", "is not a recorded run"), ("missing.npz", "missing.npz")):
        done = command("replay", tmp_path / file, "--out", tmp_path / "x.html")
        assert done.returncode == 2
        assert len(done.stderr.splitlines()) == 1
        assert message in done.stderr
    assert not (tmp_path / "x.html").exists()


def test_a_taken_port_leads_to_the_next_one_and_the_command_says_which(run, tmp_path):
    run.save(tmp_path / "run.npz")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        live = subprocess.Popen(
            [COMMAND, "replay", str(tmp_path / "run.npz"), "--live", "--port", str(port)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # A test run in the background of a shell hands an ignored SIGINT down.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        said = live.stdout.readline()
        live.send_signal(signal.SIGINT)
        rest, complaints = live.communicate(timeout=30)
    assert said.startswith(f"port {port} is taken; open http://127.0.0.1:")
    assert int(re.search(r":(\d+)/", said)[1]) > port
    assert (live.returncode, rest, complaints) == (0, "stopped\n", "")


def messages_of(view, count):
    async def listen():
        stream = await websocket_connect(view.url.replace("http", "ws") + "stream")
        messages = [json.loads(await stream.read_message()) for _ in range(count)]
        stream.close()
        while await stream.read_message() is not None:
            pass
        return messages

    return asyncio.run(asyncio.wait_for(listen(), 20.0))


def test_a_live_replay_sends_the_frames_of_a_replay_and_late_viewers_get_all_of_them(run, monkeypatch):
    monkeypatch.setattr("aspect_control.views.replays.live_replay.PAUSE", 0.0)
    ended = replace(run, info=replace(run.info, status="diverged", message="diverged"))
    with views.LiveReplay(ended, speed=20.0, port=0) as view:
        assert not view.wait_for_viewer(0.1)
        view.play()
        first, *frames, last = messages_of(view, 6)
    assert first == {"restart": True}
    assert [frame["t"] for frame in frames] == pytest.approx([0.0, 0.664, 1.332, 2.0])
    samples = np.searchsorted(run.t, [frame["t"] - 1e-9 for frame in frames])
    np.testing.assert_allclose([frame["poses"] for frame in frames], joint_poses(run.arm, run.q[samples]), atol=1e-6)
    assert last == {"run": 0, "end": "diverged"}


def test_a_live_view_reports_changes_of_the_aspect_as_they_are_simulated(planar):
    line = StraightLine(displacement=[1.5, 1.0], duration=1.2, profile="bang-bang")
    law = ac.controllers.create("null-space-vector", planar)
    with views.LiveView(planar, ["null-space-vector"], START, line, speed=1e3, port=0) as view:
        recorded = ac.simulate(law, line, q0=START, watch=view.watch("null-space-vector"))
        with pytest.raises(UnknownNameError, match="null-space-vector"):
            view.watch("jmdc")
        late = messages_of(view, 2)
    assert late[0]["torque"] == [0.0, 0.0, 0.0]
    assert late[1]["t"] == 0.0
    np.testing.assert_allclose(late[1]["torque"], np.abs(recorded.tau[0]), rtol=1e-3)


def test_watching_changes_nothing_and_sees_every_sample(planar, run):
    seen = []
    law = ac.controllers.create("jmdc", planar)
    line = StraightLine(displacement=[1.5, 1.0], duration=2.0, profile="bang-bang")
    watched = ac.simulate(law, line, q0=START, dt=4e-3, watch=seen.append)
    assert watched == run
    np.testing.assert_array_equal([moment.q for moment in seen], run.q)


@pytest.mark.parametrize(
    ("place", "error", "message"),
    [
        ({"host": " "}, ParameterError, "host must be an address such as 127.0.0.1"),
        ({"port": 70000}, ParameterError, "port must be 0 to 65535, got 70000"),
        ({"host": "host.invalid"}, OutputError, "cannot listen on host.invalid, port 7000"),
    ],
)
def test_addresses_that_cannot_be_listened_on_are_refused(run, place, error, message):
    with pytest.raises(error, match=message):
        views.LiveReplay(run, **place)
