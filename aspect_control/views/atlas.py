"""The atlas and the stability map as figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis import minor_zero_crossings
from ..aspects import Atlas, Axis
from ..exceptions import ParameterError
from ..redundancy import Array
from ..simulation import Run
from .panels import MOST_NAMED
from .style import COLOURS, law_name, style

MOST_SIGNATURES = 8
"""The most aspect signatures that get a colour of their own."""

PATH_COLOURS = ("#000000", "#8B1A00", "#00429D", "#6A3D00", "#5B0070", "#004D33", "#444444")
"""Dark colours of the laws' paths, to be seen on the light ones of the aspects."""

PATH_DASHES: tuple[Any, ...] = ((0, (4, 1.2)), "-", (0, (1.2, 1)), (0, (6, 1.5, 1.2, 1.5)), "-", "-", "-")
"""Line styles that go with them."""

_LIGHT, _LIGHTER = 0.25, 0.66
"""How much white is in the colour of a signature and in that of its antipode."""


_RELIEF = 0.22
"""How much the hillshading changes a colour."""


def atlas_figure(atlas: Atlas, runs: Mapping[str, Run], title: str = "") -> Any:
    """Draw aspects, borders and the minor measure over a slice, and the paths of runs over them.

    Args:
        atlas: The atlas.
        runs: Runs of the same arm by the labels of their laws.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`. Up to eight signatures have a colour each, a signature and its antipode (all signs
        turned) the same hue; of more, the colour says how many minors have another sign than at the start. Hillshading
        and thin contours are the minor measure. Circles mark where a path crosses a border.
    """
    from matplotlib.figure import Figure

    with style():
        figure: Any = Figure(figsize=(10.0, 8.2), layout="constrained")
        axes = figure.subplots()
        signs, which, _ = atlas.signatures
        if len(signs) <= MOST_SIGNATURES:
            colours = _signature_colours(signs)
            flat = colours[which]
            _signature_legend(figure, atlas, colours)
        else:
            flat = _distance_colours(figure, axes, atlas)
        _draw_image(axes, atlas, _relief(flat, atlas.minor_measure))
        _draw_borders(axes, atlas)
        _draw_limits(axes, atlas)
        _draw_paths(axes, atlas, runs)
        _finish(figure, axes, atlas, title)
        return figure


def stability_figure(atlas: Atlas, runs: Mapping[str, Run], title: str = "") -> Any:
    """Draw c of s̈ = −c ṡ² over a slice, with the direction of the self-motion, and the paths of runs over it.

    Args:
        atlas: The atlas of an arm with one joint to spare.
        runs: Runs of the same arm by the labels of their laws.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`. Arrows show the direction of `null_vector`, for which the colours hold: for travel
        against them c has the other sign.

    Raises:
        ParameterError: If not exactly one joint is to spare.
    """
    from matplotlib.figure import Figure

    if atlas.stability is None or atlas.direction is None:
        raise ParameterError(
            f"the stability map is for an arm with one joint to spare; the task {atlas.arm.task} leaves "
            f"{atlas.arm.redundancy} of {atlas.arm.nv}"
        )
    with style():
        figure: Any = Figure(figsize=(10.0, 8.2), layout="constrained")
        axes = figure.subplots()
        limit = float(np.quantile(np.abs(atlas.stability), 0.98))
        image = axes.pcolormesh(
            *_shown(atlas),
            atlas.stability,
            cmap="PuOr",
            vmin=-limit,
            vmax=limit,
            shading="nearest",
            rasterized=True,
        )
        bar = figure.colorbar(image, ax=axes, shrink=0.85, extend="both")
        bar.set_label("c (1/rad) for travel along the arrows: fed below 0, braked above")
        _draw_direction(axes, atlas, atlas.direction)
        _draw_limits(axes, atlas)
        _draw_paths(axes, atlas, runs)
        _finish(figure, axes, atlas, title)
        return figure


def _signature_colours(signs: NDArray[np.int8]) -> Array:
    """Return one colour a signature, shape (c, 3): antipodes share a hue."""
    from matplotlib.colors import to_rgb

    hues = [COLOURS[i] for i in (0, 1, 2, 3, 5, 4)]
    colours = np.empty((len(signs), 3))
    pairs: dict[tuple[int, ...], str] = {}
    for row, each in enumerate(signs):
        own, antipode = tuple(each.tolist()), tuple((-each).tolist())
        lighter = antipode in pairs
        hue = pairs[antipode] if lighter else hues[len(pairs) % len(hues)]
        pairs.setdefault(antipode if lighter else own, hue)
        share = _LIGHTER if lighter else _LIGHT
        colours[row] = (1.0 - share) * np.array(to_rgb(hue)) + share
    return colours


def _signature_legend(figure: Any, atlas: Atlas, colours: Array) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    signs = atlas.signatures[0]
    named = len(signs[0]) <= MOST_NAMED
    words = {-1: "−", 0: "0", 1: "+"}
    patches = [
        Patch(color=colour, label=" ".join(words[int(sign)] for sign in each) if named else f"aspect {row + 1}")
        for row, (each, colour) in enumerate(zip(signs, colours, strict=True))
    ]
    heading = "signs of " + ", ".join(f"$\\delta_{i + 1}$" for i in range(len(signs[0]))) if named else "signatures"
    borders = [
        Line2D(
            [], [], color="black", linewidth=1.3, linestyle=_border_dashes(index), label=f"$\\delta_{index + 1} = 0$"
        )
        for index in range(len(signs[0]) if named else 0)
    ]
    figure.legend(handles=[*patches, *borders], title=heading, loc="outside right upper", handlelength=2.6)


