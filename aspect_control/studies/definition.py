"""What a study file holds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from ..checks import file_path, known_name
from ..exceptions import AspectControlError, StudyError
from ..scenario import Scenario, changed, load_scenario
from ..scenario.explanation import Form
from ..scenario.sections import ControllerSection, Section, StartSection, TrajectorySection
from ..scenario.toml_file import read_toml, require_shallow
from ..simulation.events.registry import EVENTS

MOST_SAMPLES = 10_000_000
"""The most random motions of a study."""

MOST_POINTS = 100_000
"""The most grid points of a study."""

Grid = Annotated[dict[str, Any], Field(min_length=1)]


class GivenMotion(Section):
    """`[[motions.given]]`: a start and a trajectory, as in a scenario."""

    start: StartSection
    trajectory: TrajectorySection


class MotionsSection(Section):
    """`[motions]`: what the arms do; each scenario's own start and trajectory if the table is left out.

    Attributes:
        random: Number of motions drawn after each scenario's own straight line, see `RandomLines`.
        seed: Seed of the draws; a motion depends on it and on its number alone.
        legs: Number of points that a random motion leads to.
        given: Motions that every scenario's arm makes, in the place of its own.
    """

    random: Annotated[int, Field(ge=1, le=MOST_SAMPLES)] | None = None
    seed: Annotated[int, Field(ge=0)] = 0
    legs: Annotated[int, Field(ge=1, le=100)] = 1
    given: Annotated[list[GivenMotion], Field(default_factory=list)]

    @model_validator(mode="after")
    def _one_kind(self) -> MotionsSection:
        if self.random is not None and self.given:
            raise ValueError("give either 'random' or 'given'")
        return self

    @property
    def count(self) -> int:
        """Number of motions of a scenario at a grid point."""
        return self.random or len(self.given) or 1


class StudyDefinition(Section):
    """A whole study file.

    Attributes:
        description: What it is for, in a sentence.
        scenarios: Names or files of scenarios: each gives the arm, and what else the study does not say itself.
        motions: What the arms do.
        laws: The laws to run, as in a scenario; those of each scenario if left out.
        grid: Tables of lists: fields of the scenarios, named as for `--set`, and the values that they take. A table
            stands for every combination of its values; several tables follow one another.
        endings: Names of the events that end a run, among those of each scenario; left out for all of them.
        saturation: Whether the motors' limits of the scenarios hold.
        report: What `study report` makes of the table, one of `views.reports.report_files.REPORTS`.
        folder: Where the file is, for paths relative to it.
    """

    description: str = ""
    scenarios: Annotated[list[str], Field(min_length=1)]
    motions: Annotated[MotionsSection, Field(default_factory=lambda: MotionsSection.model_validate({}))]
    laws: Annotated[list[ControllerSection], Field(default_factory=list)]
    grid: Annotated[list[Grid], Field(default_factory=list)]
    endings: list[str] | None = None
    saturation: bool = True
    report: Literal["summary", "hypothesis", "survey", "comparison"] = "summary"
    folder: Path = Path()

    @model_validator(mode="after")
    def _grid_of_lists(self) -> StudyDefinition:
        for table in self.grid:
            for key, values in _flat(table):
                if not isinstance(values, list) or not values:
                    raise ValueError(f"grid: {key} must be a list of at least one value, got {values!r}")
        if self.number_of_points > MOST_POINTS:
            raise ValueError(f"grid: {self.number_of_points:,} points, at most {MOST_POINTS:,} are possible")
        for name in self.endings or []:
            try:
                known_name(name, EVENTS.available(), "event")
            except AspectControlError as error:
                raise ValueError(f"endings: {error}") from None
        return self

    @property
    def keys(self) -> tuple[str, ...]:
        """Fields of the scenarios that the grid changes, in the order of the file."""
        return tuple(dict.fromkeys(key for table in self.grid for key, _ in _flat(table)))

    @property
    def number_of_points(self) -> int:
        """Number of grid points, counted without making them."""
        return sum(math.prod(len(values) for _, values in _flat(table)) for table in self.grid) or 1

    def points(self) -> list[dict[str, Any]]:
        """Return the grid points: what each changes in the scenarios, by the names of the fields."""
        found = []
        for table in self.grid or [{}]:
            axes = dict(_flat(table))
            found += [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
        return found

    def load_scenarios(self) -> dict[str, Scenario]:
        """Return the scenarios by name, with the laws and the saturation of the study.

        Raises:
            StudyError: If one is given twice.
            ScenarioError: If one cannot be read.
        """
        scenarios: dict[str, Scenario] = {}
        for given in self.scenarios:
            name = Path(given).stem
            if name in scenarios:
                raise StudyError(f"scenarios: {name!r} is given twice; the rows of a table are told apart by this name")
            beside = self.folder / given
            scenario = load_scenario(beside if beside.is_file() else given)
            parts: dict[str, Any] = {"controllers": self.laws} if self.laws else {}
            if not self.saturation:
                parts["simulation"] = scenario.simulation.model_copy(update={"saturation": None})
            scenarios[name] = changed(name, scenario, {}, **parts)
        return scenarios


STUDY_FORM = Form(
    StudyDefinition,
    {"motions": MotionsSection},
    ("laws", "grid"),
    (GivenMotion, StartSection, TrajectorySection, ControllerSection),
)
"""What a study file may hold."""


def read_definition(path: str | Path) -> StudyDefinition:
    """Read a study file.

    Args:
        path: A TOML file.

    Raises:
        StudyError: If the file is missing or malformed; the message names the field and what is allowed.
    """
    file = file_path("the study", path, StudyError)
    content = read_toml(file, "study", StudyError)
    require_shallow(path, content, StudyError)
    return define(str(path), content, file.parent)


def define(name: str, content: Mapping[str, Any], folder: Path = Path()) -> StudyDefinition:
    """Return the definition that a mapping holds.

    Args:
        name: What the errors call it.
        content: The fields of `StudyDefinition`, but for the folder.
        folder: What paths are relative to.

    Raises:
        StudyError: If it is none; the message names the field and what is allowed.
    """
    if "folder" in content:
        raise StudyError(f"{name}: unknown field 'folder'; allowed: {', '.join(STUDY_FORM.fields())}")
    try:
        return StudyDefinition.model_validate({**content, "folder": folder})
    except ValidationError as error:
        raise StudyError(f"{name}: {STUDY_FORM.explain(error)}") from None


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values; TOML reads a bare dotted key as tables within tables."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value
