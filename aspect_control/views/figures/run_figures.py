"""Figures of runs. Nothing is shown on a screen: every function returns a figure without a window."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...analysis import total_variation
from ...checks import file_path, known_name
from ...exceptions import OutputError
from ...files import atomic_path
from ...simulation import Run
from ..style import COLOURS, DASHES, law_name, style
from .panels import (
    LEGEND_COLUMNS,
    draw_arm_motion,
    draw_maciejewski_product,
    draw_minors,
    draw_torques,
    drawing_plane,
    minor_unit,
    motion_shape,
)


def run_figure(run: Run, title: str = "") -> Any:
    """Draw a run as the paper's Figs. 2 to 4 do.

    Args:
        run: The run.
        title: Heading of the figure; empty for the law's name.

    Returns:
        A `matplotlib.figure.Figure` with the panels (a) arm motion, (b) joint torques, (c) minors with their sign
        changes marked, (d) θ̇_H·θ̈_H.
    """
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(10.0, 8.0), layout="constrained")
        axes = figure.subplots(2, 2)
        end = _end([run])
        time_colour = draw_arm_motion(axes[0, 0], run, drawing_plane([run]), end)
        figure.colorbar(time_colour, ax=axes[0, 0], label="time (s)", location="bottom", shrink=0.6, aspect=30)
        draw_torques(axes[0, 1], run)
        draw_minors(axes[1, 0], run)
        draw_maciejewski_product(axes[1, 1], run)
        legends = [panel.get_legend() for panel in axes.flat if panel.get_legend() is not None]
        rows = max(math.ceil(len(legend.get_texts()) / LEGEND_COLUMNS) for legend in legends)
        title_pad = 6.0 + 18.0 * rows
        names = ("(a) arm motion", "(b) joint torques", "(c) minors", r"(d) $\dot{\theta}_H \cdot \ddot{\theta}_H$")
        for panel, name in zip(axes.flat, names, strict=True):
            panel.set_title(name, pad=title_pad)
        for panel in axes.flat[1:]:
            panel.set_xlim(0.0, end)
        figure.suptitle(title or law_name(run.info.controller))
        return figure


def comparison_figure(runs: Mapping[str, Run], title: str = "") -> Any:
    """Draw several runs of one trajectory side by side.

    Args:
        runs: Runs by the labels of their laws.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`: a row of arm motions on one scale, then over time the largest torque and the
        self-motion speed ‖θ̇_H‖ (logarithmic, for they differ by orders of magnitude) and the smallest |δ_i|.
    """
    from matplotlib.figure import Figure

    with style():
        plane = drawing_plane(runs.values())
        upper = 1.2 + min(10.0 / len(runs) * motion_shape(runs.values(), plane), 2.4)
        figure: Any = Figure(figsize=(12.0, upper + 4.2), layout="constrained")
        top, bottom = figure.subfigures(2, 1, height_ratios=(upper, 4.2))
        motions = top.subplots(1, len(runs), sharex=True, sharey=True, squeeze=False)[0]
        for axes, (label, run) in zip(motions, runs.items(), strict=True):
            time_colour = draw_arm_motion(axes, run, plane, _end(runs.values()))
            axes.set_title(law_name(label), fontsize=11.0 if len(runs) <= 4 else 9.0)
            axes.label_outer()
            axes.locator_params(axis="y", nbins=5)
            if axes.get_legend() is not None:
                axes.get_legend().remove()
        top.colorbar(time_colour, ax=motions, label="time (s)", shrink=0.8)
        torque, self_motion, minor = bottom.subplots(1, 3)
        unit = minor_unit(next(iter(runs.values())).arm)
        for index, (label, run) in enumerate(runs.items()):
            look = {"color": COLOURS[index % 7], "linestyle": DASHES[index % 7], "label": law_name(label)}
            torque.plot(run.t, np.abs(run.tau).max(axis=1), **look)
            self_motion.plot(run.t[1:], np.linalg.norm(run.homogeneous_velocity, axis=1)[1:], **look)
            signed = np.delete(run.minors, run.arm.minors_on_border(run.q[0]), axis=1)
            minor.plot(run.t, np.abs(signed).min(axis=1, initial=np.inf), **look)
        torque.set(title="largest joint torque", ylabel=r"max$_i\,|\tau_i|$ (N m)", xlabel="time (s)")
        self_motion.set(title="self-motion", ylabel=r"$\|\dot{\theta}_H\|$ (rad/s)", xlabel="time (s)")
        minor.set(title="distance to the aspect's border", ylabel=f"min$_i\\,|\\delta_i|$ ({unit})", xlabel="time (s)")
        minor.set_ylim(bottom=0.0)
        for axes in (torque, self_motion, minor):
            _put_steady_curves_in_front(axes)
            axes.set_xlim(0.0, _end(runs.values()))
        _use_log_scale(torque, bottom=None)
        _use_log_scale(self_motion, bottom=1e-6)
        bottom.legend(*torque.get_legend_handles_labels(), loc="outside upper center", ncols=len(runs))
        if title:
            top.suptitle(title)
        return figure


def _put_steady_curves_in_front(axes: Any) -> None:
    """Let no curve that goes up and down a thousand times hide one that does not."""
    for curve in axes.get_lines():
        values = np.asarray(curve.get_ydata(), dtype=np.float64)
        variation = total_variation(values[np.isfinite(values), np.newaxis])
        curve.set_zorder(2.0 + 1.0 / (1.0 + float(variation[0])))


def _use_log_scale(axes: Any, bottom: float | None) -> None:
    """Make the vertical axis logarithmic, unless there is nothing above zero to show."""
    if any(np.any(np.asarray(line.get_ydata()) > (bottom or 0.0)) for line in axes.get_lines()):
        axes.set_yscale("log")
        axes.set_ylim(bottom=bottom)


def _end(runs: Iterable[Run]) -> float:
    """Return the time at which the longest of several runs ends, s; one sample at least."""
    return max(max(float(run.t[-1]), run.info.dt) for run in runs)


def save_figure(figure: Any, path: str | os.PathLike[str]) -> None:
    """Write a figure to a file, in the format that its suffix names.

    The files depend on nothing but the figure: no dates, no random identifiers.

    Raises:
        OutputError: If it cannot be written.
        UnknownNameError: If the suffix names no format.
    """
    suffix = file_path("the figure", path, OutputError).suffix.lower().removeprefix(".")
    known_name(suffix, list(figure.canvas.get_supported_filetypes()), "format of a figure", context=str(path))
    with style(), atomic_path(path) as temporary:
        metadata = {"Date": None} if temporary.suffix == ".svg" else {}
        figure.savefig(temporary, metadata=metadata)
