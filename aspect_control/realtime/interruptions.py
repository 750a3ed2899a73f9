"""What else happens in a process while a loop runs: garbage collection and signals."""

from __future__ import annotations

import gc
import signal
import threading
from types import FrameType
from typing import Any


class GarbageCollectorOff:
    """Context in which Python's cyclic garbage collector does not run: its pauses are longer than many a sample.

    What exists when it begins is collected first and then frozen, so that no collection looks at it again. Cycles that
    are made inside are kept until the end: they cost memory, not time.

    Attributes:
        collections: How often the collector ran all the same, since code may call `gc.collect` itself.
    """

    def __init__(self) -> None:
        """Count from zero."""
        self.collections = 0

    def __enter__(self) -> GarbageCollectorOff:
        self._was_enabled, self._were_frozen = gc.isenabled(), gc.get_freeze_count() > 0
        gc.collect()
        gc.freeze()
        gc.disable()
        gc.callbacks.append(self._count)
        return self

    def __exit__(self, *_: object) -> None:
        gc.callbacks.remove(self._count)
        if not self._were_frozen:
            gc.unfreeze()
        if self._was_enabled:
            gc.enable()

    def _count(self, phase: str, info: dict[str, Any]) -> None:
        self.collections += phase == "start"


class StopSignals:
    """Context in which SIGINT and SIGTERM are noted, so that a loop can end in good order.

    A second signal does what it did before. In a thread that is not the main one signals stay as they are.

    Attributes:
        received: The signal that came; None before.
    """

    def __init__(self) -> None:
        """Wait for the first."""
        self.received: signal.Signals | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> StopSignals:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                # None is a handler that was not set from Python and could not be put back.
                if signal.getsignal(number) not in (signal.SIG_IGN, None):
                    self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def error(self) -> BaseException:
        """Return what the signal would have raised, to go on with once the loop has ended."""
        return KeyboardInterrupt() if self.received is signal.SIGINT else SystemExit(128 + int(self.received or 0))

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self.received is not None:
            signal.signal(number, self._before[number])
            signal.raise_signal(number)
        self.received = signal.Signals(number)
