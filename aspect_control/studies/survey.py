"""The paper's laws on many arms: what their torques, aspects and tracking come to."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from ..resources import scenario_paths
from .study import Study

if TYPE_CHECKING:
    import pyarrow as pa

REFERENCE = "pseudoinverse"
"""The law that peak torques are compared with."""


@dataclass(frozen=True)
class SurveyRow:
    """One law on one scenario.

    Attributes:
        scenario: Name of the scenario.
        controller: Label of the law.
        status: How the run ended.
        end: When it ended, s; None, as all other results, if the run failed.
        peak_torque: Largest |τ| of any joint, N m; None if it overflowed, too.
        peak_ratio: The same divided by that of the pseudoinverse law; None if the scenario does not run it.
        aspect_preserved: Whether all minors kept their sign.
        sign_changes: How often a minor changed sign.
        minors: How many minors are not structurally zero.
        redundancy: n − m.
        tracking_error: Largest distance from the target, m.
        message: The status in words.
    """

    scenario: str
    controller: str
    status: str
    end: float | None
    peak_torque: float | None
    peak_ratio: float | None
    aspect_preserved: bool | None
    sign_changes: int | None
    minors: int
    redundancy: int
    tracking_error: float | None
    message: str

    def to_dict(self) -> dict[str, Any]:
        """Return the row as plain numbers and strings, for JSON."""
        return asdict(self)


def survey_study() -> Study:
    """Return the study: every scenario that ships with the package, its own motion and laws."""
    return Study({"scenarios": list(scenario_paths()), "report": "survey"}, "survey")


def survey_rows(table: pa.Table) -> list[SurveyRow]:
    """Return one row a run.

    Args:
        table: The table of the study.
    """
    runs = table.to_pylist()
    references = {run["scenario"]: run["peak_torque"] for run in runs if run["law"] == REFERENCE}
    same = ("scenario", "status", "end", "peak_torque", "aspect_preserved", "sign_changes", "minors", "redundancy")
    return [
        SurveyRow(
            **{name: run[name] for name in (*same, "message")},
            controller=run["law"],
            peak_ratio=_ratio(run["peak_torque"], references.get(run["scenario"])),
            tracking_error=run["tracking_error_max"],
        )
        for run in runs
    ]


def _ratio(peak: float | None, reference: float | None) -> float | None:
    return peak / reference if peak is not None and reference else None
