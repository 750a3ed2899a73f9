import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import aspect_control

PACKAGE = Path(aspect_control.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
HEAVY = {"matplotlib", "meshcat", "numba", "osqp", "qpsolvers", "scipy"}


def dotted_name(file):
    parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted_name(file): file for file in FILES}


def imports(file):
    """Every module that a file may import, anywhere in it, by its full name."""
    package = dotted_name(file).split(".")
    package = package if file.name == "__init__.py" else package[:-1]
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            yield origin
            yield from (f"{origin}.{alias.name}" for alias in node.names)


def ours(names):
    return {name for name in names if name in MODULES and name != "aspect_control"}


def everything_imported_by(package):
    """The modules of this package that a subpackage needs, directly or through others."""
    reached, waiting = set(), {name for name in MODULES if f"{name}.".startswith(f"{package}.")}
    while waiting:
        name = waiting.pop()
        reached.add(name)
        waiting |= ours(imports(MODULES[name])) - reached
    return reached


def in_any(name, *packages):
    return any(f"{name}.".startswith(f"aspect_control.{package}.") for package in packages)


def test_importing_the_package_loads_no_plot_no_solver_and_no_scipy():
    code = "import json, sys, aspect_control; print(json.dumps(sorted(sys.modules)))"
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    loaded = {name.split(".")[0] for name in json.loads(output)}
    assert "aspect_control" in loaded
    assert not loaded & HEAVY


def test_the_imports_of_a_file_are_seen():
    names = set(imports(PACKAGE / "simulation" / "loop.py"))
    assert {"numpy", "aspect_control.checks", "aspect_control.plants"} <= names


def test_redundancy_imports_nothing_of_ours():
    assert all(in_any(name, "redundancy") for name in everything_imported_by("aspect_control.redundancy"))


@pytest.mark.parametrize("file", sorted((PACKAGE / "redundancy").rglob("*.py")), ids=dotted_name)
def test_redundancy_knows_no_robot(file):
    assert "pinocchio" not in {name.split(".")[0] for name in imports(file)}


def test_arm_knows_no_controller():
    assert not [name for name in everything_imported_by("aspect_control.arm") if in_any(name, "controllers")]


def test_criteria_know_the_arm_and_no_controller():
    reached = everything_imported_by("aspect_control.criteria")
    assert not [name for name in reached if in_any(name, "controllers", "simulation", "analysis", "views", "cli")]


def test_controllers_never_import_the_simulation():
    reached = everything_imported_by("aspect_control.controllers")
    assert not [name for name in reached if in_any(name, "simulation", "analysis", "views", "cli")]


def test_the_simulation_imports_neither_views_nor_analysis():
    reached = everything_imported_by("aspect_control.simulation")
    assert not [name for name in reached if in_any(name, "analysis", "views", "cli")]


@pytest.mark.parametrize(
    "file", [file for file in FILES if not in_any(dotted_name(file), "cli", "views")], ids=dotted_name
)
def test_only_the_command_line_and_the_views_print(file):
    nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    assert not [node.lineno for node in nodes if isinstance(node, ast.Name) and node.id == "print"]
    assert "sys.stdout" not in {ast.unparse(node) for node in nodes if isinstance(node, ast.Attribute)}


@pytest.mark.parametrize(
    "file", [file for file in FILES if not in_any(dotted_name(file), "cli", "views")], ids=dotted_name
)
def test_only_the_command_line_and_the_views_draw(file):
    assert not {name.split(".")[0] for name in imports(file)} & {"matplotlib", "meshcat", "rich", "typer"}
