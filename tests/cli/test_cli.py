"""The command line, as a user's shell runs it."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.studies.paper import trajectory_a as paper

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
FILES = {
    *(f"{name}.{suffix}" for name in ("fig2", "fig3", "fig4", "comparison") for suffix in ("png", "svg")),
    *(f"{law}.npz" for law in (*paper.LAWS, paper.DEAD_BEAT)),
    "summary.json",
    "report.md",
    "replay.html",
}


def run(*arguments, **options):
    return subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False, **options)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The main job, in an empty folder, with its default output folder."""
    folder = tmp_path_factory.mktemp("job")
    done = run("reproduce", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return folder / "results", done.stdout


def test_reproduce_writes_everything_it_promises_and_nothing_else(results):
    folder, _ = results
    assert {path.name for path in folder.iterdir()} == FILES
    assert all(path.stat().st_size > 1000 for path in folder.iterdir())


def test_summary_is_strict_json_of_the_recorded_runs(results):
    folder, _ = results
    summary = json.loads((folder / "summary.json").read_text(), parse_constant=pytest.fail)["controllers"]
    assert set(summary) == {*paper.LAWS, paper.DEAD_BEAT}
    for law, values in summary.items():
        recorded = ac.Run.load(folder / f"{law}.npz")
        assert values["peak_torque"] == np.abs(recorded.tau).max(axis=0).tolist()
        assert len(recorded.t) == 2001
        assert recorded.info.controller == law.removesuffix("-dead-beat")


def test_report_has_a_row_a_claim_and_the_limit_beside_the_paper(results):
    folder, screen = results
    report = (folder / "report.md").read_text()
    rows = [line for line in report.splitlines() if re.match(r"\|.*\| (agrees|partly|differs) \|", line)]
    assert len(rows) == 20
    assert "6.5·10⁵" in report
    assert "| → 0 | 45,169 |" in report
    assert all(f"({name}.png)" in report for name in ("fig2", "fig3", "fig4", "comparison"))
    assert len(re.findall(r"^ (agrees|partly|differs) ", screen, re.MULTILINE)) == 20


def test_options_out_and_dt(tmp_path):
    done = run("reproduce", "--out", tmp_path / "a" / "b", "--dt", 0.01)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "a" / "b").iterdir()} == FILES
    assert ac.Run.load(tmp_path / "a" / "b" / "jmdc.npz").info.dt == 0.01


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["reproduce", "--dt", "0"], "--dt must be a finite number above 0 s, got 0.0"),
        (["reproduce", "--dt", "nan"], "--dt must be a finite number above 0 s, got nan"),
        (["reproduce", "--dt", "-1e-3"], "got -0.001"),
        (["reproduce", "--dt", "5"], "longer than the motion of 2 s, got 5 s"),
        (["reproduce", "--dt", "1e-12"], "at most 20,000,000 fit"),
        (["reproduce", "--dt", "soon"], "--dt"),
        (["reproduce", "--speed", "2"], "--speed"),
        (["reproduce", "left-over"], "left-over"),
        (["replicate"], "replicate"),
        (["reproduce", "--out", "file/below"], "cannot write to folder file/below"),
    ],
)
def test_bad_input_is_one_line_on_stderr_and_status_2(tmp_path, arguments, words):
    (tmp_path / "file").write_text("in the way")
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("aspect-control: error: ")
    assert words in done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_help_names_the_command_with_and_without_a_request():
    for arguments in ([], ["--help"]):
        done = run(*arguments)
        assert done.returncode == 0
        assert "reproduce" in done.stdout
