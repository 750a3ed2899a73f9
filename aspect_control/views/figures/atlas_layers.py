"""What is drawn over the colours of an atlas: borders, joint limits, directions, paths."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...analysis import minor_zero_crossings
from ...aspects import Atlas, Axis
from ...redundancy import Array
from ...simulation import Run
from ..style import law_name
from .panels import MOST_NAMED

MOST_SIGNATURES = 8
"""The most aspect signatures that get a colour of their own."""

PATH_COLOURS = ("#000000", "#8B1A00", "#00429D", "#6A3D00", "#5B0070", "#004D33", "#444444")
"""Dark colours of the laws' paths, to be seen on the light ones of the aspects."""

PATH_DASHES: tuple[Any, ...] = ((0, (4, 1.2)), "-", (0, (1.2, 1)), (0, (6, 1.5, 1.2, 1.5)), "-", "-", "-")
"""Line styles that go with them."""


def draw_borders(axes: Any, atlas: Atlas) -> None:
    """Draw where each minor is zero, in a line style of its own if there are few, and contours of H."""
    a, b = shown_grid(atlas)
    axes.contour(a, b, atlas.minor_measure, levels=7, colors="white", linewidths=0.7, alpha=0.7)
    a, b, minors = _beyond_the_edges(atlas)
    count = minors.shape[-1]
    named = count <= MOST_NAMED and len(atlas.signatures[0]) <= MOST_SIGNATURES
    for index in range(count):
        values = minors[..., index]
        if values.min() >= 0.0 or values.max() <= 0.0:
            continue
        axes.contour(
            a,
            b,
            values,
            levels=[0.0],
            colors="black",
            linestyles=[border_dashes(index) if named else "solid"],
            linewidths=1.3 if named else 0.6,
        )


def _beyond_the_edges(atlas: Atlas) -> tuple[Array, Array, Array]:
    """Return the grid and the minors with a row more on both sides of a whole turn: borders may lie on the edge."""
    (a, b), minors = shown_grid(atlas), atlas.minors
    if atlas.slice.horizontal.full_turn:
        a, minors = np.pad(a, 1, mode="reflect", reflect_type="odd"), np.pad(minors, ((0, 0), (1, 1), (0, 0)), "wrap")
    if atlas.slice.vertical.full_turn:
        b, minors = np.pad(b, 1, mode="reflect", reflect_type="odd"), np.pad(minors, ((1, 1), (0, 0), (0, 0)), "wrap")
    return a, b, minors


def border_dashes(index: int) -> Any:
    """Return the line style of the border of a minor, counted from 0."""
    dashes: tuple[Any, ...] = ("solid", (0, (7, 2)), (0, (2, 1.4)), (0, (7, 2, 1.5, 2)))
    return dashes[index % 4]


def draw_limits(axes: Any, atlas: Atlas) -> None:
    """Hatch where a joint is beyond its limits."""
    if atlas.within_limits.all():
        return
    beyond = np.where(atlas.within_limits, 0.0, 1.0)
    hatched = axes.contourf(*shown_grid(atlas), beyond, levels=[0.5, 1.5], colors="none", hatches=["///"])
    hatched.set_edgecolor("0.35")
    axes.plot([], [], color="0.35", linewidth=0.0, marker="$///$", markersize=12, label="beyond a joint limit")


