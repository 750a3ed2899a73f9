"""Reading a scenario file, and changing what it holds, with errors that name the field and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..checks import file_path, unicode_text
from ..exceptions import ScenarioError, shown
from ..resources import scenario_paths
from .explanation import Form
from .scenario import Scenario
from .sections import ControllerSection, GuardSection, LimitsSection, RobotSection, SimulationSection, StartSection
from .toml_file import parse_toml, read_toml, require_shallow

SCENARIO_FORM = Form(
    Scenario,
    {
        "robot": RobotSection,
        "start": StartSection,
        "guard": GuardSection,
        "simulation": SimulationSection,
        "limits": LimitsSection,
    },
    ("controllers", "events", "trajectory"),
    (ControllerSection,),
)
"""What a scenario file may hold."""


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
    content = read_toml(file, "scenario", ScenarioError)
    if isinstance(settings, str) or not isinstance(settings, Sequence):
        raise ScenarioError(f"settings must be a list of field=value, got {shown(settings)}")
    for setting in settings:
        _apply(content, *_parse_setting(unicode_text("a setting", setting, ScenarioError)))
    require_shallow(path, content, ScenarioError)
    if "folder" in content:
        raise ScenarioError(f"{path}: unknown field 'folder'; allowed: {', '.join(SCENARIO_FORM.fields())}")
    return _validated(str(path), {**content, "folder": file.parent})


def changed(name: str, scenario: Scenario, changes: Mapping[str, Any], **sections: Any) -> Scenario:
    """Return a scenario with other values in some of its fields.

    Args:
        name: What the scenario is called, for the error.
        scenario: The scenario.
        changes: New values by the names of the fields, as in the settings of `load_scenario`.
        sections: Whole sections that take the place of the scenario's own.

    Raises:
        ScenarioError: If there is no such field, or a value does not fit.
    """
    content = {**scenario.model_dump(exclude_unset=True), **sections}
    for field, value in changes.items():
        _apply(content, field, value)
    return _validated(name, content)


def _validated(name: str, content: Mapping[str, Any]) -> Scenario:
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise ScenarioError(f"{name}: {SCENARIO_FORM.explain(error)}") from None


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


def _parse_setting(setting: str) -> tuple[str, Any]:
    """Return the field of a setting and its value."""
    field, separator, text = setting.partition("=")
    if not separator or not all(part.strip() for part in field.split(".")) or "\n" in text:
        raise ScenarioError(f"a setting must be field=value, such as controller.kp=200; got {shown(setting)}")
    try:
        return field, parse_toml(f"value = {text}")["value"]
    except ValueError:
        return field, text.strip()


def _apply(content: dict[str, Any], field: str, value: Any) -> None:
    """Set a field of a scenario's tables."""
    parts = [part.strip() for part in field.split(".")]
    tables = [content]
    if parts[0] == "controller" and len(parts) > 1:
        parts = parts[1:]
        tables = _laws(content, parts[:-1], field)
    else:
        for part in parts[:-1]:
            tables = [tables[0].setdefault(part, {})]
            if not isinstance(tables[0], dict):
                raise ScenarioError(f"{field!r}: {part!r} is no table")
    for table in tables:
        table[parts[-1]] = value


def _laws(content: Mapping[str, Any], label: Sequence[str], field: str) -> list[dict[str, Any]]:
    """Return the tables of all laws, or of the one with a label."""
    laws = content.get("controllers", [])
    if not isinstance(laws, list) or not all(isinstance(law, dict) for law in laws):
        raise ScenarioError(f"{field!r}: 'controllers' must be tables, [[controllers]], got {shown(laws)}")
    if not label:
        return laws
    known = [law.get("label", law.get("name")) for law in laws]
    found = [law for law, each in zip(laws, known, strict=True) if [each] == list(label)]
    if not found:
        raise ScenarioError(f"{field!r}: the scenario has no controller {'.'.join(label)!r}; it has {known}")
    return found
