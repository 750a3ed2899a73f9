"""Other packages on the same arm, task and machine, where they are installed."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pinocchio as pin

from aspect_control.arm import Arm
from aspect_control.exceptions import ParameterError

from . import arms
from .floor import floor
from .ticks import tick
from .timing import WARM, Call, Row, around, interleaved

TICKS = 200
"""Ticks that PlaCo's process makes in one round."""


def rivals(arm: Arm, rounds: int, placo_python: Path | None, *, laws: Sequence[str], with_pink: bool) -> list[Row]:
    """Time the laws beside PlaCo and Pink, where they are installed.

    Args:
        arm: Panda with the position of its tool as the task.
        rounds: Number of rounds.
        placo_python: A Python that has PlaCo, if not this one.
        laws: Names of the laws.
        with_pink: Whether to time Pink.

    Raises:
        ParameterError: If `placo_python` does not run PlaCo.
    """
    samples = arms.samples(arm)
    calls = {"floor": around(floor(arm), samples), **{name: tick(name, arm, samples) for name in laws}}
    notes = {"Pink solve_ik": "velocities, not torques"}
    if with_pink and find_spec("pink") is not None:
        calls["Pink solve_ik"] = _pink(arm)
    if placo_python is None and find_spec("placo") is None:
        return _rows(calls, rounds, notes)
    with _placo(arm, str(placo_python or sys.executable)) as placo_tick:
        calls["PlaCo DynamicsSolver"] = placo_tick
        notes["PlaCo DynamicsSolver"] = "in C++, a process of its own"
        return _rows(calls, rounds, notes)


def rivals_not_installed(placo_python: Path | None) -> list[str]:
    """Return the names of the packages that are not installed."""
    names = {"pink": "pin-pink", **({"placo": "placo"} if placo_python is None else {})}
    return [package for module, package in names.items() if find_spec(module) is None]


def _rows(calls: dict[str, Call], rounds: int, notes: dict[str, str]) -> list[Row]:
    seconds = interleaved(calls, rounds)
    base = "PlaCo DynamicsSolver" if "PlaCo DynamicsSolver" in calls else "floor"
    return [Row("Panda, xyz: rivals", each, seconds[each], seconds[base], base, notes.get(each, "")) for each in calls]


def _pink(arm: Arm) -> Call:
    import pink
    import qpsolvers

    samples = arms.samples(arm)
    configuration = pink.Configuration(arm.model, arm.model.createData(), samples[0].q)
    hand = pink.tasks.FrameTask(arm.frame, position_cost=1.0, orientation_cost=0.0)
    posture = pink.tasks.PostureTask(cost=1e-3)
    posture.set_target(samples[0].q)
    solver = "daqp" if "daqp" in qpsolvers.available_solvers else "osqp"

    def solve(sample: arms.Sample) -> object:
        configuration.update(sample.q)
        hand.set_target(pin.SE3(np.eye(3), sample.target.x))
        return pink.solve_ik(configuration, (hand, posture), 1e-3, solver=solver, limits=())

    return around(solve, samples)


@contextmanager
def _placo(arm: Arm, python: str) -> Iterator[Call]:
    """Start PlaCo's process and yield the call that returns its time of a tick."""
    samples = arms.samples(arm)
    job = {
        "urdf": _chain_only(arm.description.urdf or ""),
        "frame": arm.frame,
        "joints": arm.joint_names,
        "q": [sample.q.tolist() for sample in samples],
        "v": [sample.v.tolist() for sample in samples],
        "x": [sample.target.x.tolist() for sample in samples],
    }
    worker = str(Path(__file__).with_name("placo_worker.py"))
    try:
        process = subprocess.Popen(  # noqa: S603
            [python, worker], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    except OSError as error:
        raise ParameterError(f"--placo-python must be a Python that has PlaCo, got {python}: {error}") from error
    with process:
        answers, orders = process.stdout, process.stdin
        if answers is None or orders is None:
            raise ParameterError(f"--placo-python must be a Python that has PlaCo, got {python}")

        def ask(line: str) -> str:
            try:
                orders.write(line + "\n")
                orders.flush()
            except BrokenPipeError:
                return ""
            return answers.readline()

        if not ask(json.dumps(job)).startswith("ready"):
            said = process.stderr.read().strip().splitlines()[-1:] if process.stderr else []
            raise ParameterError(f"--placo-python must be a Python that has PlaCo, got {python}: {' '.join(said)}")

        def timed() -> float:
            # Begins warm, as the calls of `interleaved` do.
            ask(str(math.ceil(WARM * TICKS)))
            return float(ask(str(TICKS)))

        yield timed
        orders.close()


def _chain_only(urdf: str) -> str:
    """Return a URDF without meshes, and with the fingers fixed as the arm has them."""
    bare = re.sub(r"<(visual|collision)\b.*?</\1>", "", urdf, flags=re.DOTALL)
    return bare.replace('type="prismatic"', 'type="fixed"')
