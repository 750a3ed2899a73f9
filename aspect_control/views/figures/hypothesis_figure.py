"""The figure of the random motions: tables as bars, and what the torque goes with."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...studies.hypothesis import ABLATION, THRESHOLD, HypothesisResult
from ..style import COLOURS, law_name, plain_text, style

_CALM, _EXPLODED = COLOURS[4], COLOURS[1]
_MARKERS = "o^svDP*"


def hypothesis_figure(result: HypothesisResult, title: str = "") -> Any:
    """Draw the 2×2 table of each law as bars, and the torque over self-motion and over the distance to the border.

    Args:
        result: What was found.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`.
    """
    from matplotlib.figure import Figure

    laws = result.laws
    with style():
        figure: Any = Figure(figsize=(10.0, 5.6 + 0.62 * len(laws)), layout="constrained")
        bars, scatter = figure.subfigures(2, 1, height_ratios=(1.2 + 0.62 * len(laws), 4.4))
        _draw_bars(bars.subplots(), result)
        panels = scatter.subplots(1, 2, sharey=True)
        _draw_scatter(panels[0], result, "self_motion_max", r"largest self-motion $\Vert\dot\theta_H\Vert$ (rad/s)")
        if len(result.rows):
            panels[0].set_xscale("log")
        _draw_scatter(panels[1], result, "margin", "smallest normalised minor; left of 0: aspect left")
        panels[1].axvline(0.0, color="black", linewidth=0.8)
        panels[0].set_ylabel("peak torque / reference")
        scatter.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.suptitle(plain_text(title))
        return figure


def _draw_bars(axes: Any, result: HypothesisResult) -> None:
    """Draw the shares of calm and exploded runs among those that kept and those that left their aspect."""
    labels, heights = [], []
    for place, law in enumerate(result.laws):
        table = result.table(law)
        for kept, calm, share, offset in (
            ("kept", table.kept_calm, table.exploded_if_kept, -0.2),
            ("left", table.left_calm, table.exploded_if_left, 0.2),
        ):
            height = place + offset
            labels.append(f"{law_label(law)}: {kept}" if kept == "kept" else kept)
            heights.append(height)
            if share.value is None:
                axes.text(0.01, height, "no runs", va="center", fontsize=9.5)
                continue
            axes.barh(height, 1.0 - share.value, height=0.36, color=_CALM)
            axes.barh(height, share.value, left=1.0 - share.value, height=0.36, color=_EXPLODED)
            axes.plot([1.0 - share.high, 1.0 - share.low], [height, height], color="black", linewidth=1.4)
            axes.text(0.01, height, f"{calm} calm", va="center", fontsize=9.5)
            axes.text(1.01, height, f"{share.count} exploded", va="center", fontsize=9.5)
    axes.set_yticks(heights, labels)
    axes.set(xlim=(0.0, 1.18), ylim=(len(result.laws) - 0.5, -0.5))
    axes.set_xticks(np.linspace(0.0, 1.0, 6), [f"{100 * share:.0f} %" for share in np.linspace(0.0, 1.0, 6)])
    axes.grid(visible=False, axis="y")
    axes.set_title(f"share of runs: calm, exploded (beyond {THRESHOLD:g} times the reference); line: 95 % interval")


def _draw_scatter(axes: Any, result: HypothesisResult, measure: str, label: str) -> None:
    for place, law in enumerate(result.laws):
        hollow = law == ABLATION
        colour = "black" if hollow else COLOURS[place % len(COLOURS)]
        picked = result.of(law)
        axes.plot(
            picked[measure],
            picked["ratio"],
            rasterized=True,
            linestyle="none",
            marker=_MARKERS[place % len(_MARKERS)],
            markersize=4.5 if hollow else 4.0,
            fillstyle="none" if hollow else "full",
            markeredgewidth=0.5 if hollow else 0.0,
            alpha=0.45 if hollow else 0.6,
            zorder=1.5 if hollow else 2.0,
            color=colour,
            label=law_label(law),
        )
    axes.set_ylim(0.8, 1.5 * max(10.0 * THRESHOLD, result.rows["ratio"].max() if len(result.rows) else 0.0))
    axes.axhline(THRESHOLD, color="black", linewidth=0.8)
    axes.set_yscale("log")
    axes.set_xlabel(label)


def law_label(law: str) -> str:
    """Return how a law is called in the figure."""
    return {ABLATION: "JMDC, κ = 0"}.get(law, law_name(law))
