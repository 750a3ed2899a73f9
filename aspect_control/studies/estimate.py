"""How long a study is going to take."""

from __future__ import annotations

import math
import time

from ..simulation import Sample
from .study import Study
from .warm import warm_up

TIMED_SAMPLES = 60
"""Samples of each law that are run to tell how long the whole takes."""

MOST_CASES = 200
"""The most cases of a scenario whose motions are looked at, evenly spread over the grid."""


class _EnoughTimedError(Exception):
    """Enough samples were timed."""


def time_estimate(study: Study, workers: int) -> float:
    """Return how long a study is going to take at most, s, from timing the first steps of each law.

    Runs that end early take less. Motions are taken to be as long as the first one.

    Args:
        study: The study.
        workers: Number of processes.

    Raises:
        AspectControlError: If something cannot be built, or a law cannot start.
    """
    warm_up()
    seconds = 0.0
    for scenario in study.scenarios:
        costs = {law: _seconds_a_sample(study, scenario, law) for law in study.laws(scenario)}
        cases = study.cases(scenario)
        looked_at = cases[:: math.ceil(len(cases) / MOST_CASES)]
        for case in looked_at:
            setup, motion = study.setup(scenario, case.point), study.motion(scenario, 0, case.point)
            samples = motion.trajectory.duration / setup.dt + 1.0
            seconds += costs[case.law] * samples * len(cases) / len(looked_at)
    return seconds * study.motions / max(1, min(workers, study.chunks))


def _seconds_a_sample(study: Study, scenario: str, law: str) -> float:
    setup, motion = study.setup(scenario), study.motion(scenario, 0)
    count = 0

    def watch(sample: Sample) -> None:
        nonlocal count
        count += 1
        if count == TIMED_SAMPLES:
            raise _EnoughTimedError

    started = time.perf_counter()
    motion.simulate(setup, law, watch=watch).metrics()
    return (time.perf_counter() - started) / count
