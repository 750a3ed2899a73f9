"""What somebody else's package registers, installed by pip, is a law, criterion, trajectory, ... like any other."""

import json
import os
import re
import subprocess
import sys
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.analysis import summarize
from aspect_control.exceptions import EntryPointError
from aspect_control.scenario import load_scenario

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
ROOT = Path(__file__).parents[1]
README, CRITERIA, EXTENDING = (
    (ROOT / page).read_text(encoding="utf-8") for page in ("README.md", "docs/criteria.md", "docs/extending.md")
)
LAW = "damped-self-motion"
ADDED = {
    "controllers": LAW,
    "criteria": "elbow-height",
    "trajectories": "there-and-back",
    "simulation.events": "below-floor",
    "simulation.integrators": "midpoint",
    "plants": "viscous-joints",
}
"""What the package adds to each kind, by where the kind is found."""

every_kind = pytest.mark.parametrize("kind", ADDED)
GROUPS, PARTS_OF_A_SCENARIO = re.findall(r"```toml\n(.*?)```", EXTENDING, re.DOTALL)

PYPROJECT = f"""
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "parts-of-mine"
version = "1.0"
dependencies = ["aspect-control"]

[project.entry-points."aspect_control.controllers"]
damped-self-motion = "parts_of_mine:DampedSelfMotion"

[project.entry-points."aspect_control.criteria"]
elbow-height = "parts_of_mine:ElbowHeight"

{GROUPS}
[tool.hatch.build.targets.wheel]
only-include = ["parts_of_mine.py"]
"""

SCENARIO = f"""
{PARTS_OF_A_SCENARIO}
[robot]
example = "ur5"
frame = "tool0"
task = "xyz"

[start]
positions = [0.4, -1.2, 1.5, -0.7, 0.9, 0.3]

[[controllers]]
name = "damped-self-motion"
kp = 150.0

[[controllers]]
name = "pseudoinverse"
"""


HOLD = "trajectory={kind='hold', duration=0.4}"
PLAIN = "controllers=[{name='pseudoinverse'}]"


class Installed(NamedTuple):
    """A folder with a scenario, and the environments with and without the package that it needs."""

    folder: Path
    there: dict[str, str]
    gone: dict[str, str]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The parts that README and docs show as a package, built and installed by pip into a folder of its own."""
    folder = tmp_path_factory.mktemp("third party")
    source, site = folder / "source", folder / "site"
    source.mkdir()
    (law,) = [block for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if f'name = "{LAW}"' in block]
    (criterion,) = [
        block for block in re.findall(r"```python\n(.*?)```", CRITERIA, re.DOTALL) if "class Elbow" in block
    ]
    (others,) = re.findall(r"```python\n(.*?)```", EXTENDING, re.DOTALL)
    text = "\n\n".join(['"""Parts of mine."""', law, criterion, others])
    (source / "parts_of_mine.py").write_text(text, encoding="utf-8")
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


def test_what_is_added_is_there_only_where_its_package_is(installed):
    names = ", ".join(f"{kind!r}: ac.{kind}.available()" for kind in ADDED)
    code = f"import json; import aspect_control as ac; print(json.dumps({{{names}}}))"
    there, gone = (python(code, installed, environment) for environment in (installed.there, installed.gone))
    assert {kind: set(there[kind]) - set(gone[kind]) for kind in ADDED} == {kind: {ADDED[kind]} for kind in ADDED}
    for kind in ADDED:
        assert set(gone[kind]) < set(there[kind])
        assert there[kind] == sorted(there[kind])


@pytest.mark.parametrize(
    ("command", "row"),
    [
        ("controllers", f"{LAW} kp = 100.0, kv = 20.0 τ̃ less a damping torque on the self-motion."),
        ("criteria", "elbow-height H = z of the arm's fourth joint, m."),
        ("trajectories", "there-and-back displacement, duration Along a displacement and back to the start."),
        ("events", "below-floor height = 0.0 A joint of the arm is below a height."),
        ("integrators", "midpoint The explicit midpoint method of second order."),
        ("plants", "viscous-joints damping = 1.0 Rigid bodies whose joints have viscous friction, N m s/rad."),
    ],
)
def test_the_command_lists_what_is_added(installed, command, row):
    done = call([COMMAND, command], installed, installed.there)
    assert (done.returncode, done.stderr) == (0, "")
    assert row in [" ".join(line.split()) for line in done.stdout.splitlines()]


def test_simulate_takes_all_of_it_by_name(installed):
    code = """
import json
import numpy as np
import aspect_control as ac

