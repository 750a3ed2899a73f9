import inspect
import re
import sys
from importlib.metadata import EntryPoint, entry_points, version
from pathlib import Path

import pytest

import aspect_control
from aspect_control import controllers

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"
PROJECT = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
LAWS = PROJECT["entry-points"]["aspect_control.controllers"]


def exported_laws():
    exported = (getattr(controllers, name) for name in controllers.__all__)
    classes = {each for each in exported if inspect.isclass(each) and issubclass(each, controllers.Controller)}
    return {law for law in classes if not inspect.isabstract(law)}


def test_every_exported_law_is_an_entry_point_under_its_own_name():
    assert {law.name: f"aspect_control.controllers:{law.__name__}" for law in exported_laws()} == LAWS


@pytest.mark.parametrize("name", LAWS)
def test_an_entry_point_loads_the_law_of_its_name(name):
    law = EntryPoint(name, LAWS[name], "aspect_control.controllers").load()
    assert issubclass(law, controllers.Controller)
    assert law.name == name


def test_the_registry_lists_the_entry_points():
    assert set(LAWS) <= set(controllers.available())


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
