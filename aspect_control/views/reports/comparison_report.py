"""The comparison of all laws as Markdown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .markdown import markdown_table

if TYPE_CHECKING:
    import pyarrow as pa


def comparison_report(table: pa.Table) -> str:
    """Return a table a scenario as Markdown.

    Args:
        table: The table of a study of one motion a scenario.
    """
    lines, runs = ["# All laws on the same motions", ""], table.to_pylist()
    for scenario in dict.fromkeys(run["scenario"] for run in runs):
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
                [_cells(run) for run in runs if run["scenario"] == scenario],
            ),
            "",
            f"![joint torques of each law on {scenario}](torques-{scenario}.png)",
            "",
        ]
    return "\n".join(lines)


def _cells(run: dict[str, Any]) -> tuple[str, ...]:
    aspect = "kept" if run["aspect_preserved"] else f"left, {run['sign_changes']} sign changes"
    return (
        run["law"],
        run["status"],
        _number(run["peak_torque"]),
        _number(run["torque_squared_integral"]),
        _number(run["torque_total_variation"]),
        _brief(run["self_motion_energy_max"]),
        "–" if run["aspect_preserved"] is None else aspect,
        _brief(run["tracking_error_max"], 1e3),
    )


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:,.1f}" if value < 1e6 else f"{value:.2g}"


def _brief(value: float | None, factor: float = 1.0) -> str:
    return "–" if value is None else f"{factor * value:.2g}"
