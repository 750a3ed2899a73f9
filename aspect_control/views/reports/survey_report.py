"""The survey as Markdown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...analysis import exploded
from ...studies.chain_check import ChainCheck
from ...studies.survey import SurveyRow
from .markdown import markdown_table

CALM_RATIO = 2.0
"""Peak torque over that of the pseudoinverse law up to which a run counts as calm."""


def survey_report(rows: Sequence[SurveyRow], checks: Sequence[ChainCheck] = ()) -> str:
    """Return the survey as Markdown.

    Args:
        rows: One row a law and scenario.
        checks: What came of checking every chain of every example robot; empty if that was not asked for.
    """
    lines = [
        "# The paper's laws on many arms",
        "",
        "Gravity on, laws and sampling time as in the scenarios. The ratio is the peak torque over that of the "
        "pseudoinverse law; r is the number of redundant degrees of freedom. "
        "Minors that are structurally zero are left out.",
        "",
        *markdown_table(
            ("scenario", "r", "law", "status", "peak torque (N m)", "ratio", "aspect", "tracking error (mm)"),
            [_cells(row) for row in rows],
        ),
        "",
        "![peak torque of each law on each arm](survey.png)",
        "",
        "## How the runs that did not finish ended",
        "",
        *[f"- {row.scenario}, {row.controller}: {row.message}" for row in rows if row.status != "finished"],
        "",
        "## What this says about the paper's hypothesis",
        "",
        *_verdict(rows),
        "",
    ]
    return "\n".join(lines + (_checks(checks) if checks else []))


def _cells(row: SurveyRow) -> tuple[str, ...]:
    aspect = "kept" if row.aspect_preserved else f"left, {row.sign_changes} changes of {row.minors} minors"
    ended = "" if row.status == "finished" or row.end is None else f" at {row.end:.3f} s"
    return (
        row.scenario,
        str(row.redundancy),
        row.controller,
        row.status + ended,
        "" if row.peak_torque is None else f"{row.peak_torque:,.1f}",
        "" if row.peak_ratio is None else f"{row.peak_ratio:,.2f}",
        "" if row.aspect_preserved is None else aspect,
        "" if row.tracking_error is None else f"{1e3 * row.tracking_error:.2g}",
    )


def _verdict(rows: Sequence[SurveyRow]) -> list[str]:
    """Count aspect kept or left against torque calm or not, for the runs that there is a reference for."""
    counts = {(kept, calm): 0 for kept in (True, False) for calm in (True, False)}
    single = dict(counts)
    compared = [row for row in rows if row.peak_ratio is not None]
    for row in compared:
        key = bool(row.aspect_preserved), not exploded(row.status, row.peak_ratio or np.inf, CALM_RATIO)
        counts[key] += 1
        single[key] += row.redundancy == 1
    table = markdown_table(
        ("", "calm", "not calm"),
        [
            (word, *(f"{counts[kept, calm]} ({single[kept, calm]})" for calm in (True, False)))
            for kept, word in ((True, "aspect kept"), (False, "aspect left"))
        ],
    )
    calm_outside = counts[False, True]
    broken_inside = counts[True, False]
    return [
        "Runs by aspect and torque; calm means finished with at most twice the pseudoinverse law's peak; in brackets "
        "the runs with one redundant degree of freedom:",
        "",
        *table,
        "",
        f"{calm_outside} calm runs left their aspect and {broken_inside} runs that kept it were not calm. "
        + (
            "Keeping the aspect is therefore not necessary for a stable torque on these arms: minors change sign "
            "harmlessly. "
            if calm_outside
            else "No run contradicts the hypothesis that keeping the aspect is necessary for a stable torque. "
        )
        + (
            "No torque exploded inside an aspect."
            if not broken_inside
            else "Nor is it sufficient: torque exploded inside an aspect."
        ),
    ]


def _checks(checks: Sequence[ChainCheck]) -> list[str]:
    passed = [check for check in checks if check.deviation is not None]
    problems = [(check.robot, check.frame, check.problem) for check in checks if check.deviation is None]
    worst = max(passed, key=lambda check: check.deviation or 0.0)
    return [
        "## Every chain of every example robot",
        "",
        f"{len(passed)} chains of {len({check.robot for check in passed})} robots were reduced to arms and compared "
        f"with the full, unreduced model in M, N, J, J̇θ̇ and x at random states: the largest relative deviation is "
        f"{worst.deviation:.1e} ({worst.robot}, {worst.frame}), the median "
        f"{np.median([check.deviation for check in passed if check.deviation is not None]):.1e}. Not loaded:",
        "",
        *markdown_table(("robot", "frame", "reason"), problems),
        "",
    ]
