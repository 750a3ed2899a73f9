"""Running the random motions, over several processes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from ...checks import whole_number
from ...simulation import completed, simulate
from ...trajectories import StraightLine
from .experiment import Experiment
from .outcome import Outcome, SampleOutcome, outcome, sample_outcome
from .parallel import processes
from .result import FINER, HypothesisResult

MAX_SAMPLES = 10_000_000
"""The most motions of one run."""

MAX_WORKERS = 1024
"""The most processes of one run."""

_TIMED_SAMPLES = 40
"""Samples of each law that are run to tell how long the whole takes."""


def examine_hypothesis(
    experiment: Experiment,
    samples: int,
    *,
    workers: int = 1,
    keep: Callable[[HypothesisResult], None] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> HypothesisResult:
    """Run the laws of an experiment on random motions and pick counterexamples to the hypothesis.

    With more than one worker a script of yours must call this under `if __name__ == "__main__":`, since the processes
    are spawned. The result does not depend on their number.

    Args:
        experiment: The arm, the laws and the seed.
        samples: Number of random motions.
        workers: Number of processes; 1 for none but this one.
        keep: Called with all that is computed so far after every sample, and at the end with the counterexamples.
        progress: Called with what is being done and the part of all work that is done, 0 to 1.

    Raises:
        ParameterError: If `samples` or `workers` is not a whole number of at least 1.
        WorkerError: If a worker process ended by itself.
        AspectControlError: If a law cannot start.
    """
    _require_counts(samples, workers)
    report = progress or (lambda label, part: None)
    found: dict[int, SampleOutcome] = {}
    result = HypothesisResult(experiment, samples, ())
    report(f"0 of {samples} samples", 0.0)
    with processes(experiment, min(workers, samples)) as spread:
        for sample in spread(sample_outcome, range(samples)):
            found[sample.index] = sample
            result = replace(result, samples=tuple(found[index] for index in sorted(found)))
            report(f"{len(found)} of {samples} samples", len(found) / samples)
            if keep is not None:
                keep(result)
        report(f"counterexamples at a time step {FINER} times shorter", 1.0)
        clearest = result.clearest()
        tasks = [(each.outcome.law, each.index, each.outcome.peak_torque, each.outcome.peak_ratio) for each in clearest]
        finer = {(law, index): again for law, index, again in spread(_finer, tasks)}
    checked = (replace(each, finer=finer[each.outcome.law, each.index]) for each in clearest)
    result = replace(result, counterexamples=tuple(checked))
    if keep is not None:
        keep(result)
    return result


def time_estimate(experiment: Experiment, samples: int, workers: int) -> float:
    """Return how long `examine_hypothesis` is going to take at most, s, from timing the first steps of each law.

    Runs that end early take less.

    Raises:
        ParameterError: If `samples` or `workers` is not a whole number of at least 1.
    """
    _require_counts(samples, workers)
    draw, own, dt = experiment.draw(0), experiment.own_line, experiment.dt
    duration = min(_TIMED_SAMPLES * dt, draw.line.duration)
    line = StraightLine(draw.line.displacement * (duration / draw.line.duration) ** 2, duration, draw.line.profile)
    started = time.perf_counter()
    for label, law in experiment.setup.laws.items():
        outcome(label, completed(simulate(law, line, q0=draw.q0, dt=dt, events=())), None)
    per_second = (time.perf_counter() - started) / duration
    return per_second * own.duration * samples / max(1, min(workers, samples))


def _require_counts(samples: int, workers: int) -> None:
    whole_number("samples", samples, 1, MAX_SAMPLES)
    whole_number("workers", workers, 1, MAX_WORKERS)


def _finer(experiment: Experiment, task: tuple[str, int, float, float | None]) -> tuple[str, int, Outcome]:
    """Run a law on a sample again at a shorter sampling time, held against the same reference."""
    law, index, peak, ratio = task
    run: Any = experiment.run(index, law, experiment.dt / FINER)
    return law, index, outcome(law, run, None if not ratio else peak / ratio)
