"""One quantity of one run, drawn into given axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...analysis import minor_zero_crossings
from ...arm import Arm
from ...arm.tasks import AXES, POSITION_AXES
from ...redundancy import Array
from ...simulation import Run
from ..style import COLOURS, DASHES

STICK_INTERVAL = 0.1
"""Time between the stick figures of an arm motion, s."""


LEGEND_COLUMNS = 4
"""Entries that a row of a legend holds."""

MOST_NAMED = 8
"""The most curves of one panel that are named in its legend."""

LOGARITHMIC_FROM = 300.0
"""Ratio of the largest to the median magnitude in a panel from which its scale is logarithmic."""


def drawing_plane(runs: Iterable[Run]) -> tuple[int, int]:
    """Return the two world axes, 0 to 2, in which runs of one arm are drawn side by side.

    They are the task's own if it has two positions, else those in which the moving arm is widest.
    """
    runs = list(runs)
    positions = [AXES.index(axis) for axis in runs[0].arm.task if axis in POSITION_AXES]
    if len(positions) == 2:
        return positions[0], positions[1]
    points = np.concatenate([run.arm.skeleton(run.q[i]) for run in runs for i in _stick_samples(run)])
    first, second = sorted(np.argsort(np.ptp(points, axis=0))[-2:])
    return int(first), int(second)


def draw_arm_motion(axes: Any, run: Run, plane: tuple[int, int], end: float) -> Any:
    """Draw the arm as overlaid stick figures.

    Args:
        axes: The `matplotlib.axes.Axes` to draw into.
        run: The run.
        plane: The world axes to project on, as of `drawing_plane`.
        end: Time at the end of the colour scale, s.

    Returns:
        The mapping from time to colour, for a colour bar.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    columns = list(plane)
    colour = ScalarMappable(Normalize(0.0, end), ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.88, 256))))
    for i in _stick_samples(run):
        points = run.arm.skeleton(run.q[i])[:, columns]
        axes.plot(*points.T, color=colour.to_rgba(run.t[i]), linewidth=1.1, marker="o", markersize=2.2)
    path = desired_positions(run)[:, columns]
    if np.isfinite(path).all():
        axes.plot(*path.T, color=COLOURS[1], linestyle="--", linewidth=1.4, label="desired path")
        _legend_above(axes)
    axes.set(xlabel=f"{AXES[plane[0]]} (m)", ylabel=f"{AXES[plane[1]]} (m)", aspect="equal")
    return colour


def draw_torques(axes: Any, run: Run) -> None:
    """Draw the joint torques over time."""
    for joint, torque in enumerate(run.tau.T):
        axes.plot(run.t, torque, color=COLOURS[joint % 7], linestyle=DASHES[joint % 7], label=f"joint {joint + 1}")
    axes.set(xlabel="time (s)", ylabel="torque (N m)")
    use_signed_log_scale(axes, run.tau)
    _legend_above(axes)


def draw_minors(axes: Any, run: Run) -> None:
    """Draw the minors over time and mark where one changes sign, that is, where the arm leaves its aspect."""
    named = run.minors.shape[1] <= MOST_NAMED
    for index, minor in enumerate(run.minors.T):
        label = f"$\\delta_{{{index + 1}}}$" if named else "_"
        dashes = DASHES[index % 7] if named else "-"
        axes.plot(
            run.t, minor, color=COLOURS[index % 7], linestyle=dashes, linewidth=None if named else 1.0, label=label
        )
    axes.axhline(0.0, color="black", linewidth=0.8)
    crossings = minor_zero_crossings(run)
    if crossings:
        times = [crossing.time for crossing in crossings]
        label = "sign change" if named else f"sign changes of {run.minors.shape[1]} minors: {len(crossings)}"
        axes.plot(times, np.zeros(len(times)), "ko", markersize=6, fillstyle="none", label=label, zorder=5)
    axes.set(xlabel="time (s)", ylabel=f"minors ({minor_unit(run.arm)})")
    if named or crossings:
        _legend_above(axes)


def draw_maciejewski_product(axes: Any, run: Run) -> None:
    """Draw θ̇_H·θ̈_H over time; shade where the null-space term acts, for a law that switches it."""
    axes.plot(run.t, run.maciejewski_product, color=COLOURS[0])
    axes.axhline(0.0, color="black", linewidth=0.8)
    on = run.null_space_term_on
    if run.info.switches and on.any():
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
    if not use_signed_log_scale(axes, run.maciejewski_product):
        axes.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)


def use_signed_log_scale(axes: Any, values: Array) -> bool:
    """Make the vertical axis logarithmic on both sides of zero if the values explode, and say so in its label.

    Args:
        axes: The axes, labelled.
        values: What they show.

    Returns:
        Whether the largest magnitude is more than `LOGARITHMIC_FROM` times the median one.
    """
    magnitudes = np.abs(values)
    typical, largest = float(np.median(magnitudes)), float(magnitudes.max())
    if not largest > LOGARITHMIC_FROM * typical > 0.0:
        return False
    linear = 10.0 ** round(np.log10(typical))
    axes.set_yscale("symlog", linthresh=linear)
    axes.yaxis.get_major_locator().set_params(numticks=7)
    axes.set_ylabel(f"{axes.get_ylabel()}, log beyond ±{linear:g}")
    return True


def motion_shape(runs: Iterable[Run], plane: tuple[int, int]) -> float:
    """Return the height over the width of what the arms of several runs sweep in a plane."""
    points = np.concatenate([run.arm.skeleton(run.q[i]) for run in runs for i in _stick_samples(run)])
    width, height = np.ptp(points[:, list(plane)], axis=0)
    return float(height / max(width, 1e-9))


def minor_unit(arm: Arm) -> str:
    """Return the unit of an arm's minors, for revolute joints."""
    positions = len(arm.coordinates.position_rows)
    return "1" if positions == 0 else "m" if positions == 1 else f"m$^{positions}$"


def _stick_samples(run: Run) -> range:
    """Return the samples at which a stick figure is drawn."""
    return range(0, len(run.t), max(1, round(STICK_INTERVAL / run.info.dt)))


def desired_positions(run: Run) -> Array:
    """Return the desired path in the world frame, shape (k, 3), m; NaN in directions that are free."""
    return world_positions(run.arm, run.x_desired)


def world_positions(arm: Arm, values: Array) -> Array:
    """Return task values as positions in the world frame, shape (k, 3), m; NaN in directions that are free.

    Args:
        arm: The arm.
        values: Encoded task values, shape (k, m) or (k, 7); see `Task.encode`.
    """
    path = np.full((len(values), 3), np.nan)
    rows = arm.coordinates.position_rows
    axes = [arm.coordinates.rows[row] for row in rows]
    # A pose is encoded as x, y, z and a quaternion; positions as the task's own rows.
    path[:, axes] = values[:, axes if arm.coordinates.has_rotation else rows]
    return path


def _legend_above(axes: Any) -> None:
    """Put the legend into the row above the axes: the curves leave no corner free."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.1, ncols=LEGEND_COLUMNS, columnspacing=1.2)
