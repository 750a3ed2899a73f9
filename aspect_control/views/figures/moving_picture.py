"""Runs side by side as one picture that moves: the arms, and below them their torques."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...redundancy import Array
from ...simulation import Run
from ..frames import aspect_changes, finite_part, samples_at
from ..style import COLOURS, DASHES, plain_text
from .moving_arm import Motion, MovingArm, drawing_axes, limits

WIDTH = 9.0
"""Width of the picture, inches of 100 pixels."""

FLASH = 0.25
"""How long a panel is tinted after a change of the aspect, s of the moving picture."""

TINT = 0.17
"""How strongly it is tinted."""

LOGARITHMIC_FROM = 100.0
"""Ratio of the largest torque shown to the typical one from which the scale is logarithmic."""


class MovingPicture:
    """The picture at any time of the runs.

    Attributes:
        figure: The `matplotlib.figure.Figure`.
        panels: The axes of each arm, in the order of the runs.
        torques: The axes of the torques.
    """

    def __init__(self, runs: Mapping[str, Run], speed: float = 1.0, title: str = "") -> None:
        """Lay the picture out, once for all frames.

        Args:
            runs: Runs by their labels.
            speed: As for `animation.animate`.
            title: As for `animation.animate`.
        """
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self._runs = [finite_part(run) for run in runs.values()]
        self._ends = [_early_end(run, part) for run, part in zip(runs.values(), self._runs, strict=True)]
        self._changes = [aspect_changes(run) for run in self._runs]
        self._speed, self._title = speed, plain_text(title)
        motions = [Motion(run) for run in self._runs]
        columns = drawing_axes(self._runs, motions)
        spans = limits(motions, columns)
        across = len(runs) if len(runs) <= 3 else math.ceil(len(runs) / 2)
        down = math.ceil(len(runs) / across)
        titles = [textwrap.fill(label, 26 if across > 2 else 40, break_on_hyphens=False) for label in runs]
        height = 0.2 * max(heading.count("\n") for heading in titles) + _panel_height(spans, WIDTH / max(across, 1.4))
        names = [f"joint {joint + 1}" for joint in range(self._runs[0].arm.nv)] if len(runs) == 1 else list(runs)
        legend_columns = _legend_columns(names)
        below = 2.8 + 0.22 * math.ceil(len(names) / legend_columns)
        # Videos need an even number of rows of pixels.
        figure: Any = Figure(
            figsize=(WIDTH, round(50.0 * (down * height + 0.3 + below)) / 50.0), dpi=100, layout="constrained"
        )
        FigureCanvasAgg(figure)
        self.figure = figure
        top, bottom = figure.subfigures(2, 1, height_ratios=(down * height + 0.3, below))
        projection = {"projection": "3d"} if len(columns) == 3 else {}
        grid = top.subplots(down, across, squeeze=False, subplot_kw=projection)
        self.panels = list(grid.flat)[: len(runs)]
        for axes in list(grid.flat)[len(runs) :]:
            axes.set_visible(False)
        self._arms = []
        for index, (axes, heading, motion) in enumerate(zip(self.panels, titles, motions, strict=True)):
            self._arms.append(MovingArm(axes, motion, columns, COLOURS[index % 7]))
            _set_scales(axes, spans)
            axes.set_title(heading, color=COLOURS[index % 7], fontweight="bold")
        self._notes = [_note(axes) for axes in self.panels]
        self.torques: Any = bottom.subplots()
        self._draw_torques(bottom, names, legend_columns)
        self._heading = self.figure.suptitle(self._time_text(0.0), fontfamily="monospace")
        self._tints = [_tint(top, axes) for axes in self.panels]
        self._show(float(self._runs[0].t[0]))
        figure.canvas.draw()
        figure.set_layout_engine("none")
        for arm, axes in zip(self._arms, self.panels, strict=True):
            arm.fit(axes.get_window_extent().width)
        self._moving = [
            *self._tints,
            *(artist for arm in self._arms for artist in arm.moving),
            *self._notes,
            *(artist for pair in self._lines for artist in pair),
            self._now,
            self._heading,
        ]
        for artist in self._moving:
            artist.set_animated(True)
        figure.canvas.draw()
        self._still = figure.canvas.copy_from_bbox(figure.bbox)

    def frame(self, time: float) -> NDArray[np.uint8]:
        """Return the picture at a time, s, as pixels, shape (height, width, 4).

        What does not move is drawn once, for all frames.
        """
        self._show(time)
        self.figure.canvas.restore_region(self._still)
        for artist in self._moving:
            artist.draw(self.figure.canvas.get_renderer())
        return np.array(self.figure.canvas.buffer_rgba())

    def _show(self, time: float) -> None:
        self._heading.set_text(self._time_text(time))
        self._now.set_xdata([time, time])
        for index, run in enumerate(self._runs):
            ended = self._ends[index] is not None and time >= float(run.t[-1])
            sample = int(samples_at(run, np.array([time]))[0])
            self._arms[index].show(sample, ended)
            self._show_note(index, time, ended)
        for (line, mark), (t, values) in zip(self._lines, self._curves, strict=True):
            count = int(np.searchsorted(t, time + 1e-9, side="right"))
            line.set_data(t[:count], values[:count])
            mark.set_data(t[count - 1 : count], values[count - 1 : count])
            mark.set_visible(time <= t[-1])

    def _show_note(self, index: int, time: float, ended: bool) -> None:
        passed = self._changes[index][self._changes[index] <= time]
        tinted = len(passed) > 0 and (time - passed[-1]) / self._speed < FLASH
        self._tints[index].set_visible(tinted)
        count = f"aspect changes: {len(passed)}"
        self._notes[index].set_text(f"{count}\n{self._ends[index]}" if ended else count)
        self._notes[index].set_color(COLOURS[1] if ended or tinted else "black")

    def _draw_torques(self, bottom: Any, names: Sequence[str], legend_columns: int) -> None:
        axes, single = self.torques, len(self._runs) == 1
        magnitudes = [np.abs(run.tau) for run in self._runs]
        typical = min(float(np.median(magnitude.max(axis=1))) for magnitude in magnitudes)
        logarithmic = max(float(magnitude.max()) for magnitude in magnitudes) > LOGARITHMIC_FROM * typical > 0.0
        if single:
            run = self._runs[0]
            self._curves = [(run.t, tau) for tau in (magnitudes[0] if logarithmic else run.tau).T]
            axes.set(title="joint torques", ylabel=r"$|\tau_i|$ (N m)" if logarithmic else r"$\tau_i$ (N m)")
        else:
            self._curves = [(run.t, values.max(axis=1)) for run, values in zip(self._runs, magnitudes, strict=True)]
            axes.set(title="largest joint torque", ylabel=r"max$_i\,|\tau_i|$ (N m)")
        axes.set_xlabel("time (s)")
        self._lines = []
        for index, (name, (t, values)) in enumerate(zip(names, self._curves, strict=True)):
            colour, dashes = COLOURS[index % 7], DASHES[index % 7]
            axes.plot(t, values, color=colour, alpha=0.25, linewidth=1.2)
            (line,) = axes.plot([], [], color=colour, linestyle=dashes, linewidth=1.9, label=name)
            (mark,) = axes.plot([], [], "o", color=colour, markersize=6.0, markeredgecolor="white")
            self._lines.append((line, mark))
        self._now = axes.axvline(0.0, color="black", linewidth=0.8)
        events = self._mark_events()
        if logarithmic:
            axes.set_yscale("log")
            axes.set_ylim(bottom=0.1 * typical)
        start, end = min(float(run.t[0]) for run in self._runs), max(float(run.t[-1]) for run in self._runs)
        axes.set_xlim(start, max(end, start + self._runs[0].info.dt))
        bottom.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=legend_columns)
        handles, names = self.panels[0].get_legend_handles_labels()
        bottom.legend([*handles, *events.values()], [*names, *events], loc="outside lower center", ncols=4)

    def _mark_events(self) -> dict[str, Any]:
        """Mark on the torques where an aspect changes and where a run ended early; return the marks by their names."""
        named, single = {}, len(self._runs) == 1
        look = {"linestyle": "none", "color": "black", "zorder": 5}
        for run, changes, end in zip(self._runs, self._changes, self._ends, strict=True):
            largest = np.abs(run.tau).max(axis=1)
            if single:
                for change in changes:
                    named["change of the aspect"] = self.torques.axvline(change, color="black", linewidth=1.0, ls=":")
            elif len(changes):
                named["change of the aspect"] = self.torques.plot(
                    changes, largest[samples_at(run, changes)], marker="o", fillstyle="none", markersize=6.0, **look
                )[0]
            if end is not None:
                ends = [values[-1] for _, values in self._curves] if single else [largest[-1]]
                named["early end"] = self.torques.plot(
                    [run.t[-1]] * len(ends),
                    ends,
                    marker="x",
                    markersize=9.0,
                    markeredgewidth=2.0,
                    clip_on=False,
                    **look,
                )[0]
        return named

    def _time_text(self, time: float) -> str:
        pace = "" if self._speed == 1.0 else f", speed × {self._speed:g}"
        return f"{self._title}{'   ' if self._title else ''}t = {time:.2f} s{pace}"


def _early_end(run: Run, part: Run) -> str | None:
    """Return how a run ended before its time, in a few words, or None."""
    if run.status != "finished":
        return f"{run.status} at t = {part.t[-1]:.3f} s"
    return None if len(part.t) == len(run.t) else f"not finite after t = {part.t[-1]:.3f} s"


def _legend_columns(names: Sequence[str]) -> int:
    """Return how many names fit side by side above the torques."""
    return max(1, min(len(names), int(10.0 * WIDTH / (max(map(len, names)) + 7))))


def _panel_height(spans: Array, width: float) -> float:
    """Return how high a panel of a width is, inches, for its scales to be equal."""
    if len(spans) == 3:
        return min(width, 4.6)
    across, up = np.ptp(spans, axis=1)
    return float(np.clip((width - 0.7) * up / across + 0.8, 2.0, 4.6))


def _set_scales(axes: Any, spans: Array) -> None:
    axes.set(xlim=spans[0], ylim=spans[1])
    if len(spans) == 3:
        axes.set(zlim=spans[2])
        axes.set_box_aspect(np.ptp(spans, axis=1))
        axes.locator_params(nbins=3)
        axes.tick_params(labelsize=8.0, pad=0.0)
        for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
            axis.labelpad = -4.0
            axis.label.set_fontsize(9.0)
    else:
        axes.set_aspect("equal")


def _tint(figure: Any, axes: Any) -> Any:
    from matplotlib.patches import Rectangle

    # Three-dimensional axes take no flat patches of their own.
    return figure.add_artist(
        Rectangle((0.0, 0.0), 1.0, 1.0, transform=axes.transAxes, color=COLOURS[1], alpha=TINT, linewidth=0.0)
    )


def _note(axes: Any) -> Any:
    place = (0.02, 0.98)
    text = axes.text2D if hasattr(axes, "text2D") else axes.text
    return text(*place, "", transform=axes.transAxes, va="top", fontsize=10.0, zorder=7)
