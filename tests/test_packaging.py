import inspect
import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
from importlib.metadata import entry_points, version
from pathlib import Path

import pytest

import aspect_control
from aspect_control import controllers, criteria, plants, trajectories
from aspect_control.simulation import events, integrators

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"
PROJECT = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
KINDS = {
    "aspect_control.controllers": (controllers, controllers.Controller),
    "aspect_control.criteria": (criteria, criteria.Criterion),
    "aspect_control.trajectories": (trajectories, trajectories.Trajectory),
    "aspect_control.events": (events, events.Event),
    "aspect_control.integrators": (integrators, integrators.Integrator),
    "aspect_control.plants": (plants, plants.Plant),
}
"""Where the classes of each entry-point group are exported, and their abstract base."""


def test_every_kind_has_its_entry_points():
    assert set(PROJECT["entry-points"]) == set(KINDS)


@pytest.mark.parametrize("group", KINDS)
def test_every_exported_class_is_an_entry_point_under_its_own_name(group):
    home, base = KINDS[group]
    exported = {each for each in vars(home).values() if inspect.isclass(each) and issubclass(each, base)}
    concrete = {each for each in exported if not inspect.isabstract(each)}
    assert {each.name: f"{home.__name__}:{each.__name__}" for each in concrete} == PROJECT["entry-points"][group]


@pytest.mark.parametrize("group", KINDS)
def test_the_registry_finds_the_classes_of_the_entry_points(group):
    home, base = KINDS[group]
    names = PROJECT["entry-points"][group]
    assert set(names) <= set(home.available())
    for name in names:
        assert issubclass(home.find(name), base)
        assert home.find(name).name == name


def test_the_command_is_installed():
    assert [script.value for script in entry_points(group="console_scripts", name="aspect-control")] == [
        PROJECT["scripts"]["aspect-control"]
    ]


def test_the_command_can_be_called():
    (script,) = entry_points(group="console_scripts", name="aspect-control")
    assert callable(script.load())


def test_the_installed_version_is_the_package_s():
    assert version("aspect-control") == aspect_control.__version__


def test_the_version_has_three_numbers():
    assert re.fullmatch(r"\d+\.\d+\.\d+", aspect_control.__version__)


def test_the_package_is_typed():
    assert (Path(aspect_control.__file__).parent / "py.typed").is_file()


@pytest.mark.parametrize("name", aspect_control.__all__)
def test_every_public_name_exists(name):
    assert hasattr(aspect_control, name)


def test_the_command_says_its_version():
    done = subprocess.run([COMMAND, "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"aspect-control {aspect_control.__version__}\n", "")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_command_completes_in_a_shell(shell):
    done = subprocess.run([COMMAND, "--show-completion", shell], capture_output=True, text=True)
    assert done.returncode == 0
    assert "_ASPECT_CONTROL_COMPLETE" in done.stdout


@pytest.fixture(scope="module")
def distributions(tmp_path_factory):
    """The wheel and the sdist, built of what git would commit."""
    source, built = tmp_path_factory.mktemp("source") / "aspect-control", tmp_path_factory.mktemp("dist")
    ignored = shutil.ignore_patterns(".git", ".venv", "*.egg-info", "__pycache__", "results", ".*_cache")
    shutil.copytree(PYPROJECT.parent, source, ignore=ignored)
    for target, hook in (("sdist", "build_sdist"), ("wheel", "build_wheel")):
        code = f"from hatchling.build import {hook}; {hook}({str(built)!r})"
        done = subprocess.run([sys.executable, "-c", code], cwd=source, capture_output=True, text=True)
        assert done.returncode == 0, f"{target}: {done.stderr}"
    return {path.suffix: path for path in built.iterdir()}


@pytest.mark.parametrize("suffix", [".whl", ".gz"])
def test_a_release_works_in_an_empty_environment(distributions, suffix, tmp_path):
    """Installed without its dependencies, which are lent from here: neither the checkout nor its entry points are."""
    venv.create(tmp_path / "empty", with_pip=True)
    python = tmp_path / "empty" / "bin" / "python"
    (packages,) = (tmp_path / "empty" / "lib").glob("python*/site-packages")
    lent = tmp_path / "lent"
    lent.mkdir()
    for each in {Path(path) for path in sys.path if path.endswith("site-packages")}:
        for entry in each.iterdir():
            if "aspect_control" not in entry.name and not (packages / entry.name).exists():
                (lent / entry.name).symlink_to(entry)
    (packages / "lent.pth").write_text(f"{lent}\n")
    install = [python, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", distributions[suffix]]
    done = subprocess.run(install, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    alone = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    where = [python, "-c", "import aspect_control; print(aspect_control.__file__)"]
    found = subprocess.run(where, cwd=tmp_path, env=alone, capture_output=True, text=True, check=True).stdout
    assert Path(found.strip()).is_relative_to(packages)
    command = [packages.parents[2] / "bin" / "aspect-control", "run", "planar3r", "--set", "simulation.dt=0.02"]
    done = subprocess.run(command, cwd=tmp_path, env=alone, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "results" / "planar3r" / "jmdc.npz").is_file()
