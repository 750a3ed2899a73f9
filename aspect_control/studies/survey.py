"""The paper's laws on many arms: what their torques, aspects and tracking come to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ..analysis import summarize
from ..scenario import Setup
from ..simulation import Run

REFERENCE = "pseudoinverse"
"""The law that peak torques are compared with."""


@dataclass(frozen=True)
class SurveyRow:
    """One law on one scenario.

    Attributes:
        scenario: Name of the scenario.
        controller: Label of the law.
        status: How the run ended.
        end: When it ended, s.
        peak_torque: Largest |τ| of any joint, N m.
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
    end: float
    peak_torque: float
    peak_ratio: float | None
    aspect_preserved: bool
    sign_changes: int
    minors: int
    redundancy: int
    tracking_error: float
    message: str

    def to_dict(self) -> dict[str, Any]:
        """Return the row as plain numbers and strings, for JSON."""
        return asdict(self)


def survey(
    setups: Mapping[str, Setup],
    keep: Callable[[list[SurveyRow]], None],
    progress: Callable[[str, float], None],
) -> list[SurveyRow]:
    """Run every law of every scenario.

    Args:
        setups: What is run, by the names of the scenarios.
        keep: Called with all rows so far whenever a scenario is done.
        progress: Called with what is being done and the part of all work that is done, 0 to 1.

    Raises:
        AspectControlError: As `simulate` does.
    """
    rows: list[SurveyRow] = []
    for i, (name, setup) in enumerate(setups.items()):

        def report(label: str, part: float, name: str = name, i: int = i) -> None:
            progress(f"{name}: {label}", (i + part) / len(setups))

        rows += survey_rows(name, setup.run(report))
        keep(rows)
    return rows


def survey_rows(name: str, runs: Mapping[str, Run]) -> list[SurveyRow]:
    """Return one row a run of a scenario.

    Args:
        name: Name of the scenario.
        runs: Its runs by the labels of their laws.
    """
    summaries = {label: summarize(run) for label, run in runs.items()}
    peaks = {label: max(summary["peak_torque"]) for label, summary in summaries.items()}
    reference = peaks.get(REFERENCE)
    return [
        SurveyRow(
            scenario=name,
            controller=label,
            status=run.status,
            end=float(run.t[-1]),
            peak_torque=peaks[label],
            peak_ratio=peaks[label] / reference if reference else None,
            aspect_preserved=summaries[label]["aspect_preserved"],
            sign_changes=len(summaries[label]["minor_zero_crossings"]),
            minors=summaries[label]["minors"],
            redundancy=run.arm.redundancy,
            tracking_error=summaries[label]["max_tracking_error"],
            message=run.message,
        )
        for label, run in runs.items()
    ]
