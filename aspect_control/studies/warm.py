"""What a process does once before its first run, so that no run waits for it."""

from __future__ import annotations

import os
import signal
import threading
import time
from functools import cache

from ..redundancy.kernels import compile_kernels


@cache
def warm_up() -> None:
    """Load the compiled kernels where Numba is installed."""
    try:
        compile_kernels()
    except ImportError:
        return


@cache
def become_worker(parent: int | None) -> None:
    """Make this process a good worker, unless it is the parent itself.

    BLAS is kept to one thread: the matrices of an arm are far below the size at which more would pay. A worker on the
    parent's own machine leaves Ctrl-C to the parent, which the keyboard interrupts, too, and ends within a second of
    the parent's death, even by `kill -9`.

    Args:
        parent: Number of the process that started it; None for a worker that belongs to a cluster.
    """
    from threadpoolctl import threadpool_limits

    if parent == os.getpid():
        return
    threadpool_limits(1)
    if parent is not None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)