def draw_direction(axes: Any, atlas: Atlas, direction: Array) -> None:
    """Draw unit arrows along the self-motion where it runs in the slice at all."""
    every = max(1, len(atlas.a) // 24)
    picked = np.arange(every // 2, len(atlas.a), every)
    a, b = shown_grid(atlas)
    components = atlas.slice.direction(atlas.a[picked], direction[np.ix_(picked, picked)])
    shown = components * [_display_factor(atlas.slice.horizontal), _display_factor(atlas.slice.vertical)]
    # The arrows point as the axes have it; their length is the part of the self-motion that lies in the slice.
    lengths = np.linalg.norm(components, axis=-1) / np.maximum(np.linalg.norm(shown, axis=-1), 1e-300)
    shown *= lengths[..., np.newaxis]
    axes.quiver(
        a[picked],
        b[picked],
        shown[..., 0],
        shown[..., 1],
        color="0.25",
        pivot="mid",
        angles="xy",
        scale=30.0,
        scale_units="width",
        width=0.0016,
        headwidth=5.0,
    )


def draw_paths(axes: Any, atlas: Atlas, runs: Mapping[str, Run]) -> None:
    """Draw the paths of runs with start, ends, border crossings and the largest torque of all."""
    from matplotlib.patheffects import Normal, Stroke

    factors = np.array([_display_factor(axis) for axis in (atlas.slice.horizontal, atlas.slice.vertical)])
    spans = np.array(
        [shown_range(axis)[1] - shown_range(axis)[0] for axis in (atlas.slice.horizontal, atlas.slice.vertical)]
    )
    marked = False
    for index, (label, run) in enumerate(runs.items()):
        positions = np.array([run.arm.positions(q) for q in run.q])
        path = atlas.slice.trace(positions) * factors
        # A path that leaves on one side of the torus comes back on the other.
        jumps = np.flatnonzero((np.abs(np.diff(path, axis=0)) > 0.5 * spans).any(axis=1)) + 1
        broken = np.insert(path, jumps, np.nan, axis=0)
        colour = PATH_COLOURS[index % 7]
        axes.plot(
            *broken.T,
            color=colour,
            linestyle=PATH_DASHES[index % 7],
            linewidth=1.9,
            label=law_name(label),
            path_effects=[Stroke(linewidth=3.6, foreground="white"), Normal()],
            zorder=4,
        )
        crossings = minor_zero_crossings(run)
        if crossings:
            at = np.searchsorted(run.t, [crossing.time for crossing in crossings]).clip(0, len(run.t) - 1)
            axes.plot(
                *path[at].T, "o", color=colour, markerfacecolor="white", markersize=6.5, markeredgewidth=1.5, zorder=6
            )
            marked = True
        axes.plot(*path[-1], "s", color=colour, markersize=6.0, zorder=5)
        if index == 0:
            axes.plot(*path[0], "*", color="black", markerfacecolor="white", markersize=15.0, zorder=7)
    if runs:
        highest = max(runs.values(), key=lambda run: float(np.abs(run.tau).max()))
        moment = int(np.abs(highest.tau).max(axis=1).argmax())
        place = atlas.slice.trace(highest.arm.positions(highest.q[moment])[np.newaxis])[0] * factors
        axes.plot(*place, "X", color="#FFD400", markeredgecolor="black", markersize=11.0, zorder=8)
        axes.plot([], [], "X", color="#FFD400", markeredgecolor="black", markersize=9.0, label="largest torque")
        axes.plot([], [], "*", color="black", markerfacecolor="white", markersize=13.0, label="start")
        axes.plot([], [], "s", color="black", markersize=6.0, linestyle="none", label="end")
    if marked:
        axes.plot([], [], "o", color="black", markerfacecolor="white", markersize=6.5, label="border crossed")


def shown_grid(atlas: Atlas) -> tuple[Array, Array]:
    """Return the coordinates of the grid as the axes show them."""
    return atlas.a * _display_factor(atlas.slice.horizontal), atlas.b * _display_factor(atlas.slice.vertical)


def _display_factor(axis: Axis) -> float:
    return 180.0 / np.pi if axis.angle else 1.0


def shown_range(axis: Axis) -> tuple[float, float]:
    """Return the smallest and the largest value of a coordinate as the axes show it."""
    return axis.low * _display_factor(axis), axis.high * _display_factor(axis)


def axis_label(axis: Axis) -> str:
    """Return the name of a coordinate with the unit that the axes show it in."""
    return f"{axis.name} ({'°' if axis.angle else axis.unit})"
