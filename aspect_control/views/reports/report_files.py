"""The files that make up the report of a study."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ...checks import known_name
from ...files import write_text
from ...studies.chain_check import ChainCheck
from ...studies.study_summary import varying_keys
from ...studies.survey import survey_rows
from ..figures.run_figures import save_figure
from ..figures.study_figure import grid_figure, study_figure
from ..figures.survey_figure import survey_figure
from ..figures.torque_figure import torque_figure
from .comparison_report import comparison_report
from .hypothesis_files import write_hypothesis
from .study_report import study_report
from .survey_report import survey_report

if TYPE_CHECKING:
    import pyarrow as pa

    from ...studies.study import Study

Progress: TypeAlias = Callable[[str, float], None]


def write_report(study: Study, table: pa.Table, folder: Path, progress: Progress) -> list[str]:
    """Write the report that the definition of a study asks for.

    Args:
        study: The study.
        table: Its table.
        folder: Where the files go.
        progress: Called with what is being done and the part of the work that is done, 0 to 1.

    Returns:
        The names of the files, the report first.

    Raises:
        UnknownNameError: If there is no such report.
        OutputError: If a file cannot be written.
    """
    writer = REPORTS[known_name(study.definition.report, REPORTS, "report", context=study.name)]
    return writer(study, table, folder, progress)


def write_summary(study: Study, table: pa.Table, folder: Path, progress: Progress) -> list[str]:
    """Write what can be said of every study; as `write_report`."""
    progress("report", 0.0)
    write_text(folder / "report.md", study_report(table, study.definition.description))
    figures = _save(study_figure(table), folder, "study")
    scenarios = table["scenario"].unique().to_pylist() if varying_keys(table) else []
    for index, scenario in enumerate(scenarios):
        progress(f"figure of {scenario}", index / len(scenarios))
        figures += _save(grid_figure(table, scenario), folder, f"grid-{scenario}")
    return ["report.md", *figures]


def write_survey(
    study: Study, table: pa.Table, folder: Path, progress: Progress, checks: Sequence[ChainCheck] = ()
) -> list[str]:
    """Write the survey; as `write_report`.

    Args:
        study: The study.
        table: Its table.
        folder: Where the files go.
        progress: As for `write_report`.
        checks: What came of checking every chain of every example robot; empty if that was not asked for.
    """
    rows = survey_rows(table)
    progress("report", 0.0)
    document = {"runs": [row.to_dict() for row in rows], "chains": [check.to_dict() for check in checks]}
    write_text(folder / "survey.json", json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    write_text(folder / "survey.md", survey_report(rows, checks))
    return ["survey.md", "survey.json", *_save(survey_figure(rows), folder, "survey")]


def write_comparison(study: Study, table: pa.Table, folder: Path, progress: Progress) -> list[str]:
    """Write the comparison of laws; for the figures of torques the runs are made again; as `write_report`."""
    write_text(folder / "compare.md", comparison_report(table))
    runs = [(row["scenario"], row["law"]) for row in table.to_pylist() if row["status"] != "error"]
    figures = []
    for scenario in dict.fromkeys(name for name, _ in runs):
        recorded = {}
        for index, (name, law) in enumerate(runs):
            if name == scenario:
                progress(f"torques of {scenario}: {law}", index / len(runs))
                recorded[law] = study.record(scenario, 0, law)
        figures += _save(torque_figure(recorded, scenario), folder, f"torques-{scenario}")
    return ["compare.md", *figures]


REPORTS: dict[str, Callable[[Study, pa.Table, Path, Progress], list[str]]] = {
    "summary": write_summary,
    "survey": write_survey,
    "comparison": write_comparison,
    "hypothesis": write_hypothesis,
}
"""What writes a report, by the name that it has in a study file."""


def _save(figure: Any, folder: Path, name: str) -> list[str]:
    names = [f"{name}.png", f"{name}.svg"]
    for each in names:
        save_figure(figure, folder / each)
    return names
