"""The commands about scenarios, laws and robots, as a user's shell runs them."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import aspect_control as ac
from aspect_control import controllers, criteria, plants, trajectories
from aspect_control.arm.sources.examples import end_frames, example_names, example_overview, load_example_model
from aspect_control.resources import scenario_paths
from aspect_control.simulation import events, integrators

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
WIDE = {**os.environ, "COLUMNS": "3000"}
TWO_LAWS = 'controllers=[{name = "pseudoinverse", kp = 120}, {name = "null-space-vector", label = "explodes.1"}]'
REGISTERED = {
    "controllers": controllers,
    "criteria": criteria,
    "trajectories": trajectories,
    "events": events,
    "integrators": integrators,
    "plants": plants,
}
READY = f"start.positions={[0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4]}"


posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


def run(*arguments, **options):
    return subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False, **options)


def files_of(*labels):
    figures = {f"{label}.{suffix}" for label in (*labels, "comparison") for suffix in ("png", "svg")}
    return figures | {f"{label}.npz" for label in labels} | {"summary.json", "replay.html"}


@pytest.fixture(scope="module")
def two_laws(tmp_path_factory):
    """A shipped scenario with two laws of its own, of which the second ends early."""
    folder = tmp_path_factory.mktemp("run") / "a" / "b"
    settings = [TWO_LAWS, "simulation.dt=0.02", "limits.torque=100"]
    done = run("run", "planar3r", "--out", folder, *(part for each in settings for part in ("--set", each)))
    assert done.returncode == 0, done.stderr
    return folder, done


# run


def test_run_writes_exactly_the_files_it_promises(two_laws):
    folder, _ = two_laws
    assert {path.name for path in folder.iterdir()} == files_of("pseudoinverse", "explodes.1")
    assert all(path.stat().st_size > 1000 for path in folder.iterdir())


def test_run_warns_in_a_line_a_law_that_the_aspect_will_be_left(two_laws):
    _, done = two_laws
    lines = done.stderr.splitlines()
    assert [line.split()[2] for line in lines] == ["pseudoinverse", "explodes.1"]
    for line in lines:
        assert re.fullmatch(
            r"aspect-control: warning: \S+ leaves its aspect at t = \d\.\d\d s, where minor 3 \(joint1, joint3\) "
            "changes sign, by a coarse prediction",
            line,
        )


def test_run_prints_a_row_a_law(two_laws):
    _, done = two_laws
    rows = re.findall(r"^(\S+) +([\d,.]+) N m .* (finished|torque limit) *$", done.stdout, re.MULTILINE)
    assert [(label, status) for label, _, status in rows] == [
        ("pseudoinverse", "finished"),
        ("explodes.1", "torque limit"),
    ]


def test_run_prints_why_a_law_ended_early_and_only_of_that(two_laws):
    folder, done = two_laws
    on_one_line = " ".join(done.stdout.split())
    message = ac.Run.load(folder / "explodes.1.npz").message
    assert re.fullmatch(r"torque limit at t = \S+ s: \S+ N m at joint 'joint\d', limit 100 N m", message)
    assert f"explodes.1: {message}" in on_one_line
    assert "pseudoinverse: " not in on_one_line


def test_recorded_runs_have_the_settings_of_the_command(two_laws):
    folder, _ = two_laws
    first, second = (ac.Run.load(folder / f"{label}.npz") for label in ("pseudoinverse", "explodes.1"))
    assert (first.info.controller, second.info.controller) == ("pseudoinverse", "null-space-vector")
    assert (first.info.parameters["kp"], second.info.parameters["kp"]) == (120.0, 100.0)
    assert first.info.dt == second.info.dt == 0.02
    assert (first.status, second.status) == ("finished", "torque limit")
    assert len(first.t) == 101 > len(second.t)


def test_summary_is_strict_json_of_the_runs_by_their_labels(two_laws):
    folder, _ = two_laws
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert summary["scenario"] == "planar3r"
    assert list(summary["controllers"]) == ["pseudoinverse", "explodes.1"]
    for label, values in summary["controllers"].items():
        recorded = ac.Run.load(folder / f"{label}.npz")
        assert values["peak_torque"] == np.abs(recorded.tau).max(axis=0).tolist()
        assert (values["status"], values["message"]) == (recorded.status, recorded.message)


def test_start_on_a_border_is_a_warning_of_one_line_that_names_minors_and_joints(tmp_path):
    settings = ("simulation.dt=0.02", "trajectory.duration=0.1", "trajectory.displacement=[0.002, 0, 0]", READY)
    law = ("--set", 'controllers=[{name = "jmdc"}]')
    out = ("--out", tmp_path / "out")
    done = run("run", "panda-xyz", *out, *law, *(part for each in settings for part in ("--set", each)))
    assert done.returncode == 0, done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("aspect-control: warning: the motion starts on the border of an aspect: ")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["controllers"]["jmdc"]
    on_border = summary["minors_on_border_at_start"]
    assert f"{len(on_border)} of {summary['minors']} minors" in done.stderr
    named = re.findall(r"(\d+) \((panda_joint\d), (panda_joint\d), (panda_joint\d)\)", done.stderr)
    assert [int(number) for number, *_ in named] == on_border
    assert {path.name for path in (tmp_path / "out").iterdir()} == files_of("jmdc")


def test_where_a_path_leaves_the_workspace_is_the_first_line_of_standard_error(tmp_path):
    settings = ("simulation.dt=0.02", "trajectory.displacement=[3, 0]", 'controllers=[{name = "damped-null-space"}]')
    done = run("run", "planar3r", "--out", tmp_path / "out", *(part for each in settings for part in ("--set", each)))
    assert done.returncode == 0, done.stderr
    first = done.stderr.splitlines()[0]
    # The start is at (1.286, -0.532): its height is kept, and 3 m from the first joint is where the arm ends.
    assert re.fullmatch(
        r"aspect-control: warning: the path leaves the workspace at t = \S+ s, 55.6 % along it, at \(2.952, -0.5321\); "
        r"at the worst it is 1.32 m beyond what 'planar3r' can reach",
        first,
    )
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["controllers"]
    assert summary["damped-null-space"]["status"] == "workspace left"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["planar3"], "no such scenario file: planar3; did you mean 'planar3r'"),
        (["planar3r", "--set", "simulation.dt"], "a setting must be field=value"),
        (["planar3r", "--set", "simulation.td=1"], "unknown field 'simulation.td'"),
        (["planar3r", "--set", "simulation.dt=5"], "dt must not be longer than the motion of 2 s"),
        (["planar3r", "--set", "controller.jmdc.kapa=1"], "unknown parameter 'kapa' in 'jmdc': did you mean 'kappa'"),
        (["planar3r", "--set", "start.degrees=[1, 2]"], "must have shape (3,), got (2,)"),
        (["bad.toml"], "bad.toml is not valid TOML"),
        (["planar3r", "--out", "file/below"], "cannot write to folder file/below"),
        ([], "Missing argument 'scenario'"),
    ],
)
def test_bad_input_is_one_line_on_stderr_and_status_2_and_writes_nothing(tmp_path, arguments, words):
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "bad.toml").write_text("[robot")
    done = run("run", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("aspect-control: error: ")
    assert words in done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stdout == ""
    assert {path.name for path in tmp_path.rglob("*") if path.is_file()} == {"file", "bad.toml"}


def test_run_that_fails_in_its_second_law_keeps_the_first(tmp_path):
    # The arm stands in an obstacle, which only the criterion of JMDC minds.
    obstacle = "{name='potential', spheres=[{centre=[0.0, 0.0, 0.0], radius=0.5}]}"
    criterion = f"controller.jmdc.criterion={obstacle}"
    done = run("run", "planar3r", "--set", "simulation.dt=0.02", "--set", criterion, cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert re.fullmatch(
        "aspect-control: error: 'potential' is not defined at the start: .*", done.stderr.splitlines()[-1]
    )
    kept = sorted(path.name for path in (tmp_path / "results" / "planar3r").iterdir())
    assert "pseudoinverse.npz" in kept
    assert "jmdc.npz" not in kept
    assert ac.Run.load(tmp_path / "results" / "planar3r" / "pseudoinverse.npz").status == "finished"


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """A run that gets a SIGINT while its second law is under way."""
    folder = tmp_path_factory.mktemp("interrupted")
    process = subprocess.Popen(
        [COMMAND, "run", "planar3r", "--out", str(folder), "--set", "simulation.dt=2e-5"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A shell's background job would hand an ignored SIGINT down.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        patience = time.monotonic() + 60.0
        while not (folder / "pseudoinverse.npz").exists() and process.poll() is None and time.monotonic() < patience:
            time.sleep(0.01)
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=60.0)
    finally:
        process.kill()
    return folder, subprocess.CompletedProcess(process.args, process.returncode, stdout, stderr)


@posix
def test_interrupted_run_keeps_the_law_that_is_done_and_the_one_under_way_and_nothing_half_written(interrupted):
    folder, _ = interrupted
    assert {path.name for path in folder.iterdir()} == {"pseudoinverse.npz", "null-space-vector.npz", "summary.json"}
    done, last = (ac.Run.load(folder / f"{law}.npz") for law in ("pseudoinverse", "null-space-vector"))
    assert (done.status, len(done.t)) == ("finished", 100001)
    assert last.status == "interrupted"
    assert last.message == f"interrupted at t = {last.t[-1]:.6g} s: by the user"
    assert 1 <= len(last.t) < 100001
    summary = json.loads((folder / "summary.json").read_text())["controllers"]
    assert {law: each["status"] for law, each in summary.items()} == {
        "pseudoinverse": "finished",
        "null-space-vector": "interrupted",
    }


@posix
def test_interrupted_run_ends_with_status_130_and_no_traceback(interrupted):
    _, done = interrupted
    assert done.returncode == 130
    assert done.stdout == ""
    assert "Traceback" not in done.stderr


# What is registered, and robots


@pytest.mark.parametrize("command", REGISTERED)
def test_what_is_registered_is_listed_with_its_parameters_and_what_it_is(command):
    done, kind = run(command, env=WIDE), REGISTERED[command]
    assert (done.returncode, done.stderr) == (0, "")
    lines = {line.split()[0]: " ".join(line.split()) for line in done.stdout.splitlines()[1:]}
    assert tuple(lines) == kind.available()
    for name, line in lines.items():
        assert f"{name} {kind.describe_parameters(kind.find(name))}".strip() in line
        assert kind.find(name).__doc__.splitlines()[0] in line


def test_the_list_of_laws_shows_names_defaults_and_the_first_line():
    line = next(each for each in run("controllers", env=WIDE).stdout.splitlines() if each.startswith("jmdc"))
    assert " ".join(line.split()).startswith(
        "jmdc kp = 100.0, kv = 20.0, kappa = 0.001, criterion = minor-measure JMDC, Eqs. (17)–(21)"
    )


@pytest.fixture(scope="module")
def robot_lines():
    done = run("robots", env=WIDE)
    assert (done.returncode, done.stderr) == (0, "")
    return {line.split()[0]: line.split() for line in done.stdout.splitlines()[1:]}


def test_robots_lists_every_example(robot_lines):
    assert tuple(robot_lines) == example_names()


@pytest.mark.parametrize(("robot", "frame"), [("panda", "panda_hand_tcp"), ("planar3r", "tool"), ("ur5", "tool0")])
def test_robots_lists_joints_and_the_frames_that_end_a_chain(robot_lines, robot, frame):
    model = load_example_model(robot)
    assert robot_lines[robot] == [robot, str(model.nv), *end_frames(model)]
    assert frame in robot_lines[robot]


def test_robots_says_why_a_robot_cannot_be_loaded(robot_lines):
    problem = example_overview("cassie").problem
    if problem:
        assert " ".join(robot_lines["cassie"]) == " ".join(f"cassie 0 {problem}".split())
        assert "described in SDF, which cannot be read here" in problem


def test_help_names_the_commands():
    done = run("--help")
    assert done.returncode == 0
    for command in ("run", "survey", "robots", "reproduce", *REGISTERED):
        assert re.search(rf"^\s+{command}\s", done.stdout, re.MULTILINE)


# survey


def test_survey_that_cannot_write_is_one_line_and_status_2(tmp_path):
    (tmp_path / "file").write_text("in the way")
    done = run("survey", "--out", "file/below", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == "aspect-control: error: cannot write to folder file/below: Not a directory\n"


def test_survey_writes_exactly_the_files_it_promises(tmp_path, monkeypatch):
    """In this process, on two scenarios that are quick: the whole survey takes a minute."""
    from typer.testing import CliRunner

    from aspect_control.cli.commands import app
    from aspect_control.studies import survey
    from aspect_control.studies.study import Study

    for name in ("planar3r", "ur5-xyz"):
        text = scenario_paths()[name].read_text(encoding="utf-8")
        (tmp_path / f"{name}.toml").write_text(f"{text}\n[simulation]\ndt = 0.01\n", encoding="utf-8")
    study = Study({"scenarios": sorted(map(str, tmp_path.glob("*.toml"))), "report": "survey"}, "survey")
    monkeypatch.setattr(survey, "survey_study", lambda: study)
    arguments = ["survey", "--out", str(tmp_path / "out"), "--workers", "1"]
    done = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"survey.json", "survey.md", "survey.png", "survey.svg", "study.json", "shards"}
    document = json.loads((tmp_path / "out" / "survey.json").read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert document["chains"] == []
    pairs = [(row["scenario"], row["controller"]) for row in document["runs"]]
    assert len(pairs) == len(set(pairs)) == 8
    printed = re.findall(r"^(planar3r|ur5-xyz) ", done.stdout, re.MULTILINE)
    assert printed == [scenario for scenario, _ in pairs]
    report = (tmp_path / "out" / "survey.md").read_text(encoding="utf-8")
    assert all(re.search(rf"^\| {scenario} \| \d \| {law} \|", report, re.MULTILINE) for scenario, law in pairs)


def test_compare_writes_exactly_the_files_it_promises_and_makes_no_run_again(tmp_path, monkeypatch):
    """In this process, on one arm with two laws, coarsely sampled."""
    from typer.testing import CliRunner

    from aspect_control.cli.commands import app
    from aspect_control.studies import comparison
    from aspect_control.studies.study import Study

    definition = {
        "scenarios": ["planar3r"],
        "laws": [{"name": "jmdc"}, {"name": "qp", "label": "with-limits"}],
        "grid": [{"simulation.dt": [0.02]}],
        "report": "comparison",
    }
    monkeypatch.setattr(comparison, "comparison_study", lambda: Study(definition, "compare"))
    arguments = ["compare", "--out", str(tmp_path / "out"), "--workers", "1"]
    done = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    assert re.findall(r"^planar3r +(\S+)", done.stdout, re.MULTILINE) == ["jmdc", "with-limits"]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"compare.md", "torques-planar3r.png", "torques-planar3r.svg", "study.json", "shards"}
    written = {path: path.stat().st_mtime_ns for path in (tmp_path / "out" / "shards").iterdir()}
    report = (tmp_path / "out" / "compare.md").read_bytes()
    (tmp_path / "out" / "compare.md").unlink()
    CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "out" / "shards").iterdir()} == written
    assert (tmp_path / "out" / "compare.md").read_bytes() == report


# Known defects of the package; each passes strictly when it is mended


@posix
def test_interrupted_run_says_that_what_was_written_stays(interrupted):
    assert interrupted[1].stderr.endswith("aspect-control: interrupted; what was written stays\n")


def test_a_law_called_comparison_keeps_its_figure(tmp_path):
    law = 'controllers=[{name = "pseudoinverse", label = "comparison"}]'
    out = ("--out", tmp_path / "out")
    done = run("run", "planar3r", *out, "--set", law, "--set", "simulation.dt=0.02", "--set", "trajectory.duration=0.2")
    assert done.returncode == 2 or len(list((tmp_path / "out").glob("*.png"))) == 2


def test_dollar_signs_in_the_name_of_a_file(tmp_path):
    text = scenario_paths()["planar3r"].read_text(encoding="utf-8")
    (tmp_path / "a$^$.toml").write_text(text, encoding="utf-8")
    law = 'controllers=[{name = "pseudoinverse"}]'
    done = run("run", "a$^$.toml", "--set", law, "--set", "simulation.dt=0.02", cwd=tmp_path)
    assert done.returncode == 0


def test_robots_abbreviates_no_frame_on_a_narrow_screen():
    assert "…" not in run("robots", env={**os.environ, "COLUMNS": "80"}).stdout


def test_row_of_a_law_with_a_long_label_keeps_its_numbers(capsys, monkeypatch):
    from aspect_control.views.screen import show_laws

    monkeypatch.setenv("COLUMNS", "80")
    summary = {
        "peak_torque": [47.1],
        "aspect_preserved": True,
        "minor_zero_crossings": [],
        "max_tracking_error": 0.001,
        "status": "finished",
        "message": "",
    }
    show_laws({"a" * 80: summary})
    assert "47.1 N m" in capsys.readouterr().out
