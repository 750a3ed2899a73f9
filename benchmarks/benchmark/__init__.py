"""What pseudoinverses, control ticks and runs cost here, beside other libraries and beside Pinocchio's own calls."""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import distributions, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from aspect_control.arm import Arm
from aspect_control.redundancy import compile_kernels

from . import arms
from .closed_loop import closed_loop
from .guards import guards
from .pieces import arms_timed, pieces
from .programs import not_installed, programs
from .rivals import rivals, rivals_not_installed
from .startup import startup
from .targets import Verdict, verdicts
from .ticks import every_tick_of_a_motion, many_minors, ticks
from .timing import COMPILED, NUMPY, EveryTick, Row, one_thread

__all__ = ["EveryTick", "Row", "Verdict", "benchmark", "machine", "verdicts"]

TICKS_A_ROUND = 350
"""Ticks of a law on the motion of which every tick is timed, for each round: 10,500 in 30 rounds."""

NEXT_TO_PLACO = ("pseudoinverse", "null-space-vector")
"""The laws that are held against PlaCo."""

Part = tuple[str, Callable[[], list[Row]]]


def benchmark(
    rounds: int, placo_python: Path | None, progress: Callable[[str, float], None]
) -> tuple[list[Row], list[str]]:
    """Time everything in one process on one processor: as plain NumPy and then, where Numba is installed, compiled.

    The kernels of this process stay compiled.

    Args:
        rounds: Rounds in which the calls of a group take turns.
        placo_python: A Python that has PlaCo, if not this one.
        progress: Called with what is being timed and the part that is done, 0 to 1.

    Returns:
        The rows, whose groups end in how the laws ran, and the names of packages and solvers that are not installed.

    Raises:
        ParameterError: If `placo_python` does not run PlaCo.
    """
    arm, has_numba = arms.panda(), find_spec("numba") is not None
    plan = [(NUMPY, part) for part in _laws(arm, rounds, with_literal=True)]
    plan.append(("", ("start", lambda: startup(max(3, rounds // 3)))))
    if has_numba:
        plan.append(("", ("compiling", _compile)))
        plan += [(COMPILED, part) for part in [*_laws(arm, rounds, with_literal=False), *_pieces(rounds)]]
    # First, so that a Python without PlaCo is told at once; not on one processor, where PlaCo's process would wait.
    progress("rivals", 0.0)
    rows = _labelled(rivals(arm, rounds, placo_python, laws=NEXT_TO_PLACO, with_pink=False), NUMPY)
    with one_thread():
        for i, (mode, (label, part)) in enumerate(plan, start=1):
            progress(f"{label}, {mode}" if mode else label, i / (len(plan) + 1))
            rows += _labelled(part(), mode)
    if has_numba:
        laws = (*NEXT_TO_PLACO, "jmdc")
        rows += _labelled(rivals(arm, rounds, placo_python, laws=laws, with_pink=True), COMPILED)
    missing = [] if has_numba else ["numba"]
    return rows, missing + rivals_not_installed(placo_python) + not_installed()


def _laws(arm: Arm, rounds: int, *, with_literal: bool) -> list[Part]:
    return [
        ("ticks of Panda, xyz", lambda: ticks("Panda, xyz", arm, rounds, with_literal=with_literal)),
        ("ticks of planar 3R", lambda: ticks("planar 3R, xy", arms.planar(), rounds, with_literal=with_literal)),
        ("ticks of Panda, pose", lambda: ticks("Panda, pose", arms.panda("pose"), rounds, with_literal=with_literal)),
        ("every tick of a motion", lambda: [*every_tick_of_a_motion(arm, TICKS_A_ROUND * rounds)]),
        ("guards", lambda: guards(arm, max(3, rounds // 3))),
        ("many minors", lambda: many_minors(rounds)),
        ("quadratic programs", lambda: programs(arm, rounds)),
        ("closed loop", lambda: closed_loop(arm, max(3, rounds // 3))),
    ]


def _pieces(rounds: int) -> list[Part]:
    timed = arms_timed()
    return [(f"pieces of {name}", lambda name=name: pieces(name, timed[name], rounds)) for name in timed]  # type: ignore[misc]


def _compile() -> list[Row]:
    compile_kernels()
    return []


def _labelled(rows: list[Row], mode: str) -> list[Row]:
    return [replace(row, group=f"{row.group}, {mode}") if mode else row for row in rows]


def machine() -> dict[str, Any]:
    """Return what the times were measured on."""
    names = ("aspect-control", "pin", "eigenpy", "numpy", "numba", "scipy", "osqp", "daqp", "qpsolvers")
    installed = {each.name for each in distributions()}
    return {
        "processor": _processor(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in names if name in installed},
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())