arm = ac.Arm.from_example("ur5", frame="tool0", task="xyz")
law = ac.controllers.create("damped-self-motion", arm)
trajectory = ac.trajectories.create("there-and-back", displacement=[-0.05, -0.1, 0.05], duration=0.4)
options = {"q0": [0.4, -1.2, 1.5, -0.7, 0.9, 0.3], "dt": 0.01}
ideal = ac.simulate(law, trajectory, **options)
named = ac.simulate(law, trajectory, plant={"name": "viscous-joints", "damping": 0.0}, integrator="midpoint", **options)
ended = ac.simulate(law, trajectory, plant="viscous-joints", events=[{"name": "below-floor", "height": 9}], **options)
plant = ac.plants.create("viscous-joints", arm, damping=0.0)
method = ac.simulation.integrators.create("midpoint")
given = ac.simulate(law, trajectory, plant=plant, integrator=method, **options)
print(json.dumps({
    "away": float(np.abs(named.q - ideal.q).max()),
    "same": bool((given.q == named.q).all()),
    "integrators": [ideal.info.integrator, named.info.integrator],
    "ended": [ended.status, len(ended.t)],
    "path": np.abs(named.x_desired - named.x_desired[0]).max(axis=0).round(12).tolist(),
    "back": float(np.abs(named.x_desired[-1] - named.x_desired[0]).max().round(12)),
}))
"""
    found = python(code, installed, installed.there)
    assert 0.0 < found["away"] < 1e-2
    assert found["same"]
    assert found["integrators"] == ["rk4", "midpoint"]
    assert found["ended"] == ["below floor", 1]
    assert found["path"] == [0.05, 0.1, 0.05]
    assert found["back"] == 0.0


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
    assert (module, name, parameters) == ("parts_of_mine", LAW, {"kp": 150.0, "kv": 20.0})
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
from aspect_control.exceptions import EntryPointError
from aspect_control.scenario import load_scenario

run = ac.Run.load("results/{LAW}.npz")
assert "parts_of_mine" not in sys.modules
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


def test_a_scenario_with_what_is_not_installed_is_one_line(installed):
    done = call([COMMAND, "run", "mine.toml", "--out", "nothing"], installed, installed.gone)
    assert done.returncode == 2
    wanted = (
        "mine.toml: trajectory.kind: unknown trajectory 'there-and-back': .*available: 'circle', .*; "
        "events.0.name: unknown event 'below-floor': .*available: 'diverged', .*"
    )
    assert re.fullmatch(rf"aspect-control: error: {wanted}\n", done.stderr)
    assert not (installed.folder / "nothing").exists()


def test_a_scenario_whose_law_is_not_installed_is_one_line(installed):
    options = ("--set", HOLD, "--set", "events=[]", "--out", "nowhere")
    done = call([COMMAND, "run", "mine.toml", *options], installed, installed.gone)
    assert done.returncode == 2
    assert re.fullmatch(rf"aspect-control: error: unknown controller '{LAW}': .*available: .*\n", done.stderr)
    assert not (installed.folder / "nowhere").exists()


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ([], "unknown plant 'viscous-joints': available: 'rigid-body'"),
        (["simulation.plant=rigid-body"], "unknown integrator 'midpoint': available: 'rk4', 'semi-implicit-euler'"),
    ],
)
def test_a_plant_or_an_integrator_that_is_not_installed_is_refused(installed, settings, words):
    scenario = load_scenario(installed.folder / "mine.toml", [HOLD, "events=[]", PLAIN, *settings])
    with pytest.raises(ac.AspectControlError, match=words):
        scenario.build()


# A package that cannot be imported, or offers what it should not


def leave_behind(site, module, text):
    """What pip leaves of a package that offers one name of a module to every kind."""
    metadata = site / f"{module}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    groups = [f"[aspect_control.{kind.split('.')[-1]}]\nodd = {module}:Part" for kind in ADDED]
    (metadata / "entry_points.txt").write_text("\n".join(groups))
    (site / f"{module}.py").write_text(text)


@pytest.fixture
def broken(tmp_path, monkeypatch):
    """The folder of a package whose module fails when it is imported; it is installed here, too."""
    leave_behind(tmp_path, "broken_parts", "import a_module_that_is_gone")
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


BROKEN = r"the \w+ 'odd' of broken_parts:Part cannot be loaded: No module named 'a_module_that_is_gone'"


@every_kind
def test_a_package_that_fails_to_import_is_one_clear_error(broken, kind):
    home = attrgetter(kind)(ac)
    assert "odd" in home.available()
    for ask in (home.find, home.create):
        with pytest.raises(EntryPointError, match=f"^{BROKEN}$"):
            ask("odd")


def test_a_package_that_fails_to_import_is_one_line_of_the_command(installed, broken):
    done = call([COMMAND, "events"], installed, installed.gone | {"PYTHONPATH": str(broken)})
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(rf"aspect-control: error: {BROKEN}\n", done.stderr)


@pytest.mark.parametrize(
    "setting",
    [
        "trajectory={kind='odd'}",
        "events=[{name='odd'}]",
        "controllers=[{name='odd'}]",
        "simulation.plant=odd",
        "simulation.integrator=odd",
    ],
)
def test_a_scenario_with_a_part_that_fails_to_import_is_refused(broken, setting):
    with pytest.raises(ac.AspectControlError, match=f"{BROKEN}$"):
        load_scenario("planar3r", [setting]).build().run()


def test_a_package_that_fails_to_import_is_in_nobody_elses_way(broken):
    assert ac.trajectories.create("hold", duration=1.0).duration == 1.0
    load_scenario("planar3r", ["simulation.dt=0.1"]).build().run()


@pytest.mark.parametrize("text", ["Part = 'a law'", "def Part(): pass", "class Part: pass"])
def test_what_is_no_class_of_the_kind_is_refused(tmp_path, monkeypatch, text):
    leave_behind(tmp_path, "odd_parts", text)
    monkeypatch.syspath_prepend(tmp_path)
    try:
        for kind in ADDED:
            with pytest.raises(EntryPointError, match=r"^the \w+ 'odd' of odd_parts:Part must be a class derived from"):
                attrgetter(kind)(ac).find("odd")
    finally:
        sys.modules.pop("odd_parts", None)
