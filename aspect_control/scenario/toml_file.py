"""TOML files, read with errors of our own."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from ..exceptions import AspectControlError

MAX_DEPTH = 32
"""How many levels of tables and lists a file may have; a scenario needs six."""


def read_toml(path: Path, kind: str, error: type[AspectControlError]) -> dict[str, Any]:
    """Read a TOML file.

    Args:
        path: The file.
        kind: What it is, for the errors, such as `"scenario"`.
        error: The class of the errors.

    Raises:
        AspectControlError: Of the class `error`, if it cannot be read, is no TOML or is nested too deep.
    """
    try:
        content = parse_toml(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise error(f"cannot read {kind} {path}: {problem.strerror or problem}") from problem
    except UnicodeDecodeError as problem:
        raise error(f"cannot read {kind} {path}: {problem}") from problem
    except ValueError as problem:
        raise error(f"{path} is not valid TOML: {problem}") from None
    return content


def require_shallow(path: object, content: Any, error: type[AspectControlError]) -> None:
    """Make sure that a file has no more levels of tables and lists than `MAX_DEPTH`.

    Raises:
        AspectControlError: Of the class `error`, if it has.
    """
    level = [content]
    for _ in range(MAX_DEPTH + 1):
        level = [each for each in level if isinstance(each, (dict, list))]
        level = [inner for each in level for inner in (each.values() if isinstance(each, dict) else each)]
    if any(isinstance(each, (dict, list)) for each in level):
        raise error(f"{path} is nested more than {MAX_DEPTH} levels deep")


def parse_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises:
        ValueError: If it is none, or has a number of too many digits or too many levels.
    """
    try:
        content: dict[str, Any] = tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    return content
