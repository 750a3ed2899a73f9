"""One quantity of one run, drawn into given axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analysis import minor_zero_crossings
from ..arm import Arm
from ..simulation import Run
from .style import COLOURS, DASHES

STICK_INTERVAL = 0.1
"""Time between the stick figures of an arm motion, s."""


def draw_arm_motion(axes: Any, run: Run) -> Any:
    """Draw the arm as overlaid stick figures in the plane of the task's first two coordinates.

    Args:
        axes: The `matplotlib.axes.Axes` to draw into.
        run: The run.

    Returns:
        The mapping from time to colour, for a colour bar.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    columns = ["xyz".index(axis) for axis in run.arm.task[:2]]
    colour = ScalarMappable(
        Normalize(run.t[0], run.t[-1]), ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.88, 256)))
    )
    every = max(1, round(STICK_INTERVAL / run.info.dt))
    for i in range(0, len(run.t), every):
        points = run.arm.skeleton(run.q[i])[:, columns]
        axes.plot(*points.T, color=colour.to_rgba(run.t[i]), linewidth=1.1, marker="o", markersize=2.2)
    axes.plot(*run.x_desired[:, :2].T, color=COLOURS[1], linestyle="--", linewidth=1.4, label="desired path")
    axes.set(xlabel=f"{run.arm.task[0]} (m)", ylabel=f"{run.arm.task[1]} (m)", aspect="equal")
    _legend_above(axes)
    return colour


def draw_torques(axes: Any, run: Run) -> None:
    """Draw the joint torques over time."""
    for joint, torque in enumerate(run.tau.T):
        axes.plot(run.t, torque, color=COLOURS[joint % 7], linestyle=DASHES[joint % 7], label=f"joint {joint + 1}")
    axes.set(xlabel="time (s)", ylabel="torque (N m)")
    _legend_above(axes)


def draw_minors(axes: Any, run: Run) -> None:
    """Draw the minors over time and mark where one changes sign, that is, where the arm leaves its aspect."""
    for index, minor in enumerate(run.minors.T):
        label = f"$\\delta_{{{index + 1}}}$"
        axes.plot(run.t, minor, color=COLOURS[index % 7], linestyle=DASHES[index % 7], label=label)
    axes.axhline(0.0, color="black", linewidth=0.8)
    crossings = minor_zero_crossings(run)
    if crossings:
        times = [crossing.time for crossing in crossings]
        axes.plot(times, np.zeros(len(times)), "ko", markersize=6, fillstyle="none", label="sign change", zorder=5)
    axes.set(xlabel="time (s)", ylabel=f"minors ({minor_unit(run.arm)})")
    _legend_above(axes)


def draw_maciejewski_product(axes: Any, run: Run) -> None:
    """Draw θ̇_H·θ̈_H over time; shade where the null-space term acts, for a run in which it comes and goes."""
    axes.plot(run.t, run.maciejewski_product, color=COLOURS[0])
    axes.axhline(0.0, color="black", linewidth=0.8)
    on = run.null_space_term_on
    if on.any() and not on[1:].all():
        axes.fill_between(
            run.t,
            0.0,
            1.0,
            where=on,
            step="post",
            transform=axes.get_xaxis_transform(),
            color=COLOURS[5],
            alpha=0.45,
            linewidth=0.7,
            label="null-space term on",
        )
        _legend_above(axes)
    axes.set(xlabel="time (s)", ylabel=r"$\dot{\theta}_H \cdot \ddot{\theta}_H$ (rad$^2$/s$^3$)")
    axes.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)


def minor_unit(arm: Arm) -> str:
    """Return the unit of an arm's minors, for revolute joints."""
    return f"m$^{arm.task_dim}$" if arm.task_dim > 1 else "m"


def _legend_above(axes: Any) -> None:
    """Put the legend into the row above the axes: the curves leave no corner free."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.1, ncols=4, columnspacing=1.2)
