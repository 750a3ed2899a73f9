"""The command line: parse, call, print. Each module holds the commands about one thing."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

__all__ = ["INTERRUPTED", "main"]

INTERRUPTED = 130
"""Exit status of a command that was interrupted from the keyboard."""


def main() -> None:
    """Run the command line.

    Bad input ends in one line on standard error and exit status 2, Ctrl-C in exit status 130, also while the package is
    still being imported: nothing is imported before this function that takes any time.
    """
    with _noted_interruptions() as interruptions:
        try:
            from .commands import run

            status = run()
        except BaseException:
            # What calls back into Python, such as pydantic, may turn an interruption into an error of its own.
            if not interruptions:
                raise
            status = INTERRUPTED
    if interruptions and status != 0:
        status = INTERRUPTED
        sys.stderr.write("aspect-control: interrupted; what was written stays\n")
    sys.exit(status)


@contextmanager
def _noted_interruptions() -> Iterator[list[int]]:
    """Yield a list to which every Ctrl-C adds the number of its signal, besides raising `KeyboardInterrupt`."""
    interruptions: list[int] = []

    def note(number: int, frame: Any) -> None:
        interruptions.append(number)
        signal.default_int_handler(number, frame)

    def repeat(unraisable: Any) -> None:
        # It came while Python called what cannot raise, as it does in every import, and must come once more.
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            again = threading.Timer(0.02, signal.raise_signal, [signal.SIGINT])
            again.daemon = True
            again.start()
        else:
            usual_hook(unraisable)

    usual_hook, usual_handler = sys.unraisablehook, signal.getsignal(signal.SIGINT)
    sys.unraisablehook = repeat
    # Left alone where it is ignored, as in a shell's background job, and settable in the main thread only.
    if usual_handler is signal.default_int_handler:
        with suppress(ValueError):
            signal.signal(signal.SIGINT, note)
    try:
        yield interruptions
    finally:
        sys.unraisablehook = usual_hook
        if signal.getsignal(signal.SIGINT) is note:
            signal.signal(signal.SIGINT, usual_handler)
