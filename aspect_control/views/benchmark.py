"""The figure of the benchmark."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..benchmark import Row, Verdict
from .style import COLOURS, style


def benchmark_figure(rows: Sequence[Row]) -> Any:
    """Draw the ticks of Panda beside the floor, and how the pieces grow with the arm.

    Args:
        rows: The rows of `benchmark.benchmark`.

    Returns:
        A `matplotlib.figure.Figure`.
    """
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(10.0, 7.5), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw_ticks(left, [row for row in rows if row.group == "Panda, xyz: tick"])
        _draw_growth(right, rows)
        return figure


def benchmark_report(
    rows: Sequence[Row], judged: Sequence[Verdict], missing: Sequence[str], machine: Mapping[str, Any]
) -> str:
    """Write the benchmark as Markdown: the machine, the targets and every row, ratios first.

    Args:
        rows: The rows of `benchmark.benchmark`.
        judged: What `benchmark.verdicts` makes of them.
        missing: Rivals that are not installed.
        machine: What `benchmark.machine` says.
    """
    versions = ", ".join(f"{name} {number}" for name, number in machine["versions"].items())
    words = {True: "met", False: "**missed**", None: "not measured"}
    counts = [len(row.seconds) for row in rows]
    most, fewest = max(counts), min(counts)
    lines = [
        "# Cost, measured",
        "",
        f"{machine['processor']}, {machine['system']}, Python {machine['python']}; {versions}.",
        f"Not installed: {', '.join(missing) or 'none'}. Wall time; ratios are medians over "
        f"{most} rounds ({fewest} for runs and starts) in which the calls take turns.",
        "",
        "| target | measured | |",
        "| --- | --- | --- |",
    ]
    for each in judged:
        measured = "" if each.measured is None else f"{each.measured:.2f}"
        lines.append(f"| {each.target} | {measured} | {words[each.met]} |")
    lines += ["", "| what | | ratio | quartiles | of | µs | |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        values = row.to_dict()
        low, high = values["ratio_quartiles"]
        lines.append(
            f"| {row.group} | {row.name} | {values['ratio']:.2f} | {low:.2f}–{high:.2f} | {row.of} | "
            f"{values['microseconds']:,.1f} | {row.note} |"
        )
    return "\n".join(lines) + "\n"


def _draw_ticks(axes: Any, rows: Sequence[Row]) -> None:
    literal = {row.name.removesuffix(", literal"): row.ratio for row in rows if row.name.endswith("literal")}
    names = list(literal)
    here = {row.name: row for row in rows}
    y = np.arange(len(names))
    quartiles = np.array([np.quantile(here[n].seconds / here[n].base, (0.25, 0.75)) for n in names]).reshape(-1, 2)
    middle = np.array([here[name].ratio for name in names])
    axes.barh(y - 0.2, list(literal.values()), 0.38, color=COLOURS[1], label="literal, numpy.linalg.pinv")
    spread = np.abs(quartiles.T - middle)
    axes.barh(y + 0.2, middle, 0.38, xerr=spread, color=COLOURS[0], label="aspect-control")
    axes.axvline(1.0, color="black", linewidth=1.0)
    axes.set_xscale("log")
    axes.set_yticks(y, names)
    axes.invert_yaxis()
    axes.set_xlabel("time of one tick / bare Pinocchio calls")
    axes.set_title("Control tick, Panda, position of the tool")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.12))


def _draw_growth(axes: Any, rows: Sequence[Row]) -> None:
    chains = [(7, "Panda, xyz"), (10, "chain of 10, xyz"), (20, "chain of 20, xyz"), (30, "chain of 30, xyz")]
    shown = [
        ("J⁺", "numpy pinv", "J⁺, numpy pinv"),
        ("J⁺", "aspect-control", "J⁺, aspect-control"),
        ("[M(I − J⁺J)]⁺", "numpy pinv", "[M(I − J⁺J)]⁺, numpy pinv"),
        ("[M(I − J⁺J)]⁺", "aspect-control, minimum torque without it", "minimum torque, aspect-control"),
        ("∇H", "numpy inv, one by one", "∇H of all minors, numpy"),
        ("∇H", "aspect-control", "∇H of all minors, aspect-control"),
    ]
    for i, (piece, name, label) in enumerate(shown):
        points = [
            (n, 1e6 * float(np.median(row.seconds)))
            for n, arm in chains
            for row in rows
            if row.group.startswith(f"{arm}: {piece}") and row.name == name
        ]
        n, times = np.array(points).reshape(-1, 2).T
        style_of = "-" if "aspect-control" in label else "--"
        axes.plot(n, times, style_of, marker="o", color=COLOURS[i // 2], label=label)
    axes.set_yscale("log")
    axes.set_xlabel("joints n (three task coordinates)")
    axes.set_ylabel("time (µs)")
    axes.set_title("Pieces")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.12), fontsize=9.0)
