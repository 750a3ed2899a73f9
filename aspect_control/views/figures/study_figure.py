"""The figures of any study: what each law came to, and how that moves along the keys of a grid."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...studies.proportion import Proportion
from ...studies.study_summary import THRESHOLD, study_summary, varying_keys
from ..style import COLOURS, law_name, plain_text, style

if TYPE_CHECKING:
    import pyarrow as pa

SHARES = {"kept": "kept the aspect", "exploded": f"exploded, beyond {THRESHOLD:g} times the reference"}
"""The shares that are drawn, and their headings."""

UNITS = {"dt": "s", "duration": "s", "kp": "1/s²", "kv": "1/s"}
"""Units of keys of a grid, by the last part of their names."""

_MARKERS = "os^Dv*P"


def study_figure(table: pa.Table) -> Any:
    """Draw what each law came to on each scenario, all points of a grid together.

    Args:
        table: The table of a study.

    Returns:
        A `matplotlib.figure.Figure` with a line a scenario and law: the shares of the runs that kept their aspect and
        of those that exploded, with their 95 % intervals, and the median and the 95th percentile of the peak torque.
    """
    from matplotlib.figure import Figure

    summaries = study_summary(table)
    scenarios = list(dict.fromkeys(each.group["scenario"] for each in summaries))
    looks = _looks(each.group["law"] for each in summaries)
    # A line between two scenarios holds the name of the next.
    places = [index + 2.0 + scenarios.index(each.group["scenario"]) for index, each in enumerate(summaries)]
    with style():
        figure: Any = Figure(figsize=(10.0, 1.1 + 0.27 * (places[-1] + 1.0)), layout="constrained")
        kept, exploded, torque = figure.subplots(1, 3, sharey=True, width_ratios=(1.0, 1.0, 1.25))
        for place, each in zip(places, summaries, strict=True):
            look = looks[each.group["law"]]
            _draw_share(kept, each.kept, place, look)
            _draw_share(exploded, each.exploded, place, look)
            spread = each.peak_torque
            torque.plot([spread.median, spread.p95], [place, place], color=look["color"], linewidth=2.0, alpha=0.6)
            torque.plot(spread.median, place, linestyle="none", **look)
            torque.plot(spread.p95, place, linestyle="none", marker="|", color=look["color"], markersize=9.0)
        for scenario in scenarios:
            line = min(p for p, each in zip(places, summaries, strict=True) if each.group["scenario"] == scenario) - 1.0
            kept.text(
                0.02, line, plain_text(scenario), transform=kept.get_yaxis_transform(), va="center", weight="bold"
            )
            for axes in (kept, exploded, torque):
                axes.axhspan(line - 0.5, line + 0.5, color="black", alpha=0.06, linewidth=0.0)
        kept.set_yticks(places, [law_name(each.group["law"]) for each in summaries])
        kept.set_ylim(places[-1] + 0.7, 0.5)
        for axes, heading in ((kept, SHARES["kept"]), (exploded, f"exploded (> {THRESHOLD:g} × reference)")):
            _percent(axes.xaxis, axes.set_xlim)
            axes.set(xlabel="share of runs (%), 95 % interval")
            axes.set_title(heading)
        torque.set_xscale("log")
        torque.set(xlabel="peak torque (N m)")
        torque.set_title("median and 95th percentile")
        for axes in (kept, exploded, torque):
            axes.grid(visible=False, axis="y")
        return figure


def grid_figure(table: pa.Table, scenario: str) -> Any:
    """Draw how the shares of a scenario's runs move along each key of the study's grid, the other keys together.

    Args:
        table: The table of a study with `varying_keys`.
        scenario: Which scenario.

    Returns:
        A `matplotlib.figure.Figure` with a row a key: the shares of the runs that kept their aspect and of those that
        exploded over the values of the key, a line a law, with their 95 % intervals.
    """
    import pyarrow.compute as pc
    from matplotlib.figure import Figure

    picked = table.filter(pc.field("scenario") == scenario)
    keys = varying_keys(table)
    looks = _looks(map(str, picked["law"].to_pylist()))
    with style():
        figure: Any = Figure(figsize=(10.0, 1.0 + 2.7 * len(keys)), layout="constrained")
        rows = figure.subplots(len(keys), 2, sharey="col", squeeze=False)
        for (kept, exploded), key in zip(rows, keys, strict=True):
            summaries = study_summary(picked.filter(picked[key].is_valid()), (key, "law"))
            values = sorted({each.group[key] for each in summaries})
            laws = [law for law in looks if any(each.group["law"] == law for each in summaries)]
            # The laws stand side by side, so that no interval hides another.
            step = min(0.07, 0.7 / max(len(laws), 1))
            for index, law in enumerate(laws):
                mine = sorted((s for s in summaries if s.group["law"] == law), key=lambda each: each.group[key])
                places = [values.index(s.group[key]) + step * (index - (len(laws) - 1) / 2.0) for s in mine]
                for axes, shares in ((kept, [s.kept for s in mine]), (exploded, [s.exploded for s in mine])):
                    heights = [np.nan if share.value is None else share.value for share in shares]
                    axes.plot(places, heights, linewidth=1.0, label=law_name(law), **looks[law])
                    ends = [share.low for share in shares], [share.high for share in shares]
                    axes.vlines(places, *ends, color=looks[law]["color"], linewidth=1.4)
            for axes in (kept, exploded):
                axes.set_xticks(range(len(values)), [_value(value) for value in values])
                axes.set(xlabel=_key_name(key), xlim=(-0.5, len(values) - 0.5))
                _percent(axes.yaxis, axes.set_ylim)
            kept.set(ylabel="share of runs (%)")
        for axes, heading in zip(rows[0], SHARES.values(), strict=True):
            axes.set_title(heading)
        entries = {line.get_label(): line for axes in rows[:, 0] for line in axes.get_lines()}
        figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=3)
        figure.suptitle(plain_text(scenario))
        return figure


def _looks(laws: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return marker and colour of each law, in the order of the laws."""
    return {
        law: {
            "marker": _MARKERS[index % 7],
            "color": COLOURS[index % 7],
            "markersize": 6.0,
            # The second seven laws are hollow.
            "fillstyle": "full" if index < 7 else "none",
        }
        for index, law in enumerate(dict.fromkeys(laws))
    }


def _draw_share(axes: Any, share: Proportion, place: float, look: dict[str, Any]) -> None:
    if share.value is None:
        axes.text(0.5, place, "not known", ha="center", va="center", fontsize=9.0)
        return
    axes.plot([share.low, share.high], [place, place], color=look["color"], linewidth=2.0, alpha=0.6)
    axes.plot(share.value, place, linestyle="none", **look)


def _percent(axis: Any, set_limits: Any) -> None:
    """Let an axis show shares in per cent, none of them on its edge."""
    set_limits(-0.03, 1.03)
    axis.set_ticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "25", "50", "75", "100"])


def _key_name(key: str) -> str:
    unit = UNITS.get(key.rpartition(".")[2])
    return plain_text(key) + ("" if unit is None else f" ({unit})")


def _value(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else plain_text(str(value))
