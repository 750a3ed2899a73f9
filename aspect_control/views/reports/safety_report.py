"""What a guard makes of wrong input as Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from ...studies.safety import SafetyRow, Sequences
from .markdown import markdown_table


def safety_report(rows: Sequence[SafetyRow], sequences: Sequences) -> str:
    """Return a table a fault, one a fault and law, and what came of the random sequences, as Markdown.

    Args:
        rows: Every fault under every law.
        sequences: Random sequences.
    """
    return "\n".join(
        [
            "# Wrong input, with a guard and without",
            "",
            *markdown_table(
                (
                    "fault",
                    "laws",
                    "largest torque without (N m)",
                    "with (N m)",
                    "of its limit",
                    "ends",
                    "reason, most often",
                ),
                [_fault_cells(fault, found) for fault, found in by_fault(rows).items()],
            ),
            "",
            "## Law by law",
            "",
            *markdown_table(
                ("fault", "law", "without a guard", "torque (N m)", "with (N m)", "of its limit", "ends", "reason"),
                [_cells(row) for row in rows],
            ),
            "",
            "## Random sequences",
            "",
            *sequence_lines(sequences),
            "",
        ]
    )


def by_fault(rows: Sequence[SafetyRow]) -> Mapping[str, list[SafetyRow]]:
    """Return the rows of each fault, in the order in which they were tried."""
    found: dict[str, list[SafetyRow]] = {}
    for row in rows:
        found.setdefault(row.fault, []).append(row)
    return found


def sequence_lines(sequences: Sequences) -> list[str]:
    """Return what came of random sequences, in sentences."""
    broken = [
        f"- sequence {each.index}: {', '.join(each.broken)} ({each.law}, {each.fault})" for each in sequences.broken
    ]
    states = ", ".join(f"{state} {count:,}" for state, count in sorted(sequences.states.items()))
    return [
        f"{sequences.sequences:,} sequences of {sequences.samples:,} samples: a bound was broken in "
        f"{len(sequences.broken):,} of them. Position limits counted to the end in {sequences.positioned:,}.",
        "",
        f"The guard ended {states}.",
        *([""] if broken else []),
        *broken,
    ]


def _fault_cells(fault: str, rows: Sequence[SafetyRow]) -> tuple[str, ...]:
    torques = [row.bare_torque for row in rows]
    return (
        fault,
        str(len(rows)),
        f"{_number(min(torques))} to {_number(max(torques))}",
        _number(max(row.torque for row in rows)),
        f"{max(row.share for row in rows):.2f}",
        ", ".join(sorted({row.state for row in rows})),
        Counter(row.reason for row in rows).most_common(1)[0][0],
    )


def _cells(row: SafetyRow) -> tuple[str, ...]:
    return (
        row.fault,
        row.law,
        row.bare,
        _number(row.bare_torque),
        _number(row.torque),
        f"{row.share:.2f}",
        row.state,
        row.reason,
    )


def _number(value: float) -> str:
    return f"{value:,.1f}" if value < 1e6 else f"{value:.2g}"
