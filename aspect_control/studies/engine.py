"""The runs of a study, spread over processes or machines by joblib, chunk by chunk."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ..checks import known_name, whole_number
from ..exceptions import ParameterError, WorkerError, shown
from .identity import require_identity
from .rows import make_row, to_table
from .shards import ShardFolder, failed_runs
from .study import Study
from .study_progress import StudyProgress
from .warm import become_worker, warm_up

if TYPE_CHECKING:
    import pyarrow as pa

ENGINES = ("loky", "dask")
"""What spreads the work: processes of this machine, or a Dask cluster."""

MOST_WORKERS = 1024
"""The most processes on one machine."""

SECONDS_TO_CONNECT = 10
"""How long the scheduler of a cluster may take to answer, s."""

ProgressCallback: TypeAlias = Callable[[StudyProgress], None]
Row: TypeAlias = dict[str, Any]

_one_at_a_time = threading.Lock()
_studies: dict[str, Study] = {}
"""What this worker has built, by hash."""


def run_study(
    study: Study,
    out: str | Path | None,
    *,
    workers: int,
    engine: str,
    scheduler: str | None,
    shard: str | None,
    resume: bool,
    progress: ProgressCallback | None,
) -> pa.Table:
    """Make the runs of a study; see `Study.run`."""
    import pyarrow as pa

    known_name(engine, ENGINES, "engine")
    whole_number("workers", workers, 1, MOST_WORKERS)
    if (engine == "dask") != (scheduler is not None):
        raise ParameterError(
            f"a Dask cluster needs engine='dask' and scheduler='tcp://HOST:PORT', got {engine!r} and {shown(scheduler)}"
        )
    chosen = study.chunks_of(shard)
    folder = None if out is None else ShardFolder(study, out)
    there = folder.finished(chosen) if folder is not None and resume else {}
    missing = [chunk for chunk in chosen if chunk not in there]
    tables: dict[int, pa.Table] = {}
    if missing:
        study.require_buildable()
        if folder is not None:
            folder.begin()
            folder.clear(missing)
        count = Count(study, chosen, there, progress)
        with spread(study, missing, workers, engine, scheduler) as results:
            for chunk, rows in results:
                table = to_table(study, rows)
                if folder is None:
                    tables[chunk] = table
                else:
                    folder.write(chunk, table)
                count.add(table)
    if folder is not None:
        return folder.table()
    return pa.concat_tables([tables[chunk] for chunk in sorted(tables)])


class Count:
    """What is done, told after every chunk."""

    def __init__(
        self, study: Study, chunks: Sequence[int], there: dict[int, int], tell: ProgressCallback | None
    ) -> None:
        """Count what is there already."""
        self._total = sum(len(study.rows_of(chunk)) for chunk in chunks)
        self._done, self._failed, self._made = sum(len(study.rows_of(chunk)) for chunk in there), sum(there.values()), 0
        self._started, self._tell = time.monotonic(), tell
        self._report()

    def add(self, table: pa.Table) -> None:
        """Count a chunk that was made."""
        self._done, self._made = self._done + table.num_rows, self._made + table.num_rows
        self._failed += failed_runs(table)
        self._report()

    def _report(self) -> None:
        if self._tell is not None:
            seconds = time.monotonic() - self._started
            self._tell(StudyProgress(self._total, self._done, self._failed, self._made, seconds))


@contextmanager
def spread(
    study: Study, chunks: Sequence[int], workers: int, engine: str, scheduler: str | None
) -> Iterator[Iterator[tuple[int, list[Row]]]]:
    """Yield the rows of the chunks as they come in; nothing is left running when the block ends, however it ends.

    Raises:
        WorkerError: If a worker process ended by itself, or the scheduler is not there or died.
    """
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky.process_executor import BrokenProcessPool

    warm_up()  # fills the cache of compiled kernels before the workers read it
    parent = None if engine == "dask" else os.getpid()
    here = parallel_config("loky", n_jobs=min(workers, len(chunks)), inner_max_num_threads=1)
    with _cluster(scheduler) if engine == "dask" else here:
        parallel = Parallel(return_as="generator_unordered", batch_size=1)
        results = parallel(delayed(make_chunk)(study, chunk, parent) for chunk in chunks)
        try:
            yield results
        except BrokenProcessPool as error:
            raise WorkerError("a worker process ended by itself; give fewer workers if memory is short") from error
        finally:
            results.close()


def make_chunk(study: Study, chunk: int, parent: int | None) -> tuple[int, list[Row]]:
    """Make the runs of a chunk in a worker.

    Args:
        study: The study.
        chunk: Number of the chunk.
        parent: Number of the process that started the worker; None in a cluster.

    Raises:
        StudyError: If this worker has other robots, or another version of them.
    """
    become_worker(parent)
    warm_up()
    with _one_at_a_time:  # laws, and Pinocchio's data, serve one run at a time
        if study.hash not in _studies:
            require_identity(study)
            _studies[study.hash] = study
        known = _studies[study.hash]
        return chunk, [make_row(known, row) for row in known.rows_of(chunk)]


@contextmanager
def _cluster(address: str | None) -> Iterator[None]:
    """Send joblib's work to a Dask cluster for as long as the block lasts."""
    try:
        from distributed import Client, KilledWorker
        from distributed.client import FutureCancelledError
    except ImportError as error:
        raise WorkerError("the engine 'dask' needs Dask: pip install 'aspect-control[cluster]'") from error
    from joblib import parallel_config

    with _silent("distributed"):  # what is wrong is told once, here
        try:
            client = Client(address, timeout=SECONDS_TO_CONNECT)  # type: ignore[no-untyped-call]
        except (OSError, ValueError) as error:
            raise WorkerError(f"no scheduler of a Dask cluster answers at {address}: {error}") from error
        try:
            with client, parallel_config(_cluster_backend(client)):
                yield
        except TimeoutError as error:
            raise WorkerError(f"the cluster at {address} has no workers: {error}") from error
        except (FutureCancelledError, KilledWorker, OSError) as error:
            raise WorkerError(f"the cluster at {address} is gone, what it had computed stays: {error}") from error


def _cluster_backend(client: Any) -> Any:
    """Return joblib's backend for a cluster, also for one with a single worker, to which joblib would send nothing."""
    from joblib._dask import DaskDistributedBackend

    class Backend(DaskDistributedBackend):  # type: ignore[misc]
        def effective_n_jobs(self, n_jobs: int) -> int:
            return max(2, int(super().effective_n_jobs(n_jobs)))

    return Backend(client=client, wait_for_workers_timeout=SECONDS_TO_CONNECT)


@contextmanager
def _silent(package: str) -> Iterator[None]:
    """Keep the loggers of a package quiet for as long as the block lasts."""
    names = [name for name in logging.root.manager.loggerDict if f"{name}.".startswith(f"{package}.")]
    levels = {logger: logger.level for logger in map(logging.getLogger, names)}
    for logger in levels:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)
