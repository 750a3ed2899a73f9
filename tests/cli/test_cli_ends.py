"""How the command line ends: bad input, a device that is full, a reader that has gone, Ctrl-C at any time."""

import dataclasses
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.resources import model_path

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
posix = pytest.mark.skipif(sys.platform == "win32", reason="devices and signals of POSIX")


def run(*arguments, **options):
    return subprocess.run(
        [COMMAND, *map(str, arguments)], **({"capture_output": True, "text": True, "check": False} | options)
    )


def assert_one_line_and_status_2(done, words):
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("aspect-control: error: ")
    assert words in done.stderr


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    arm = ac.Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0, 0, 0))
    law, line = ac.controllers.create("pseudoinverse", arm), ac.StraightLine([0.1, 0.1], 0.2)
    path = tmp_path_factory.mktemp("recorded") / "run.npz"
    ac.simulate(law, line, q0=(0.1, 0.5, 0.7), dt=0.05).save(path)
    return path


@pytest.mark.parametrize("speed", ["1e-300", "5e-324", "1e-9"])
def test_a_replay_of_more_frames_than_can_be_shown_is_refused(recorded, tmp_path, speed):
    done = run("replay", recorded, "--speed", speed, cwd=tmp_path)
    assert_one_line_and_status_2(done, "frames; at most 1,000,000 can be shown")
    assert list(tmp_path.iterdir()) == []


def test_a_replay_of_any_great_speed_is_shown(recorded, tmp_path):
    assert run("replay", recorded, "--speed", "1e300", cwd=tmp_path).returncode == 0


def test_a_run_whose_time_runs_backwards_is_refused(recorded, tmp_path):
    turned = ac.Run.load(recorded)
    dataclasses.replace(turned, t=np.ascontiguousarray(turned.t[::-1])).save(tmp_path / "turned.npz")
    done = run("replay", "turned.npz", cwd=tmp_path)
    assert_one_line_and_status_2(done, "turned.npz is damaged: t must increase from sample to sample")


@pytest.mark.parametrize("gain", ["1e300", "1" + "0" * 400, "nan"])
def test_a_gain_that_no_arm_needs_is_refused_and_nothing_is_written(tmp_path, gain):
    done = run("run", "planar3r", "--set", f"controller.kp={gain}", cwd=tmp_path)
    assert_one_line_and_status_2(done, "kp must be ")
    assert list(tmp_path.iterdir()) == []


def test_a_scenario_that_is_nested_20000_deep_is_refused(tmp_path):
    (tmp_path / "deep.toml").write_text(f"a = {'[' * 20_000}{']' * 20_000}")
    assert_one_line_and_status_2(run("run", "deep.toml", cwd=tmp_path), "deep.toml is not valid TOML")


@posix
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "planar3r", "--out", "/dev/full"], "cannot write to folder /dev/full"),
        (["replay", "{run}", "--out", "/dev/full"], "cannot write /dev/full: it is no file that could be replaced"),
        (["run", "\udc80.toml"], "the path of a scenario must be text"),
        (["replay", "\udc80.npz"], "cannot read run"),
    ],
)
def test_a_file_that_cannot_be_had_is_one_line(recorded, tmp_path, arguments, words):
    done = run(*[argument.format(run=recorded) for argument in arguments], cwd=tmp_path)
    assert_one_line_and_status_2(done, words)


@posix
@pytest.mark.parametrize("arguments", [["criteria"], ["--help"]])
def test_a_full_device_as_standard_output_is_one_line(arguments):
    with Path("/dev/full").open("w") as full:
        done = run(*arguments, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert_one_line_and_status_2(done, "No space left on device")


@posix
def test_a_full_device_as_standard_error_does_not_change_the_status():
    with Path("/dev/full").open("w") as full:
        done = run("replay", "missing.npz", capture_output=False, stdout=subprocess.PIPE, stderr=full)
    assert (done.returncode, done.stdout) == (2, "")


def test_a_full_disk_is_one_line_and_leaves_nothing_half_written(recorded, tmp_path):
    """The limit on the size of a file stands in for a small disk."""
    resource = pytest.importorskip("resource")

    def small():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

    done = run("replay", recorded, "--out", tmp_path / "page.html", preexec_fn=small)
    assert_one_line_and_status_2(done, "page.html: File too large")
    assert list(tmp_path.iterdir()) == []


@posix
def test_a_reader_that_has_gone_needs_no_word():
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = run("criteria", capture_output=False, stdout=writing, stderr=subprocess.PIPE)
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (1, "")


INTERRUPTED_IMPORT = """
import signal, sys

module, way = sys.argv[1:3]


class Dying:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)


class Interruption:
    def find_spec(self, name, path=None, target=None):
        if name == module:
            sys.meta_path.remove(self)
            if way == "raised":
                signal.raise_signal(signal.SIGINT)
            elif way == "in a finaliser":
                Dying()
            else:
                try:
                    signal.raise_signal(signal.SIGINT)
                except KeyboardInterrupt as interruption:
                    raise RuntimeError("as pydantic does") from interruption


sys.meta_path.insert(0, Interruption())
sys.argv = ["aspect-control", *sys.argv[3:]]
from aspect_control.cli import main
main()
"""


@posix
@pytest.mark.parametrize("way", ["raised", "in a finaliser", "as another error"])
@pytest.mark.parametrize("module", ["typer", "numpy", "pinocchio", "pydantic", "matplotlib", "aspect_control.arm"])
def test_ctrl_c_while_something_is_imported_ends_with_status_130(tmp_path, module, way):
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED_IMPORT, module, way, "run", "planar3r", "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "aspect-control: interrupted; what was written stays\n"
    assert not (tmp_path / "out").exists()


def test_nothing_that_takes_time_is_imported_before_the_command_line_can_answer():
    code = "import sys; from aspect_control.cli import main; print(*sys.modules)"
    loaded = {name.split(".")[0] for name in subprocess.check_output([sys.executable, "-c", code], text=True).split()}
    assert not loaded & {"numpy", "pinocchio", "typer", "rich", "pydantic", "matplotlib"}
