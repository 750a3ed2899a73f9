"""The joint torques of all laws on the same motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...simulation import Run
from ..style import plain_text, style
from .panels import draw_torques

COLUMNS = 3
"""Panels that a row of the figure of torques holds."""


def torque_figure(runs: Mapping[str, Run], title: str) -> Any:
    """Draw the joint torques of each run, those of calm runs on one scale.

    Args:
        runs: Runs by the labels of their laws.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`; a panel whose torques pass three times the median peak has a scale of its own,
        logarithmic where they explode.
    """
    from matplotlib.figure import Figure

    peaks = sorted(float(abs(run.tau).max()) for run in runs.values())
    common = 3.0 * peaks[len(peaks) // 2]
    rows = math.ceil(len(runs) / COLUMNS)
    with style():
        figure: Any = Figure(figsize=(4.0 * COLUMNS, 0.8 + 2.4 * rows), layout="constrained")
        panels = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False)
        calm = [run for run in runs.values() if abs(run.tau).max() <= common]
        limit = 1.05 * max((float(abs(run.tau).max()) for run in calm), default=common)
        for index, (axes, (label, run)) in enumerate(zip(panels.flat, runs.items(), strict=False)):
            draw_torques(axes, run)
            handles = axes.get_legend_handles_labels()
            axes.get_legend().remove()
            exploded = abs(run.tau).max() > common
            axes.set_title(plain_text(label) + (f" ({_own_scale(axes)})" if exploded else ""))
            axes.set_ylabel("torque (N m)" if index % COLUMNS == 0 else "")
            if not exploded:
                axes.set_ylim(-limit, limit)
            lowest = index + COLUMNS >= len(runs)
            axes.xaxis.set_tick_params(labelbottom=lowest)
            axes.set_xlabel("time (s)" if lowest else "")
        for axes in list(panels.flat)[len(runs) :]:
            axes.set_visible(False)
        figure.legend(*handles, loc="outside lower center", ncols=7)
        figure.suptitle(plain_text(title))
        return figure


def _own_scale(axes: Any) -> str:
    """Say how a panel that is not on the common scale is drawn."""
    if axes.get_yscale() == "linear":
        return "scale of its own"
    return f"log beyond ±{axes.yaxis.get_transform().linthresh:g} N m"
