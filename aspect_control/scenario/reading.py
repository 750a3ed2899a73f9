"""Reading a scenario file, with errors that name the field and what is allowed."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from ..exceptions import ScenarioError
from ..resources import scenario_paths
from .scenario import Scenario
from .sections import (
    CircleSection,
    HoldSection,
    LimitsSection,
    LineSection,
    RobotSection,
    SimulationSection,
    StartSection,
    WaypointsSection,
)

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


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
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"cannot read scenario {path}: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path} is not valid TOML: {error}") from None
    for setting in settings:
        _apply(content, setting)
    try:
        return Scenario.model_validate({**content, "folder": file.parent})
    except ValidationError as error:
        raise ScenarioError(f"{path}: " + "; ".join(_explain(each, content) for each in error.errors())) from None


def _find(path: str | Path) -> Path:
    file = Path(path)
    if file.is_file():
        return file
    shipped = scenario_paths()
    if str(path) in shipped:
        return shipped[str(path)]
    nearest = difflib.get_close_matches(str(path), shipped, n=3, cutoff=0.5)
    hint = f"did you mean {', '.join(map(repr, nearest))}? " if nearest else ""
    raise ScenarioError(f"no such scenario file: {path}; {hint}shipped scenarios: {', '.join(sorted(shipped))}")


def _apply(content: dict[str, Any], setting: str) -> None:
    key, separator, text = setting.partition("=")
    if not separator or not all(key.split(".")):
        raise ScenarioError(f"a setting must be field=value, such as controller.kp=200; got {setting!r}")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text
    first, *rest = key.split(".")
    if first == "controller" and rest:
        laws = content.get("controllers", [])
        if len(rest) == 2:
            known = [law.get("label", law.get("name")) for law in laws]
            laws = [law for law, label in zip(laws, known, strict=True) if label == rest[0]]
            if not laws:
                raise ScenarioError(f"{setting!r}: the scenario has no controller {rest[0]!r}; it has {known}")
        for law in laws:
            law[rest[-1]] = value
        return
    table = content
    for part in [first, *rest][:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise ScenarioError(f"{setting!r}: {part!r} is no table")
    table[[first, *rest][-1]] = value


def _explain(error: Mapping[str, Any], content: Mapping[str, Any]) -> str:
    # The discriminator of a union stands in the location although it is no field of the file.
    location = [part for part in error["loc"] if part not in ("line", "circle", "hold", "waypoints")]
    field = ".".join(str(part) for part in location) or "the file"
    if error["type"] == "extra_forbidden":
        allowed = _fields(location[:-1], content)
        nearest = difflib.get_close_matches(str(location[-1]), allowed, n=1)
        hint = f", did you mean {nearest[0]!r}?" if nearest else ""
        return f"unknown field {field!r}{hint} allowed: {', '.join(allowed)}"
    if error["type"].startswith("union_tag"):
        given = content["trajectory"].get("kind")
        return f"{field}.kind: must be 'line', 'circle', 'hold' or 'waypoints', got {given!r}"
    message = error["msg"].removeprefix("Value error, ")
    given = "" if error["type"] in ("missing", "value_error") else f", got {error['input']!r}"
    return f"{field}: {message}{given}"


def _fields(location: Sequence[Any], content: Mapping[str, Any]) -> list[str]:
    """Return the fields that the table at `location` may have."""
    sections: dict[str, type[BaseModel]] = {
        "robot": RobotSection,
        "start": StartSection,
        "simulation": SimulationSection,
        "limits": LimitsSection,
    }
    kinds: dict[Any, type[BaseModel]] = {
        "line": LineSection,
        "circle": CircleSection,
        "hold": HoldSection,
        "waypoints": WaypointsSection,
    }
    if not location:
        return [name for name in Scenario.model_fields if name != "folder"]
    if location[0] == "trajectory":
        return list(kinds[content["trajectory"].get("kind")].model_fields)
    return list(sections[str(location[0])].model_fields)
