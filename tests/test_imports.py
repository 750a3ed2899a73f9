"""The rules of the house: which room may import which, who prints and draws, and what is loaded when."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import aspect_control
from aspect_control import controllers

PACKAGE = Path(aspect_control.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
SOLVERS = {"daqp", "osqp", "qpsolvers", "quadprog", "scipy"}
HEAVY = {"distributed", "joblib", "matplotlib", "meshcat", "mujoco", "numba", "pandas", "pyarrow", "ruckig"} | SOLVERS
LONGEST = 300

SHARED = {"checks", "exceptions", "files", "limits", "registry", "resources"}
"""What every room but `redundancy` may use."""

MAY_IMPORT = {
    "redundancy": set(),
    "arm": {"redundancy"},
    "criteria": {"arm", "redundancy"},
    "trajectories": {"arm", "redundancy"},
    "controllers": {"arm", "criteria", "redundancy", "trajectories"},
    "guard": {"arm", "controllers", "redundancy", "trajectories"},
    "plants": {"arm", "redundancy"},
    "simulation": {"arm", "controllers", "criteria", "guard", "plants", "redundancy", "trajectories"},
    "realtime": {"arm", "controllers", "redundancy", "simulation", "trajectories"},
    "aspects": {"arm", "criteria", "redundancy"},
    "analysis": {"arm", "aspects", "controllers", "plants", "redundancy", "simulation", "trajectories"},
    "scenario": {"arm", "controllers", "guard", "plants", "redundancy", "simulation", "trajectories"},
    "studies": {"analysis", "arm", "controllers", "guard", "plants", "redundancy", "scenario", "simulation"}
    | {"trajectories"},
    "views": {"analysis", "arm", "aspects", "redundancy", "simulation", "studies", "trajectories"},
    "cli": {"analysis", "arm", "aspects", "controllers", "criteria", "plants", "scenario", "simulation", "studies"}
    | {"trajectories", "views"},
}
"""The other rooms that a room may import, directly."""


def dotted_name(file):
    parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted_name(file): file for file in FILES}


def statements(node, *, deferred):
    """Every statement of a file; without what runs later than its import, or never, unless that is `deferred`."""
    for child in ast.iter_child_nodes(node):
        inside = isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef))
        for_types = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
        if deferred or not (inside or for_types):
            yield child
            yield from statements(child, deferred=deferred)


def imports(file, *, deferred=True):
    """Every module that a file may import by its full name, also in its functions and for types if `deferred`."""
    package = dotted_name(file).split(".")
    package = package if file.name == "__init__.py" else package[:-1]
    for node in statements(ast.parse(file.read_text(encoding="utf-8")), deferred=deferred):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            yield origin
            yield from (f"{origin}.{alias.name}" for alias in node.names)


def ours(names):
    return {name for name in names if name in MODULES and name != "aspect_control"}


def room(name):
    return name.split(".")[1]


def in_any(name, *packages):
    return any(f"{name}.".startswith(f"aspect_control.{package}.") for package in packages)


def circles(graph):
    """The nodes from which a way leads back to themselves."""
    found = set()
    for start in graph:
        reached, waiting = set(), set(graph[start])
        while waiting:
            name = waiting.pop()
            reached.add(name)
            waiting |= graph.get(name, set()) - reached
        found |= {start} & reached
    return found


def test_the_imports_of_a_file_are_seen():
    loop, views = PACKAGE / "simulation" / "loop.py", PACKAGE / "views" / "__init__.py"
    assert {"numpy", "aspect_control.checks", "aspect_control.plants"} <= set(imports(loop))
    live = "aspect_control.views.replays.live"
    assert live in set(imports(views)) - set(imports(views, deferred=False))


def test_circles_are_seen():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == {"b", "c"}


# Who imports whom


def test_every_room_has_its_rule():
    assert {room(dotted_name(file)) for file in PACKAGE.glob("*/__init__.py")} == set(MAY_IMPORT)


@pytest.mark.parametrize("importing", MAY_IMPORT)
def test_a_room_imports_only_what_it_may(importing):
    allowed = {importing} | MAY_IMPORT[importing] | (SHARED if importing != "redundancy" else set())
    broken = {
        f"{name} imports {imported}"
        for name, file in MODULES.items()
        if in_any(name, importing)
        for imported in ours(imports(file))
        if room(imported) not in allowed
    }
    assert not broken


def test_what_is_shared_knows_no_room_but_the_arm_and_the_mathematics():
    known = {
        room(imported) for name, file in MODULES.items() if in_any(name, *SHARED) for imported in ours(imports(file))
    }
    assert known <= SHARED | {"arm", "redundancy"}


def test_rooms_import_each_other_in_no_circle():
    graph = {each: set() for each in (*MAY_IMPORT, *SHARED)}
    for name, file in MODULES.items():
        if name != "aspect_control":
            graph[room(name)] |= {room(imported) for imported in ours(imports(file))} - {room(name)}
    assert not circles(graph)


def test_modules_import_each_other_in_no_circle():
    assert not circles({name: ours(imports(file, deferred=False)) - {name} for name, file in MODULES.items()})


@pytest.mark.parametrize("file", sorted((PACKAGE / "redundancy").rglob("*.py")), ids=dotted_name)
def test_redundancy_knows_no_robot(file):
    assert "pinocchio" not in {name.split(".")[0] for name in imports(file)}


def test_no_room_reaches_into_an_arm():
    reaching = {
        f"{name}: {ast.unparse(node)}"
        for name, file in MODULES.items()
        if not in_any(name, "arm")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and node.attr.startswith("_") and not node.attr.startswith("__")
        if ast.unparse(node.value).split(".")[-1] in {"arm", "_arm", "joints", "kinematics"}
    }
    assert not reaching


# Who prints and draws


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


# What is loaded


def loaded_by(code):
    """The top-level modules that a process of its own has loaded at the end."""
    code = f"import json, sys\n{code}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {name.split(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


def test_importing_the_package_loads_no_plot_no_engine_no_compiler_and_no_solver():
    loaded = loaded_by("import aspect_control")
    assert "aspect_control" in loaded
    assert not loaded & HEAVY


@pytest.mark.parametrize("law", controllers.available())
def test_running_a_law_loads_no_plot_no_engine_and_no_compiler_and_a_solver_only_for_a_program(law):
    loaded = loaded_by(f"""
import numpy as np
import aspect_control as ac
arm = ac.Arm.from_example("planar3r", frame="tool", task="xy")
line = ac.StraightLine([0.1, 0.1], duration=0.1)
run = ac.simulate(ac.controllers.create({law!r}, arm), line, q0=[-0.9, 2.4, -2.4], dt=0.01)
assert run.status == "finished", run.message
""")
    assert "pinocchio" in loaded
    assert not loaded & (HEAVY - SOLVERS if law == "qp" else HEAVY)


# What a file is called and how long it is


def test_a_name_of_a_file_says_what_is_in_it_and_no_other_file_has_it():
    names = [file.name for file in FILES if file.name not in {"__init__.py", "registry.py"}]
    assert not {name for name in names if names.count(name) > 1}


@pytest.mark.parametrize("folder", [PACKAGE, Path(__file__).parents[1] / "benchmarks"], ids=lambda each: each.name)
def test_no_file_is_longer_than_what_is_read_at_once(folder):
    lengths = {
        str(file.relative_to(folder)): len(file.read_text(encoding="utf-8").splitlines())
        for kind in ("py", "js", "css", "html")
        for file in folder.rglob(f"*.{kind}")
    }
    assert not {name: length for name, length in lengths.items() if length > LONGEST}
