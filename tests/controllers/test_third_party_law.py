"""A law of somebody else's package, installed by pip, is a law like any other."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.analysis import summarize

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
CRITERIA = (Path(__file__).parents[2] / "docs" / "criteria.md").read_text(encoding="utf-8")
LAW = "damped-self-motion"

PYPROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "a-law-of-mine"
version = "1.0"
dependencies = ["aspect-control"]

[project.entry-points."aspect_control.controllers"]
damped-self-motion = "a_law_of_mine:DampedSelfMotion"

[project.entry-points."aspect_control.criteria"]
elbow-height = "a_law_of_mine:ElbowHeight"

[tool.hatch.build.targets.wheel]
only-include = ["a_law_of_mine.py"]
"""

SCENARIO = """
[robot]
example = "ur5"
frame = "tool0"
task = "xyz"

[start]
positions = [0.4, -1.2, 1.5, -0.7, 0.9, 0.3]

[trajectory]
kind = "line"
displacement = [-0.05, -0.1, 0.05]
duration = 0.4
profile = "quintic"

[[controllers]]
name = "damped-self-motion"
kp = 150.0

[[controllers]]
name = "pseudoinverse"

[simulation]
dt = 0.01
"""


class Installed(NamedTuple):
    """A folder with a scenario, and the environments with and without the package that it needs."""

    folder: Path
    there: dict[str, str]
    gone: dict[str, str]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The README's law as a package of its own, built and installed by pip into a folder of its own."""
    folder = tmp_path_factory.mktemp("third party")
    source, site = folder / "source", folder / "site"
    source.mkdir()
    (law,) = [block for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if f'name = "{LAW}"' in block]
    (criterion,) = [
        block for block in re.findall(r"```python\n(.*?)```", CRITERIA, re.DOTALL) if "class Elbow" in block
    ]
    (source / "a_law_of_mine.py").write_text(f'"""A law of mine."""\n\n{law}\n\n{criterion}', encoding="utf-8")
    (source / "pyproject.toml").write_text(PYPROJECT, encoding="utf-8")
    (folder / "mine.toml").write_text(SCENARIO, encoding="utf-8")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    done = subprocess.run([*pip, "--target", site, source], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    gone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | {"COLUMNS": "3000"}
    return Installed(folder, gone | {"PYTHONPATH": str(site)}, gone)


def call(arguments, installed, environment):
    return subprocess.run(
        [*map(str, arguments)], capture_output=True, text=True, check=False, cwd=installed.folder, env=environment
    )


def python(code, installed, environment):
    """The JSON that a script prints in a process of its own."""
    done = call([sys.executable, "-W", "error", "-c", code], installed, environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def written(installed):
    """The results of the command on a scenario with the law."""
    done = call([COMMAND, "run", "mine.toml", "--out", "results"], installed, installed.there)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return installed.folder / "results", done.stdout


def test_the_law_is_there_only_where_its_package_is(installed):
    code = "import json; from aspect_control import controllers; print(json.dumps(controllers.available()))"
    there, gone = (python(code, installed, environment) for environment in (installed.there, installed.gone))
    assert set(there) - set(gone) == {LAW}
    assert set(gone) < set(there)
    assert there == sorted(there)


def test_the_registry_makes_the_law(installed):
    code = f"""
import json
import aspect_control as ac

arm = ac.Arm.from_example("ur5", frame="tool0", task="xyz")
law = ac.controllers.create({LAW!r}, arm, kp=150.0)
q, v = [0.4, -1.2, 1.5, -0.7, 0.9, 0.3], [0.5, -0.1, 0.2, 0.3, -0.4, 0.1]
law.reset(q, v, 1e-3)
target = ac.Target(x=arm.task_position(q), dx=[0.1, 0.0, 0.0], ddx=[0.0, 0.2, 0.0])
print(json.dumps([type(law).__module__, law.name, law.parameters, law.torque(q, v, target).tolist()]))
"""
    module, name, parameters, tau = python(code, installed, installed.there)
    assert (module, name, parameters) == ("a_law_of_mine", LAW, {"kp": 150.0, "kv": 20.0})
    arm = ac.Arm.from_example("ur5", frame="tool0", task="xyz")
    q, v = [0.4, -1.2, 1.5, -0.7, 0.9, 0.3], [0.5, -0.1, 0.2, 0.3, -0.4, 0.1]
    same = ac.controllers.DampedNullSpace(arm, kp=150.0, damping=5.0)
    target = ac.Target(x=arm.task_position(q), dx=[0.1, 0.0, 0.0], ddx=[0.0, 0.2, 0.0])
    np.testing.assert_allclose(tau, same.torque(q, v, target), rtol=0, atol=1e-12)


def test_a_law_climbs_a_criterion_of_the_package(installed):
    code = """
import json
import aspect_control as ac

arm = ac.Arm.from_example("ur5", frame="tool0", task="xyz")
law = ac.controllers.create("jmdc", arm, kappa=0.5, criterion="elbow-height")
run = ac.simulate(law, ac.Hold(0.2), q0=[0.4, -1.2, 1.5, -0.7, 0.9, 0.3], dt=0.01)
print(json.dumps([ac.criteria.available(), run.info.parameters["criterion"], run.values_of(law.criterion).tolist()]))
"""
    names, specification, heights = python(code, installed, installed.there)
    assert "elbow-height" in names
    assert specification == "elbow-height"
    assert heights == sorted(heights)
    assert heights[-1] > heights[0] + 1e-4


def test_the_registry_refuses_what_the_law_does_not_take(installed):
    code = f"""
import json
import aspect_control as ac

arm = ac.Arm.from_example("ur5", frame="tool0", task="xyz")
try:
    ac.controllers.create({LAW!r}, arm, kpp=1.0)
except ac.exceptions.UnknownNameError as error:
    print(json.dumps(str(error)))
"""
    message = python(code, installed, installed.there)
    assert re.match(rf"unknown parameter 'kpp' in '{LAW}': did you mean 'kp'.*available: 'kp', 'kv'$", message)


def test_a_scenario_runs_the_law(installed):
    code = """
import json
from aspect_control.scenario import load_scenario

runs = load_scenario("mine.toml").build().run()
print(json.dumps({label: [run.info.controller, run.status, run.info.parameters] for label, run in runs.items()}))
"""
    assert python(code, installed, installed.there) == {
        LAW: [LAW, "finished", {"kp": 150.0, "kv": 20.0}],
        "pseudoinverse": ["pseudoinverse", "finished", {"kp": 100.0, "kv": 20.0}],
    }


def test_the_command_lists_the_law(installed):
    there, gone = (call([COMMAND, "controllers"], installed, each) for each in (installed.there, installed.gone))
    assert (there.returncode, gone.returncode) == (0, 0)
    rows = [line.split() for line in there.stdout.splitlines() if line.startswith(LAW)]
    assert [row[:7] for row in rows] == [[LAW, "kp", "=", "100.0,", "kv", "=", "20.0"]]
    assert LAW not in gone.stdout


def test_the_command_writes_what_it_writes_for_any_law(written):
    folder, printed = written
    labels = (LAW, "pseudoinverse")
    figures = {f"{label}.{suffix}" for label in (*labels, "comparison") for suffix in ("png", "svg")}
    others = {f"{label}.npz" for label in labels} | {"summary.json", "replay.html"}
    assert {path.name for path in folder.iterdir()} == figures | others
    assert re.search(rf"^{LAW} +[\d.]+ N m ", printed, re.MULTILINE)


def test_a_run_of_the_law_needs_no_package_to_be_read(installed, written):
    folder, _ = written
    code = f"""
import json
import sys
import aspect_control as ac
from aspect_control.analysis import summarize

run = ac.Run.load("results/{LAW}.npz")
assert "a_law_of_mine" not in sys.modules
assert {LAW!r} not in ac.controllers.available()
print(json.dumps([run.info.controller, run.info.parameters, run.status, summarize(run)]))
"""
    *facts, summary = python(code, installed, installed.gone)
    assert facts == [LAW, {"kp": 150.0, "kv": 20.0}, "finished"]
    assert summary == json.loads((folder / "summary.json").read_text(encoding="utf-8"))["controllers"][LAW]
    assert summary == json.loads(json.dumps(summarize(ac.Run.load(folder / f"{LAW}.npz"))))


def test_the_law_did_damp_the_self_motion(written):
    folder, _ = written
    damped, plain = (ac.Run.load(folder / f"{label}.npz") for label in (LAW, "pseudoinverse"))
    speed, plain_speed = (np.linalg.norm(run.homogeneous_velocity, axis=1) for run in (damped, plain))
    assert speed.max() > 0.0
    assert speed[-1] < plain_speed[-1]


def test_a_scenario_whose_law_is_not_installed_is_one_line(installed):
    done = call([COMMAND, "run", "mine.toml", "--out", "nothing"], installed, installed.gone)
    assert done.returncode == 2
    assert re.fullmatch(rf"aspect-control: error: unknown controller '{LAW}': .*available: .*\n", done.stderr)
    assert not (installed.folder / "nothing").exists()
