"""A self-motion as a figure: the minors along it, the aspects it passes, the joint limits it meets."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from ...aspects import SelfMotion
from ..style import COLOURS, DASHES, style
from .panels import MOST_NAMED, minor_unit


def self_motion_figure(curve: SelfMotion, title: str = "") -> Any:
    """Draw the minors and the minor measure along a self-motion.

    Args:
        curve: The self-motion.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`: above, each minor as a part of its scale, with sign changes marked and
        neighbouring aspects shaded in turn; below, the minor measure, hatched where a joint is beyond its limits.
    """
    from matplotlib.figure import Figure

    with style():
        figure: Any = Figure(figsize=(10.0, 6.0), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
        s = curve.s
        named = len(curve.arm.minor_columns) <= MOST_NAMED
        for index, share in enumerate((curve.minors / curve.arm.minor_scales).T):
            above.plot(
                s,
                share,
                color=COLOURS[index % 7],
                linestyle=DASHES[index % 7] if named else "-",
                linewidth=1.6 if named else 0.9,
                label=f"$\\delta_{{{index + 1}}}$" if named else "_",
            )
        above.axhline(0.0, color="black", linewidth=0.8)
        places = [crossing.s for crossing in curve.crossings]
        label = f"sign changes: {len(places)}"
        above.plot(places, np.zeros(len(places)), "ko", fillstyle="none", markersize=6, label=label, zorder=5)
        edges = np.unique(np.concatenate([[s[0], s[-1]], np.clip(places, s[0], s[-1])]))
        for axes in (above, below):
            for low, high in list(pairwise(edges))[::2]:
                axes.axvspan(low, high, color="0.5", alpha=0.13, linewidth=0.0)
        along = np.concatenate([s, places])
        heights = np.concatenate([curve.minor_measure, np.zeros(len(places))])
        order = np.argsort(along, kind="stable")
        below.plot(along[order], heights[order], color=COLOURS[0], label="minor measure H")
        outside = ~curve.within_limits
        if outside.any():
            below.fill_between(
                s,
                0.0,
                1.0,
                where=outside,
                transform=below.get_xaxis_transform(),
                facecolor="none",
                edgecolor=COLOURS[1],
                hatch="///",
                linewidth=0.0,
                label="beyond a joint limit",
            )
        below.axvline(0.0, color="black", linewidth=1.0, linestyle=":", label="given posture")
        below.set_ylim(bottom=0.0)
        below.margins(x=0.01)
        above.set(ylabel="minors, parts of their scales")
        below.set(xlabel="arc length along the self-motion (rad)", ylabel=f"H ({minor_unit(curve.arm)})")
        for axes in (above, below):
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.1, ncols=8, columnspacing=1.2)
        figure.suptitle(title)
        return figure
