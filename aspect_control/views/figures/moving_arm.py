"""An arm that moves: drawn in its plane if it has one, else in space above its shadow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...arm.tasks import AXES
from ...redundancy import Array
from ...simulation import Run
from .panels import desired_positions, drawing_plane

LINK_WIDTH = 0.028
"""Width of the first link as a part of the width of what is shown; the last link is half as wide."""

DARK = "#33373D"
"""Colour of joints, base and outlines."""

VIEW = (22.0, -60.0)
"""Elevation and azimuth from which a spatial arm is seen, degrees."""


class Motion:
    """Where an arm and its tip are at every sample of a run.

    Attributes:
        points: Joints and task frame as of `Arm.skeleton`, shape (k, nv + 1, 3), m.
        desired: The desired path in the world frame, shape (k, 3), m; NaN in directions that are free.
    """

    def __init__(self, run: Run) -> None:
        """Compute the positions of a finite run."""
        self.points: Array = np.array([run.arm.skeleton(q) for q in run.q])
        self.desired = desired_positions(run)


def drawing_axes(runs: Sequence[Run], motions: Sequence[Motion]) -> tuple[int, ...]:
    """Return the world axes, 0 to 2, in which runs are drawn: two if every arm stays in one plane, else all three."""
    plane = drawing_plane(runs)
    (across,) = {0, 1, 2} - set(plane)
    points = np.concatenate([motion.points.reshape(-1, 3) for motion in motions])
    return plane if np.ptp(points[:, across]) <= 1e-6 * np.ptp(points, axis=0).max() else (0, 1, 2)


class MovingArm:
    """The arm of one run in axes of its own.

    Attributes:
        moving: The artists that change from frame to frame, in the order in which they are drawn.
    """

    def __init__(self, axes: Any, motion: Motion, columns: tuple[int, ...], colour: str) -> None:
        """Draw what does not move, and the arm in its first posture.

        Args:
            axes: The `matplotlib.axes.Axes` to draw into; three-dimensional for three columns.
            motion: Where the arm is.
            columns: World axes to draw, as of `drawing_axes`.
            colour: Colour of the links.
        """
        self._axes = axes
        self._points = motion.points[..., list(columns)]
        desired = motion.desired[:, list(columns)]
        if np.isfinite(desired).all():
            axes.plot(*desired.T, color="black", linestyle=(0, (4, 3)), linewidth=1.2, label="desired path")
        (self._trace,) = axes.plot(*self._tip(1), color=colour, alpha=0.45, linewidth=3.0, label="trace of the tip")
        self._shadow = None
        if len(columns) == 3:
            (self._shadow,) = axes.plot(*self._points[0].T, color="black", alpha=0.15, linewidth=3.5)
        (self._base,) = axes.plot(*self._points[0, :1].T, "o", color=DARK, zorder=3)
        links = range(self._points.shape[1] - 1)
        self._outlines = [axes.plot(*self._link(0, i), color=DARK, solid_capstyle="round")[0] for i in links]
        self._links = [axes.plot(*self._link(0, i), color=colour, solid_capstyle="round")[0] for i in links]
        (self._joints,) = axes.plot(
            *self._points[0, :-1].T, "o", color="white", markeredgecolor=DARK, markeredgewidth=1.6
        )
        (self._tip_mark,) = axes.plot(
            *self._points[0, -1:].T, "o", color="black", markeredgecolor="white", markeredgewidth=1.0
        )
        axes.set(xlabel=f"{AXES[columns[0]]} (m)", ylabel=f"{AXES[columns[1]]} (m)")
        shadow = [] if self._shadow is None else [self._shadow]
        self.moving = [*shadow, self._trace, *self._outlines, *self._links, self._joints, self._tip_mark]
        if len(columns) == 3:
            axes.set(zlabel=f"{AXES[columns[2]]} (m)")
            axes.view_init(*VIEW)
        self.fit(axes.get_window_extent().width)

    def fit(self, width: float) -> None:
        """Make the links as thick as suits axes of a width in pixels."""
        thickness = LINK_WIDTH * width * 72.0 / self._axes.figure.dpi
        widths = np.linspace(1.0, 0.5, len(self._links)) * thickness
        for link, outline, wide in zip(self._links, self._outlines, widths, strict=True):
            link.set_linewidth(wide)
            outline.set_linewidth(wide + 1.6)
        self._base.set_markersize(2.0 * thickness)
        self._joints.set_markersize(1.1 * thickness)
        self._tip_mark.set_markersize(0.75 * thickness)

    def show(self, sample: int, ended: bool) -> None:
        """Move the arm to a sample; one whose run has ended early stands there faintly.

        Args:
            sample: Index of the sample.
            ended: Whether the run is over before its time.
        """
        for i, (link, outline) in enumerate(zip(self._links, self._outlines, strict=True)):
            _move(link, self._link(sample, i))
            _move(outline, self._link(sample, i))
            link.set_alpha(0.35 if ended else None)
            outline.set_visible(not ended)
        _move(self._joints, self._points[sample, :-1].T)
        _move(self._tip_mark, self._points[sample, -1:].T)
        _move(self._trace, self._tip(sample + 1))
        if self._shadow is not None:
            x, y, z = self._points[sample].T
            _move(self._shadow, (x, y, np.full_like(z, self._axes.get_zlim()[0])))

    def _tip(self, samples: int) -> Array:
        path: Array = self._points[:samples, -1].T
        return path

    def _link(self, sample: int, link: int) -> Array:
        ends: Array = self._points[sample, link : link + 2].T
        return ends


def limits(motions: Sequence[Motion], columns: tuple[int, ...]) -> Array:
    """Return what axes must show so that no arm leaves them, shape (2 or 3, 2), m, with a margin.

    Spatial arms stand on the floor: their limits begin at the base, or below it if they reach there.
    """
    points = np.concatenate([np.concatenate([motion.points.reshape(-1, 3), motion.desired]) for motion in motions])
    low, high = np.nanmin(points, axis=0)[list(columns)], np.nanmax(points, axis=0)[list(columns)]
    if len(columns) == 3:
        low[2] = min(low[2], 0.0)
    margin = 0.05 * (high - low).max()
    return np.stack([low - margin, high + margin], axis=1)


def _move(line: Any, data: Any) -> None:
    (line.set_data if len(data) == 2 else line.set_data_3d)(*data)
