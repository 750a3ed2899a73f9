"""What pseudoinverses, control ticks and runs cost here, beside other libraries and beside Pinocchio's own calls."""

from __future__ import annotations

import platform
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from . import arms
from .closed_loop import closed_loop
from .pieces import arms_timed, pieces
from .programs import not_installed, programs
from .rivals import rivals
from .startup import startup
from .targets import Verdict, verdicts
from .ticks import many_minors, ticks
from .timing import Row, one_thread

__all__ = ["Row", "Verdict", "benchmark", "machine", "verdicts"]


def benchmark(
    rounds: int, placo_python: Path | None, progress: Callable[[str, float], None]
) -> tuple[list[Row], list[str]]:
    """Time everything, in one process on one processor.

    Args:
        rounds: Rounds in which the calls of a group take turns.
        placo_python: A Python that has PlaCo, if not this one.
        progress: Called with what is being timed and the part that is done, 0 to 1.

    Returns:
        The rows, and the names of rivals and solvers that are not installed.

    Raises:
        ParameterError: If `placo_python` does not run PlaCo.
    """
    arm, timed = arms.panda(), arms_timed()
    parts: list[tuple[str, Callable[[], list[Row]]]] = [
        ("ticks of Panda, xyz", lambda: ticks("Panda, xyz", arm, rounds)),
        ("ticks of planar 3R", lambda: ticks("planar 3R, xy", arms.planar(), rounds)),
        ("ticks of Panda, pose", lambda: ticks("Panda, pose", arms.panda("pose"), rounds)),
        ("many minors", lambda: many_minors(rounds)),
        *((f"pieces of {name}", lambda n=name, a=each: pieces(n, a, rounds)) for name, each in timed.items()),
        ("quadratic programs", lambda: programs(arm, rounds)),
        ("closed loop", lambda: closed_loop(arm, max(3, rounds // 3))),
        ("start", lambda: startup(max(3, rounds // 3))),
    ]
    # First, so that a Python without PlaCo is told at once; not on one processor, where PlaCo's process would wait.
    progress("rivals", 0.0)
    compared, missing = rivals(arm, rounds, placo_python)
    rows: list[Row] = []
    with one_thread():
        for i, (label, part) in enumerate(parts, start=1):
            progress(label, i / (len(parts) + 1))
            rows += part()
    return rows + compared, missing + not_installed()


def machine() -> dict[str, Any]:
    """Return what the times were measured on."""
    names = ("aspect-control", "pin", "eigenpy", "numpy", "numba", "scipy", "osqp", "qpsolvers")
    return {
        "processor": _processor(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in names},
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())
