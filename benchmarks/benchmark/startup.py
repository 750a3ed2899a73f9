"""What starting costs: imports and the help of the command line, each in a process of its own."""

from __future__ import annotations

import subprocess
import sys
import time

import numpy as np

from .timing import Row

_HELP = "import sys; sys.argv = ['aspect-control', '--help']; from aspect_control.cli import main; main()"


def startup(rounds: int) -> list[Row]:
    """Time imports in turn; the time of bare Python is taken off those of the imports."""
    programs = {
        "bare Python": [sys.executable, "-c", ""],
        "import pinocchio": [sys.executable, "-c", "import pinocchio"],
        "import aspect_control": [sys.executable, "-c", "from aspect_control import Arm, controllers, simulate"],
        "aspect-control --help": [sys.executable, "-c", _HELP],
    }
    seconds: dict[str, list[float]] = {name: [] for name in programs}
    for _ in range(rounds + 1):
        for name, program in programs.items():
            begin = time.perf_counter()
            subprocess.run(program, check=True, capture_output=True)  # noqa: S603
            seconds[name].append(time.perf_counter() - begin)
    times = {name: np.array(values[1:]) for name, values in seconds.items()}
    bare, pinocchio = times["bare Python"], times["import pinocchio"] - times["bare Python"]
    return [
        Row("start", name, times[name] - bare, pinocchio, "import pinocchio")
        for name in ("import pinocchio", "import aspect_control", "aspect-control --help")
    ]
