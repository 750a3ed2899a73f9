"""The figure of several arms, or of one under several settings: shares of exploded runs with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...studies.hypothesis import THRESHOLD
from ..reports.hypothesis_tables import Condition, label, laws_of, table_of
from ..style import COLOURS, plain_text, style
from .hypothesis_figure import law_label

_SHARES = (
    ("exploded_if_kept", "aspect kept", COLOURS[0], "o", -0.13),
    ("exploded_if_left", "left", COLOURS[1], "s", 0.13),
)


def shares_figure(conditions: Sequence[Condition]) -> Any:
    """Draw the share of exploded runs among those that kept and those that left their aspect, with its interval.

    Args:
        conditions: The rows of the figure, as in `studies.hypothesis.evidence`; each law has a panel.

    Returns:
        A `matplotlib.figure.Figure`.
    """
    from matplotlib.figure import Figure

    laws = laws_of(conditions)
    with style():
        size = (2.2 + 2.3 * max(len(laws), 2), 1.9 + 0.42 * len(conditions))
        figure: Any = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(1, len(laws), sharex=True, sharey=True, squeeze=False)[0]
        for axes, law in zip(panels, laws, strict=True):
            for name, words, colour, marker, offset in _SHARES:
                found = [
                    (place + offset, table_of(each, law)[name])
                    for place, each in enumerate(conditions)
                    if law in each["laws"]
                ]
                known = [(height, each) for height, each in found if each["value"] is not None]
                axes.errorbar(
                    [each["value"] for _, each in known],
                    [height for height, _ in known],
                    xerr=[
                        [max(0.0, each["value"] - each["low"]) for _, each in known],
                        [max(0.0, each["high"] - each["value"]) for _, each in known],
                    ],
                    linestyle="none",
                    marker=marker,
                    markersize=4.5,
                    color=colour,
                    label=words,
                )
            axes.set_title(law_label(law), fontsize=10.0)
        panels[0].set_yticks(range(len(conditions)), [plain_text(label(each)) for each in conditions])
        panels[0].set(xlim=(-0.03, 1.03), ylim=(len(conditions) - 0.5, -0.5))
        figure.supxlabel(
            f"share of exploded runs (beyond {THRESHOLD:g} times the reference), 95 % interval", fontsize=11.0
        )
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
        return figure
