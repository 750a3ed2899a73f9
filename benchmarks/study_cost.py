"""Measure what a study costs: the efficiency of two workers, and the memory of each over many runs.

`python benchmarks/study_cost.py --help`, from a checkout with the extra `bench` installed.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from aspect_control import Study
from aspect_control.exceptions import AspectControlError
from aspect_control.files import atomic_path, output_folder, write_text
from aspect_control.studies import StudyProgress
from aspect_control.studies.rows import make_row, to_table
from aspect_control.views.progress import describe_progress, progress_bar

STUDY: dict[str, Any] = {
    "scenarios": ["planar3r"],
    "endings": ["diverged", "workspace-left", "tracking-lost"],
    "saturation": False,
    "laws": [
        {"name": "pseudoinverse"},
        {"name": "null-space-vector"},
        {"name": "modified-null-space-vector"},
        {"name": "jmdc"},
        {"name": "jmdc", "label": "jmdc-without-minor-measure", "kappa": 0.0},
    ],
}
"""Five laws on the planar arm; the random motions are added."""


def main(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path("results/bench"),
    motions: Annotated[int, typer.Option(min=40, help="Random motions of each law, 1,000 for the whole study.")] = 1000,
    rounds: Annotated[int, typer.Option(min=3, help="Rounds in which one and two workers take turns.")] = 15,
    memory_runs: Annotated[int, typer.Option(min=100, help="Runs over which the workers' memory is watched.")] = 10_000,
) -> None:
    """Measure a study of random motions with one worker and with two, in turn, and the memory of the workers."""
    folder = output_folder(out)
    with progress_bar() as progress:
        efficiency = _efficiency(rounds, lambda label, part: progress(label, 0.3 * part))
        seconds, runs = _whole(motions, lambda label, part: progress(label, 0.3 + 0.3 * part))
        memory = _memory(memory_runs, lambda label, part: progress(label, 0.6 + 0.4 * part))
        a_row, on_disk, in_memory = _table(folder)
    lines = [
        "# What a study costs",
        "",
        f"Measured by `python benchmarks/study_cost.py --motions {motions} --rounds {rounds} "
        f"--memory-runs {memory_runs}` on {len(os.sched_getaffinity(0))} processors: random motions of the planar arm "
        "under five laws, 2 s at 1 kHz, give or take.",
        "",
        "| what | measured | wanted |",
        "| --- | --- | --- |",
        f"| {runs:,} runs with two workers | {seconds / 60.0:.1f} min, {1e3 * seconds / runs:.0f} ms each | ≤ 10 min |",
        f"| rate of two workers over twice the rate of one, median of {rounds} rounds | {efficiency:.0%} | ≥ 90 % |",
        *(f"| {name} | {value} | {wanted} |" for name, value, wanted in memory),
        f"| time of the process that started the study for a row | {1e3 * a_row:.2f} ms | |",
        f"| a row of a chunk of 250, in its file and in memory | {on_disk:.0f} and {in_memory:.0f} bytes | |",
        "",
        *_ten_million(2.0 * seconds / runs, a_row, on_disk, in_memory),
        "",
    ]
    write_text(folder / "study-cost.md", "\n".join(lines))
    typer.echo("\n".join(lines))


def _study(motions: int, seed: int = 1) -> Study:
    return Study({**STUDY, "motions": {"random": motions, "seed": seed}}, "cost")


def _efficiency(rounds: int, progress: Any) -> float:
    """Return the rate of two workers over twice that of one: both are processes of their own, and take turns."""
    for workers in (1, 2):
        _rate(workers, seed=0)  # starts the processes, which then wait
    ratios = []
    for index in range(rounds):
        progress(f"one and two workers in turn, round {index + 1} of {rounds}", index / rounds)
        order = (1, 2) if index % 2 else (2, 1)
        rates = {workers: _rate(workers, seed=index + 1) for workers in order}
        ratios.append(rates[2] / (2.0 * rates[1]))
    return statistics.median(ratios)


def _rate(workers: int, seed: int) -> float:
    study = _study(16, seed)
    started = time.perf_counter()
    study.run(workers=workers)
    return study.runs / (time.perf_counter() - started)


def _whole(motions: int, progress: Any) -> tuple[float, int]:
    study = _study(motions)
    started = time.perf_counter()
    study.run(workers=2, progress=lambda told: progress(describe_progress(told), told.done / told.total))
    return time.perf_counter() - started, study.runs


def _memory(runs: int, progress: Any) -> list[tuple[str, str, str]]:
    """Return the resident memory of the largest worker a tenth of the way and at the end of many runs."""
    study, early, late = _study(-(-runs // 5), seed=2), 0, 0

    def watch(told: StudyProgress) -> None:
        nonlocal early, late
        progress(describe_progress(told), told.done / told.total)
        largest = max(map(_resident, _workers()), default=0)
        if told.done <= told.total // 10:
            early = max(early, largest)
        elif told.done >= told.total * 9 // 10:
            late = max(late, largest)

    study.run(workers=2, progress=watch)
    megabyte = 2**20
    return [
        (f"memory of a worker after {study.runs // 10:,} runs", f"{early / megabyte:.0f} MB", "≤ 300 MB"),
        (f"memory of a worker after {study.runs:,} runs", f"{late / megabyte:.0f} MB", "the same"),
    ]


def _table(folder: Path) -> tuple[float, float, float]:
    """Return what a row of a chunk costs the starting process, s, and its size in a file and in memory, bytes."""
    import pickle

    import pyarrow.parquet as pq

    study = _study(50, seed=3)
    sent = pickle.dumps([make_row(study, row) for row in range(study.runs)])
    started = time.perf_counter()
    rows = pickle.loads(sent)  # noqa: S301
    table = to_table(study, rows)
    with atomic_path(folder / "chunk.parquet") as temporary:
        pq.write_table(table, temporary)
    seconds = time.perf_counter() - started
    size = (folder / "chunk.parquet").stat().st_size
    (folder / "chunk.parquet").unlink()
    return seconds / len(rows), size / len(rows), table.nbytes / len(rows)


def _ten_million(a_run: float, a_row: float, on_disk: float, in_memory: float) -> list[str]:
    """Say what 10⁷ motions under five laws need, from the cost of a run on one processor and of a row."""
    runs = 5e7
    return [
        f"On paper, 10⁷ motions under five laws, 5·10⁷ runs, need {runs * a_run / 3600.0:,.0f} processor hours, "
        f"{runs * on_disk / 1e9:.0f} GB of files and {runs * in_memory / 1e9:.0f} GB of memory for the whole table. "
        f"One starting process keeps up with {a_run / a_row:,.0f} processors: it is the bottleneck, and then the "
        "memory for the whole table. With `--shard i/8` eight processes start an eighth each and keep up with "
        f"{8 * a_run / a_row:,.0f} processors, which make all runs in {runs * a_row / 8.0 / 3600.0:.1f} h."
    ]


def _workers() -> list[int]:
    """Return the processes that this one has started and that make runs."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return [int(each) for each in children if b"popen_loky" in Path(f"/proc/{each}/cmdline").read_bytes()]


def _resident(process: int) -> int:
    fields = Path(f"/proc/{process}/statm").read_text().split()
    return int(fields[1]) * os.sysconf("SC_PAGE_SIZE")


if __name__ == "__main__":
    try:
        typer.run(main)
    except AspectControlError as error:
        typer.echo(f"study_cost: error: {error}", err=True)
        sys.exit(2)
