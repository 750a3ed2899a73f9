"""The atlas and the stability map as figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...aspects import Atlas
from ...exceptions import ParameterError
from ...redundancy import Array
from ...simulation import Run
from ..style import COLOURS, style
from .atlas_layers import (
    MOST_SIGNATURES,
    axis_label,
    border_dashes,
    draw_borders,
    draw_direction,
    draw_limits,
    draw_paths,
    shown_grid,
    shown_range,
)
from .panels import MOST_NAMED

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
        draw_borders(axes, atlas)
        draw_limits(axes, atlas)
        draw_paths(axes, atlas, runs)
        _finish(figure, axes, atlas, title)
        return figure


def stability_figure(atlas: Atlas, runs: Mapping[str, Run], title: str = "") -> Any:
    """Draw c of s̈ = −c ṡ² over a slice, with the direction of the self-motion, and the paths of runs over it.

    Args:
        atlas: The atlas of one redundant degree of freedom.
        runs: Runs of the same arm by the labels of their laws.
        title: Heading of the figure.

    Returns:
        A `matplotlib.figure.Figure`. Arrows show the direction of `null_vector`, for which the colours hold: for travel
        against them c has the other sign.

    Raises:
        ParameterError: If there is not exactly one redundant degree of freedom.
    """
    from matplotlib.figure import Figure

    if atlas.stability is None or atlas.direction is None:
        raise ParameterError(
            f"the stability map is for one redundant degree of freedom; the task {atlas.arm.task} leaves "
            f"{atlas.arm.redundancy} of {atlas.arm.nv}"
        )
    with style():
        figure: Any = Figure(figsize=(10.0, 8.2), layout="constrained")
        axes = figure.subplots()
        limit = float(np.quantile(np.abs(atlas.stability), 0.98))
        image = axes.pcolormesh(
            *shown_grid(atlas),
            atlas.stability,
            cmap="PuOr",
            vmin=-limit,
            vmax=limit,
            shading="nearest",
            rasterized=True,
        )
        bar = figure.colorbar(image, ax=axes, shrink=0.85, extend="both")
        bar.set_label("c (1/rad) for travel along the arrows: fed below 0, braked above")
        draw_direction(axes, atlas, atlas.direction)
        draw_limits(axes, atlas)
        draw_paths(axes, atlas, runs)
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
        Line2D([], [], color="black", linewidth=1.3, linestyle=border_dashes(index), label=f"$\\delta_{index + 1} = 0$")
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
    extent = (*shown_range(a), *shown_range(b))
    axes.imshow(colours, origin="lower", extent=extent, aspect="auto", interpolation="nearest", zorder=0)


def _finish(figure: Any, axes: Any, atlas: Atlas, title: str) -> None:
    a, b = atlas.slice.horizontal, atlas.slice.vertical
    axes.set(xlabel=axis_label(a), ylabel=axis_label(b), xlim=shown_range(a), ylim=shown_range(b))
    for axis, setter in ((a, axes.set_xticks), (b, axes.set_yticks)):
        if axis.angle and axis.high - axis.low > 5.0:
            low, high = shown_range(axis)
            setter(np.arange(np.ceil(low / 60.0) * 60.0, high + 1e-6, 60.0))
    axes.grid(False)
    if axes.get_legend_handles_labels()[0]:
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.suptitle(title)