def _distance_colours(figure: Any, axes: Any, atlas: Atlas) -> Array:
    """Return colours by the number of minors that have another sign than at the start of the slice, shape (l, k, 3)."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap

    start = atlas.start_signs()
    known = start != 0
    distance = np.count_nonzero(np.sign(atlas.minors)[..., known] != start[known], axis=-1)
    most = int(distance.max())
    levels = colormaps["viridis"](np.linspace(1.0, 0.12, most + 1))[:, :3] * 0.72 + 0.28
    mapping = ScalarMappable(BoundaryNorm(np.arange(-0.5, most + 1.0), most + 1), ListedColormap(levels))
    bar = figure.colorbar(mapping, ax=axes, shrink=0.85, ticks=range(0, most + 1, max(1, most // 8)))
    signatures = len(atlas.signatures[0])
    bar.set_label(f"minors of another sign than at the start, of {known.sum()} ({signatures} signatures in the slice)")
    colours: Array = levels[distance]
    return colours


def _relief(colours: Array, height: Array) -> Array:
    """Shade colours, shape (l, k, 3), by the slope of a surface lit from the upper left."""
    from matplotlib.colors import LightSource

    exaggeration = 0.25 * height.shape[0] / max(float(height.max()), 1e-300)
    light = LightSource(azdeg=315.0, altdeg=50.0).hillshade(height, vert_exag=exaggeration)
    # Little enough that the light and the dark colour of a pair of antipodes stay apart.
    shaded: Array = colours * (1.0 + _RELIEF * (light - np.median(light)))[..., np.newaxis]
    return np.clip(shaded, 0.0, 1.0)


def _draw_image(axes: Any, atlas: Atlas, colours: Array) -> None:
    a, b = atlas.slice.horizontal, atlas.slice.vertical
    extent = (*_range(a), *_range(b))
    axes.imshow(colours, origin="lower", extent=extent, aspect="auto", interpolation="nearest", zorder=0)


def _draw_borders(axes: Any, atlas: Atlas) -> None:
    """Draw where each minor is zero, in a line style of its own if there are few, and contours of H."""
    a, b = _shown(atlas)
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
            linestyles=[_border_dashes(index) if named else "solid"],
            linewidths=1.3 if named else 0.6,
        )


def _beyond_the_edges(atlas: Atlas) -> tuple[Array, Array, Array]:
    """Return the grid and the minors with a row more on both sides of a whole turn: borders may lie on the edge."""
    (a, b), minors = _shown(atlas), atlas.minors
    if atlas.slice.horizontal.full_turn:
        a, minors = np.pad(a, 1, mode="reflect", reflect_type="odd"), np.pad(minors, ((0, 0), (1, 1), (0, 0)), "wrap")
    if atlas.slice.vertical.full_turn:
        b, minors = np.pad(b, 1, mode="reflect", reflect_type="odd"), np.pad(minors, ((1, 1), (0, 0), (0, 0)), "wrap")
    return a, b, minors


def _border_dashes(index: int) -> Any:
    dashes: tuple[Any, ...] = ("solid", (0, (7, 2)), (0, (2, 1.4)), (0, (7, 2, 1.5, 2)))
    return dashes[index % 4]


def _draw_limits(axes: Any, atlas: Atlas) -> None:
    if atlas.within_limits.all():
        return
    beyond = np.where(atlas.within_limits, 0.0, 1.0)
    hatched = axes.contourf(*_shown(atlas), beyond, levels=[0.5, 1.5], colors="none", hatches=["///"])
    hatched.set_edgecolor("0.35")
    axes.plot([], [], color="0.35", linewidth=0.0, marker="$///$", markersize=12, label="beyond a joint limit")


def _draw_direction(axes: Any, atlas: Atlas, direction: Array) -> None:
    """Draw unit arrows along the self-motion where it runs in the slice at all."""
    every = max(1, len(atlas.a) // 24)
    picked = np.arange(every // 2, len(atlas.a), every)
    a, b = _shown(atlas)
    components = atlas.slice.direction(atlas.a[picked], direction[np.ix_(picked, picked)])
    shown = components * [_factor(atlas.slice.horizontal), _factor(atlas.slice.vertical)]
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


def _draw_paths(axes: Any, atlas: Atlas, runs: Mapping[str, Run]) -> None:
    from matplotlib.patheffects import Normal, Stroke

    factors = np.array([_factor(axis) for axis in (atlas.slice.horizontal, atlas.slice.vertical)])
    spans = np.array([_range(axis)[1] - _range(axis)[0] for axis in (atlas.slice.horizontal, atlas.slice.vertical)])
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


def _finish(figure: Any, axes: Any, atlas: Atlas, title: str) -> None:
    a, b = atlas.slice.horizontal, atlas.slice.vertical
    axes.set(xlabel=_axis_label(a), ylabel=_axis_label(b), xlim=_range(a), ylim=_range(b))
    for axis, setter in ((a, axes.set_xticks), (b, axes.set_yticks)):
        if axis.angle and axis.high - axis.low > 5.0:
            low, high = _range(axis)
            setter(np.arange(np.ceil(low / 60.0) * 60.0, high + 1e-6, 60.0))
    axes.grid(False)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.suptitle(title)


def _shown(atlas: Atlas) -> tuple[Array, Array]:
    """Return the coordinates of the grid as the axes show them."""
    return atlas.a * _factor(atlas.slice.horizontal), atlas.b * _factor(atlas.slice.vertical)


def _factor(axis: Axis) -> float:
    return 180.0 / np.pi if axis.angle else 1.0


def _range(axis: Axis) -> tuple[float, float]:
    return axis.low * _factor(axis), axis.high * _factor(axis)


def _axis_label(axis: Axis) -> str:
    return f"{axis.name} ({'°' if axis.angle else axis.unit})"
