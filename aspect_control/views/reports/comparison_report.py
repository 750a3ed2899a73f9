"""The comparison of all laws as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .markdown import markdown_table


def comparison_report(summaries: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> str:
    """Return a table a scenario as Markdown.

    Args:
        summaries: Summaries of runs by the labels of their laws, by scenario.
    """
    lines = ["# All laws on the same motions", ""]
    for scenario, runs in summaries.items():
        lines += [
            f"## {scenario}",
            "",
            *markdown_table(
                (
                    "law",
                    "ended",
                    "peak torque (N m)",
                    "∫‖τ‖²dt (N² m² s)",
                    "total variation of τ (N m)",
                    "self-motion energy (J)",
                    "aspect",
                    "tracking error (mm)",
                ),
                [_cells(label, summary) for label, summary in runs.items()],
            ),
            "",
            f"![joint torques of each law on {scenario}](torques-{scenario}.png)",
            "",
        ]
    return "\n".join(lines)


def _cells(label: str, summary: Mapping[str, Any]) -> tuple[str, ...]:
    changes = len(summary["minor_zero_crossings"])
    return (
        label,
        summary["status"],
        _number(max(summary["peak_torque"])),
        _number(summary["torque_squared_integral"]),
        _number(sum(summary["torque_total_variation"])),
        f"{summary['self_motion_energy_max']:.2g}",
        "kept" if summary["aspect_preserved"] else f"left, {changes} sign changes",
        f"{1e3 * summary['max_tracking_error']:.2g}",
    )


def _number(value: float) -> str:
    return f"{value:,.1f}" if value < 1e6 else f"{value:.2g}"
