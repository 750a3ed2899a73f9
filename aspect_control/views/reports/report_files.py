"""The files that make up the report of a study."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ...checks import known_name
from ...files import write_text
from ...studies.chain_check import ChainCheck
from ...studies.summary import varying_keys
from ...studies.survey import survey_rows
from ..figures.run_figures import save_figure
from ..figures.study_figure import grid_figure, study_figure
from ..figures.survey_figure import survey_figure
from ..figures.torque_figure import torque_figure
from .comparison_report import comparison_report
from .study_report import study_report
from .survey_report import survey_report

if TYPE_CHECKING:
    import pyarrow as pa

    from ...studies.study import Study

Progress: TypeAlias = Callable[[str, float], None]


def write_report(study: Study, table: pa.Table, folder: Path, progress: Progress) -> None:
    """Write the report that the definition of a study asks for.

    Args:
        study: The study.
        table: Its table.
        folder: Where the files go.
        progress: Called with what is being done and the part of the work that is done, 0 to 1.

    Raises:
        UnknownNameError: If there is no such report.
        OutputError: If a file cannot be written.
    """
    name = study.definition.report
    known_name(name, REPORTS, "report", context=study.name)
    REPORTS[name](study, table, folder, progress)


def write_summary(study: Study, table: pa.Table, folder: Path, progress: Progress) -> None:
    """Write what can be said of every study: `report.md` and its figures; see `write_report`."""
    scenarios = table["scenario"].unique().to_pylist() if varying_keys(table) else []
    _save(study_figure(table), folder / "study")
    for index, scenario in enumerate(scenarios):
        progress(f"figure of {scenario}", index / len(scenarios))
        _save(grid_figure(table, scenario), folder / f"grid-{scenario}")
    write_text(folder / "report.md", study_report(table, study.definition.description))


def write_survey(
    study: Study, table: pa.Table, folder: Path, progress: Progress, checks: Sequence[ChainCheck] = ()
) -> None:
    """Write `survey.md`, `survey.json` and the figure; see `write_report`.

    Args:
        study: The study.
        table: Its table.
        folder: Where the files go.
        progress: As for `write_report`.
        checks: What came of checking every chain of every example robot; empty if that was not asked for.
    """
    rows = survey_rows(table)
    progress("figure and report", 0.0)
    _save(survey_figure(rows), folder / "survey")
    document = {"runs": [row.to_dict() for row in rows], "chains": [check.to_dict() for check in checks]}
    write_text(folder / "survey.json", json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    write_text(folder / "survey.md", survey_report(rows, checks))


def write_comparison(study: Study, table: pa.Table, folder: Path, progress: Progress) -> None:
    """Write `compare.md` and the figures of torques, for which the runs are made again; see `write_report`."""
    runs = [(row["scenario"], row["law"]) for row in table.to_pylist() if row["status"] != "error"]
    for scenario in dict.fromkeys(name for name, _ in runs):
        recorded = {}
        for index, (name, law) in enumerate(runs):
            if name == scenario:
                progress(f"torques of {scenario}: {law}", index / len(runs))
                recorded[law] = study.record(scenario, 0, law)
        _save(torque_figure(recorded, scenario), folder / f"torques-{scenario}")
    write_text(folder / "compare.md", comparison_report(table))


REPORTS: dict[str, Callable[[Study, pa.Table, Path, Progress], None]] = {
    "summary": write_summary,
    "survey": write_survey,
    "comparison": write_comparison,
}
"""What writes a report, by the name that it has in a study file."""


def _save(figure: Any, path: Path) -> None:
    for suffix in (".png", ".svg"):
        save_figure(figure, path.with_name(path.name + suffix))
