"""The figure of the benchmark."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from aspect_control.views.style import COLOURS, style

from .timing import COMPILED, NUMPY, Row


def benchmark_figure(rows: Sequence[Row]) -> Any:
    """Draw the ticks of Panda beside the floor and, where they were timed, how the pieces grow with the arm.

    Args:
        rows: The rows of `benchmark.benchmark`.

    Returns:
        A `matplotlib.figure.Figure`.
    """
    from matplotlib.figure import Figure

    with style():
        pieces_were_timed = any(row.group.startswith("chain of 30, xyz: ") for row in rows)
        figure = Figure(figsize=(10.0 if pieces_were_timed else 6.0, 7.5), layout="constrained")
        left, *right = figure.subplots(1, 2 if pieces_were_timed else 1, squeeze=False)[0]
        _draw_ticks(left, rows)
        for axes in right:
            _draw_growth(axes, rows)
        return figure


def _draw_ticks(axes: Any, rows: Sequence[Row]) -> None:
    measured = {(row.group, row.name): row for row in rows}
    names = [name.removesuffix(", literal") for _, name in measured if name.endswith(", literal")]
    names = list(dict.fromkeys(names))
    bars = [
        ("literal, numpy.linalg.pinv", NUMPY, ", literal", COLOURS[1]),
        ("aspect-control, NumPy", NUMPY, "", COLOURS[2]),
        ("aspect-control, compiled", COMPILED, "", COLOURS[0]),
    ]
    y = np.arange(len(names))
    for i, (label, mode, suffix, colour) in enumerate(bars):
        rows_shown = [measured.get((f"Panda, xyz: tick, {mode}", f"{name}{suffix}")) for name in names]
        ratios = [np.quantile(row.seconds / row.base, (0.25, 0.5, 0.75)) for row in rows_shown if row is not None]
        if len(ratios) < len(names) or not names:
            continue
        low, middle, high = np.transpose(ratios)
        spread = (middle - low, high - middle)
        axes.barh(y + 0.28 * (i - 1), middle, 0.26, xerr=spread, color=colour, label=label)
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
