"""Functions of arrays that are compiled by Numba when they are first needed, and kept on disk from then on."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property, lru_cache, update_wrapper
from inspect import signature
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

VECTOR = "float64[::1]"
"""Type of a compiled function's argument: a vector."""

MATRIX = "float64[:, ::1]"
"""Type of a compiled function's argument: a matrix, in C order when it arrives."""

TENSOR = "float64[:, :, :]"
"""Type of a compiled function's argument: three indices, in any order."""

STACK = "float64[:, :, ::1]"
"""Type of a compiled function's argument: matrices of one shape, in C order when it arrives."""

NUMBER = "float64"
"""Type of a compiled function's argument: a number."""

INDICES = "Array(int64, 2, 'C', readonly=True)"
"""Type of a compiled function's argument: a table of indices, which is not written to."""

COUNT = "int64"
"""Type of a compiled function's argument: a whole number."""


def compiled(*arguments: str) -> Callable[[F], F]:
    """Compile a function of arrays for exactly these argument types, but not before it is first called.

    Numba takes longer to import than the rest of the package, so that it is imported then too. `prepared` compiles
    ahead of time. Every function has one compiled version: arrays of another order or type are converted on the way
    in, and no call compiles anything after the first.

    The machine code is kept beside the package or, where that cannot be written to, in the user's cache folder, in a
    folder that is named after the source text of this package: other text never meets old machine code.

    Args:
        *arguments: Numba's names of the argument types.
    """

    def decorate(function: F) -> F:
        return cast(F, Compiled(function, arguments))

    return decorate


def prepared(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that `compiled` made, or load it, so that its next call does not wait for it.

    Args:
        function: The function.

    Returns:
        The compiled function itself, for callers that make sure of the types: it converts no argument and takes 0.2 µs
        less. A function that is not compiled comes back as it is.
    """
    return cast(Callable[..., Any], function.dispatcher) if isinstance(function, Compiled) else function


def is_any_kept() -> bool:
    """Return whether machine code of this source text is on disk; if not, the first law takes its time."""
    folder = _machine_code()
    return folder is not None and any(folder.glob("**/*.nbi"))


class Compiled:
    """A function with its compiled version, which other compiled functions call directly.

    Attributes:
        argument_types: Numba's names of the types of its arguments.
    """

    def __init__(self, function: Callable[..., Any], arguments: tuple[str, ...]) -> None:
        """Keep a function and the types of its arguments."""
        update_wrapper(self, function)
        self._function = function
        self.argument_types = arguments

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Call the compiled function."""
        dispatcher = self.dispatcher
        if named:
            arguments = signature(self._function).bind(*arguments, **named).args
        try:
            return dispatcher(*arguments)
        except TypeError:
            return dispatcher(*map(_converted, arguments, self.argument_types))

    @cached_property
    def dispatcher(self) -> Any:
        """The compiled function of Numba."""
        import numba

        types = f"({', '.join(self.argument_types)},)"
        with _cache_folder() as folder:
            compile_ = numba.njit(types, cache=folder is not None, error_model="numpy")
            return compile_(self._function)

    @property
    def _numba_type_(self) -> Any:
        return self.dispatcher._numba_type_

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        # What Numba tells kept machine code by, where a compiled function calls another that it was handed: the name
        # and the text of the file.
        text = Path(self._function.__code__.co_filename).read_bytes()
        return str, (f"{self._function.__module__}.{self._function.__qualname__} {hashlib.sha256(text).hexdigest()}",)


def _converted(value: Any, argument: str) -> Any:
    if argument in (NUMBER, COUNT):
        return float(value) if argument == NUMBER else int(value)
    if argument == INDICES:
        return np.ascontiguousarray(value, dtype=np.int64)
    return np.ascontiguousarray(value, dtype=np.float64)


@contextmanager
def _cache_folder() -> Iterator[Path | None]:
    """Point Numba to the folder for machine code; None if there is none that can be written to."""
    import numba

    config: Any = numba.config
    folder, chosen = _machine_code(), config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        yield folder
    finally:
        config.CACHE_DIR = chosen


@lru_cache(maxsize=1)
def _machine_code() -> Path | None:
    """Return the folder: of `NUMBA_CACHE_DIR` if that is set, of this package or of the user."""
    import numba

    here, chosen = Path(__file__).parent, cast(Any, numba.config).CACHE_DIR
    text = b"".join(file.read_bytes() for file in sorted(here.glob("*.py")))
    name = f"compiled-{hashlib.sha256(text).hexdigest()[:16]}"
    users = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    folders = [Path(chosen)] if chosen else [here / "__pycache__", Path(users) / "aspect-control"]
    return next((folder / name for folder in folders if _is_writable(folder / name)), None)


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
