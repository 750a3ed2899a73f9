"""Reading a scenario file, with errors that name the field and what is allowed."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from ..checks import file_path, unicode_text
from ..exceptions import ScenarioError, shown
from ..resources import scenario_paths
from .scenario import Scenario
from .sections import ControllerSection, LimitsSection, RobotSection, SimulationSection, StartSection

MAX_DEPTH = 32
"""How many levels of tables and lists a scenario may have; it needs six."""

_SECTIONS: dict[str, type[BaseModel]] = {
    "robot": RobotSection,
    "start": StartSection,
    "simulation": SimulationSection,
    "limits": LimitsSection,
}
_ALL_SECTIONS: tuple[type[BaseModel], ...] = (Scenario, ControllerSection, *_SECTIONS.values())
_WITH_FREE_NAMES = ("controllers", "events", "trajectory")
"""Sections whose keys are the parameters of something registered."""


def load_scenario(path: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """Read a scenario.

    Args:
        path: A TOML file, or the name of a scenario that ships with the package.
        settings: Changes as `field.field=value`, the value in TOML; `controller.x=value` sets a parameter of every law,
            `controller.jmdc.x=value` of one.

    Raises:
        ScenarioError: If the file is missing or malformed; the message names the field and what is allowed.
    """
    file = _find(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"cannot read scenario {path}: {error}") from error
    try:
        content = _parse(text)
    except ValueError as error:
        raise ScenarioError(f"{path} is not valid TOML: {error}") from None
    if isinstance(settings, str) or not isinstance(settings, Sequence):
        raise ScenarioError(f"settings must be a list of field=value, got {shown(settings)}")
    for setting in settings:
        _apply(content, unicode_text("a setting", setting, ScenarioError))
    if _depth(content) > MAX_DEPTH:
        raise ScenarioError(f"{path} is nested more than {MAX_DEPTH} levels deep")
    if "folder" in content:
        raise ScenarioError(f"{path}: unknown field 'folder'; allowed: {', '.join(_fields([]))}")
    try:
        return Scenario.model_validate({**content, "folder": file.parent})
    except ValidationError as error:
        raise ScenarioError(f"{path}: {_explain_all(error)}") from None


def _parse(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises:
        ValueError: If it is none, or has a number of too many digits or too many levels.
    """
    try:
        content: dict[str, Any] = tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    return content


def _depth(value: Any) -> int:
    """Return how many levels of tables and lists a value has, but not more than one above `MAX_DEPTH`."""
    level, depth = [value], 0
    while depth <= MAX_DEPTH:
        level = [each for each in level if isinstance(each, (dict, list))]
        if not level:
            break
        level = [inner for each in level for inner in (each.values() if isinstance(each, dict) else each)]
        depth += 1
    return depth


def _find(path: str | Path) -> Path:
    file, shipped = file_path("the scenario", path, ScenarioError), scenario_paths()
    unicode_text("the path of a scenario", str(file), ScenarioError)  # its name goes into the summary of its runs
    try:
        if file.is_file():
            return file
    except OSError as error:
        raise ScenarioError(f"cannot read scenario {path}: {error.strerror}") from error
    if str(path) in shipped:
        return shipped[str(path)]
    nearest = difflib.get_close_matches(str(path), shipped, n=3, cutoff=0.5)
    hint = f"did you mean {', '.join(map(repr, nearest))}? " if nearest else ""
    raise ScenarioError(f"no such scenario file: {path}; {hint}shipped scenarios: {', '.join(sorted(shipped))}")


def _apply(content: dict[str, Any], setting: str) -> None:
    key, separator, text = setting.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not separator or not all(parts) or "\n" in text:
        raise ScenarioError(f"a setting must be field=value, such as controller.kp=200; got {shown(setting)}")
    try:
        value = _parse(f"value = {text}")["value"]
    except ValueError:
        value = text.strip()
    tables = [content]
    if parts[0] == "controller" and len(parts) > 1:
        parts = parts[1:]
        tables = _laws(content, parts[:-1], setting)
    else:
        for part in parts[:-1]:
            tables = [tables[0].setdefault(part, {})]
            if not isinstance(tables[0], dict):
                raise ScenarioError(f"{setting!r}: {part!r} is no table")
    for table in tables:
        table[parts[-1]] = value


def _laws(content: Mapping[str, Any], label: Sequence[str], setting: str) -> list[dict[str, Any]]:
    """Return the tables of all laws, or of the one with a label."""
    laws = content.get("controllers", [])
    if not isinstance(laws, list) or not all(isinstance(law, dict) for law in laws):
        raise ScenarioError(f"{setting!r}: 'controllers' must be tables, [[controllers]], got {shown(laws)}")
    if not label:
        return laws
    known = [law.get("label", law.get("name")) for law in laws]
    found = [law for law, each in zip(laws, known, strict=True) if [each] == list(label)]
    if not found:
        raise ScenarioError(f"{setting!r}: the scenario has no controller {'.'.join(label)!r}; it has {known}")
    return found


def _explain_all(error: ValidationError) -> str:
    """Put all errors into one line; those of one field, which has alternatives, are joined."""
    by_field: dict[str, list[str]] = {}
    for each in error.errors():
        field, message = _explain(each)
        by_field.setdefault(field, []).append(message)
    return "; ".join(field + " or".join(dict.fromkeys(messages)) for field, messages in by_field.items())


def _explain(error: Mapping[str, Any]) -> tuple[str, str]:
    """Return the field that an error is about, and what is wrong with it, to be written behind the field."""
    unknown = error["type"] == "extra_forbidden"
    *tables, last = error["loc"] or ("",)
    location = [*_field_location(tables), last] if unknown else _field_location(error["loc"])
    field = ".".join(str(part) for part in location) or "the file"
    if unknown:
        allowed = _fields(location[:-1])
        nearest = difflib.get_close_matches(str(location[-1]).lower(), allowed, n=1)
        hint = f", did you mean {nearest[0]!r}?" if nearest else ";"
        return f"unknown field {field!r}", f"{hint} allowed: {', '.join(allowed)}"
    if error["type"] in ("model_type", "model_attributes_type"):
        return field, f": must be a table, got {shown(error['input'])}"
    message = error["msg"].removeprefix("Value error, ")
    given = "" if error["type"] in ("missing", "value_error") else f", got {shown(error['input'])}"
    return field, f": {message}{given}"


def _field_location(location: Sequence[Any]) -> list[Any]:
    """Leave out what pydantic adds to the path of a field to tell the alternatives of its type apart."""
    known = {name for section in _ALL_SECTIONS for name in section.model_fields}
    first, *rest = location or ("",)
    # Names that a file makes up stand below `locked` and as parameters of what is registered.
    free = first in _WITH_FREE_NAMES or rest[:1] == ["locked"]
    kept = [part for part in rest if isinstance(part, int) or part in known or free]
    return [part for part in (first, *kept) if part != ""] if location else []


def _fields(location: Sequence[Any]) -> list[str]:
    """Return the fields that the table at `location` may have."""
    if not location:
        return [name for name in Scenario.model_fields if name != "folder"]
    return list(_SECTIONS[str(location[0])].model_fields)
