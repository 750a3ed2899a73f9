"""Work that is spread over processes, and what is kept of it if it is interrupted."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any, Protocol, TypeVar

from ...exceptions import WorkerError

Item = TypeVar("Item")
Result = TypeVar("Result")

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

_state: Any = None
"""What the tasks of this worker process share."""


class Spread(Protocol):
    """Yields task(state, item) for every item of an iterable, as the results come in."""

    def __call__(self, task: Callable[[Any, Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        """Start the work; `task` is a function of a module."""


@contextmanager
def processes(state: Any, workers: int) -> Iterator[Spread]:
    """Share work among processes for as long as the block lasts.

    They are spawned, not forked, with one thread of BLAS each. No more items are taken than the processes are busy
    with, so that an interrupt from the keyboard costs at most the results under way.

    Args:
        state: What all calls share; each process gets a copy once.
        workers: Number of processes; 1 for none but this one.

    Yields:
        A function of a task and its items.

    Raises:
        WorkerError: If a process ended by itself, for want of memory for example.
    """
    if workers == 1:
        yield lambda task, items: (task(state, item) for item in items)
        return

    def spread(task: Callable[[Any, Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        pending: set[Future[Result]] = set()
        for item in items:
            pending.add(pool.submit(_call, task, item))
            if len(pending) > workers:
                done, pending = wait(pending, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        yield from (future.result() for future in as_completed(pending))

    with (
        _one_thread_each(),
        ProcessPoolExecutor(workers, get_context("spawn"), initializer=_start, initargs=(state,)) as pool,
    ):
        try:
            yield spread
        except BrokenProcessPool as error:
            raise WorkerError("a worker process ended by itself; give fewer workers if memory is short") from error
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _start(state: Any) -> None:
    global _state
    _state = state
    # The keyboard interrupts all processes at once: this one dies without a word, the parent tells. A background job of
    # a shell has been told to ignore it, and so do its workers.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def _call(task: Callable[[Any, Any], Any], item: Any) -> Any:
    return task(_state, item)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Keep BLAS in the processes that are started inside the block to one thread each."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
