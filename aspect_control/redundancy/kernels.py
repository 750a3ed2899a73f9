"""Functions of arrays that run as plain NumPy and, where the user asks for it, compiled by Numba from the same text."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import update_wrapper
from inspect import signature
from pathlib import Path
from types import CodeType
from typing import Any, TypeVar, cast

import numpy as np

F = TypeVar("F", bound=Callable[..., Any])

_ARRAYS = {"Vector": (1, np.float64), "Matrix": (2, np.float64), "Tensor": (3, np.float64), "Table": (2, np.int64)}
"""Dimensions and type of the arrays that a kernel may take, by the name of their annotation."""

_KERNELS: list[Kernel] = []


def kernel(function: F) -> F:
    """Mark a function of arrays and numbers as one that `compile_kernels` compiles.

    Its arguments are annotated as `Vector`, `Matrix`, `Tensor`, `Table`, `float` or `int`, which fixes the types that
    it is compiled for: no call compiles anything. It runs as it stands until then; one of a module that is imported
    after `compile_kernels` is compiled at once.

    Args:
        function: The function, of what Numba's nopython mode knows; it may call other kernels that stand above it.
    """
    made, was_asked_for = Kernel(function), bool(_KERNELS) and kernels_compiled()
    _KERNELS.append(made)
    if was_asked_for:
        made.compile()
    return cast(F, made)


def compile_kernels() -> None:
    """Compile every kernel of this process by Numba, the extra `fast`, from the text that otherwise runs as NumPy.

    A control tick then takes a third to two thirds of the time. Torques agree with those of NumPy to rounding, not to
    the last bit. The first call on a machine takes about half a minute; the machine code is kept in the user's cache
    folder, or in `NUMBA_CACHE_DIR`, and later calls load it in about a second. Another process asks for itself.

    Raises:
        ImportError: If Numba is not installed.
    """
    try:
        import numba  # noqa: F401
    except ImportError as error:
        raise ImportError("compile_kernels needs Numba: pip install 'aspect-control[fast]'") from error
    for each in _KERNELS:
        each.compile()


def kernels_compiled() -> bool:
    """Return whether `compile_kernels` was called in this process."""
    return all(each.is_compiled for each in _KERNELS)


class Kernel:
    """A function of arrays and the version of it that is called: its own text, or compiled.

    Attributes:
        text: The function as it stands.
        is_compiled: Whether the compiled version is the one that is called.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        """Keep a function."""
        update_wrapper(self, function)
        self.text = function
        self._call: Any = function
        self.is_compiled = False

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Call the function; a compiled one converts arrays of another order or type than it was compiled for."""
        try:
            return self._call(*arguments, **named)
        except TypeError:
            if not self.is_compiled:
                raise
            bound = signature(self.text).bind(*arguments, **named).arguments
            kinds = self.text.__annotations__
            return self._call(*(_converted(value, kinds[name]) for name, value in bound.items()))

    def compile(self) -> None:
        """Compile the function, with those that it calls, and call the compiled version from now on."""
        if not self.is_compiled:
            self._call, self.is_compiled = _compiled(self.text), True

    @property
    def _numba_type_(self) -> Any:
        # What Numba takes a global name for when it compiles the function of another kernel.
        self.compile()
        return self._call._numba_type_

    def __reduce__(self) -> str:
        """Pickle a kernel as the name of its function."""
        return self.text.__qualname__


def _compiled(function: Callable[..., Any]) -> Any:
    import numba

    kinds = [kind for name, kind in function.__annotations__.items() if name != "return"]
    config: Any = numba.config
    users, folder = config.CACHE_DIR, _cache_folder(function)
    config.CACHE_DIR = str(folder or "")
    try:
        decorate = numba.njit([tuple(map(_numba_type, kinds))], cache=folder is not None, error_model="numpy")
        return decorate(function)
    finally:
        config.CACHE_DIR = users


def _numba_type(kind: str) -> Any:
    from numba import types

    if kind not in _ARRAYS:
        return {"float": types.float64, "int": types.int64}[kind]
    dimensions, dtype = _ARRAYS[kind]
    # An array that may be written to is passed where one is asked for that may not, but not the reverse.
    return types.Array(types.float64 if dtype is np.float64 else types.int64, dimensions, "C", readonly=True)


def _converted(value: Any, kind: str) -> Any:
    if kind in _ARRAYS:
        return np.ascontiguousarray(value, dtype=_ARRAYS[kind][1])
    return float(value) if kind == "float" else int(value)


def _cache_folder(function: Callable[..., Any]) -> Path | None:
    """Return where machine code of a function is kept; None if nothing can be written there.

    Numba looks at the file of a function, not at those of the functions that it calls or of the constants that it takes
    from elsewhere: the folder is named after the code of all of them, without docstrings.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    users = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    folder = Path(chosen or Path(users) / "aspect-control") / f"kernel-{_digest(function)}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _digest(function: Callable[..., Any]) -> str:
    return hashlib.sha256(repr(_meaning(function)).encode()).hexdigest()[:16]


def _meaning(function: Any) -> tuple[Any, ...]:
    """Return the code of a function, with that of the kernels that it calls and the constants that it takes."""
    return _code(function.__code__, function.__doc__, function.__globals__)


def _code(code: CodeType, docstring: str | None, known: dict[str, Any]) -> tuple[Any, ...]:
    constants = [_code(each, None, known) if isinstance(each, CodeType) else each for each in code.co_consts]
    named = [(name, known[name]) for name in code.co_names if isinstance(known.get(name), (int, float, str, tuple))]
    called = [_meaning(known[name].text) for name in code.co_names if isinstance(known.get(name), Kernel)]
    return code.co_name, code.co_code, code.co_names, named, called, [each for each in constants if each != docstring]
