"""A law at 1 kHz on a robot in another process: a simulated Panda with friction, over UDP, recorded and timed.

    python examples/realtime_loop.py                                                       # ten seconds
    python examples/realtime_loop.py --duration 60 --table docs/realtime-measured.md       # the page of figures

The motion is made twice: as any process of the machine, and as one that the scheduler prefers (`SCHED_FIFO`), where
that is allowed. A log in the user's own way makes garbage at every sample.
"""

from __future__ import annotations

import argparse
import os
import platform
from datetime import date
from pathlib import Path

import numpy as np

import aspect_control as ac
from aspect_control.realtime import Percentiles, SimulationProcess, Timing

READY = np.array([0.0, -np.pi / 4, 0.0, -3.0 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
PRIORITY = 20
COLUMNS = [
    "scheduler",
    "end",
    "samples",
    "deadlines missed",
    "samples lost",
    "garbage collections",
    "largest tip error",
]


def motion(duration: float, file: str) -> tuple[ac.Run, Timing]:
    """Go round a circle every four seconds, and save the recording."""
    arm = ac.Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
    law = ac.Guard(ac.controllers.create("damped-null-space", arm, kp=400.0, kv=40.0))
    log = []
    with SimulationProcess(arm, READY) as simulation, simulation.connect() as robot:
        loop = ac.RealTimeLoop(robot, law, dt=1e-3, watch=lambda s: log.append({"t": s.t, "q": s.q.tolist()}))
        run = loop.follow(ac.Circle(0.1, duration=duration, plane="yz", turns=max(1, round(duration / 4))))
    run.save(file)
    print(f"{run.message}, {len(log):,} rows logged, recorded in {file}\n{loop.timing}\n")
    return run, loop.timing


def row(scheduler: str, run: ac.Run, timing: Timing) -> list[str]:
    """Return one line of the first table."""
    counts = (len(run.t), timing.deadlines_missed, timing.samples_lost, timing.collections)
    return [scheduler, run.status, *(f"{count:,}" for count in counts), f"{run.tracking_error.max() * 1e3:.1f} mm"]


def times(scheduler: str, name: str, found: Percentiles) -> list[str]:
    """Return one line of the second table."""
    return [scheduler, name, *(f"{seconds * 1e6:,.0f} µs" for seconds in found)]


def table(header: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main() -> None:
    """Run, print, and write the page if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=10.0, help="of each motion, s")
    parser.add_argument("--table", help="Markdown file to write")
    parser.add_argument("--out", default="results/realtime", help="start of the names of the recordings")
    arguments = parser.parse_args()
    Path(arguments.out).parent.mkdir(parents=True, exist_ok=True)
    found = {"default": motion(arguments.duration, f"{arguments.out}-default.npz")}
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, PermissionError):
        print("SCHED_FIFO is not allowed here")
    else:
        found["SCHED_FIFO"] = motion(arguments.duration, f"{arguments.out}-fifo.npz")
    if arguments.table:
        command = f"python examples/realtime_loop.py --duration {arguments.duration:g} --table {arguments.table}"
        machine = (
            f"{os.cpu_count()} cores, {platform.system()} {platform.release()}, Python {platform.python_version()}"
        )
        timings = [
            times(name, kind, getattr(timing, kind))
            for name, (_, timing) in found.items()
            for kind in ("tick", "period")
        ]
        Path(arguments.table).write_text(
            f"# The real-time loop, measured\n\nWritten by `{command}` on {date.today()}: {machine}.\n\n"
            f"{table(COLUMNS, [row(name, *each) for name, each in found.items()])}\n\n"
            f"{table(['scheduler', 'time', 'p50', 'p99', 'p99.9', 'longest'], timings)}\n",
            encoding="utf-8",
        )


if __name__ == "__main__":
    main()
