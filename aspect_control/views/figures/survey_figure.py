"""The survey as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...studies.survey import SurveyRow
from ..style import COLOURS, law_name, style


def survey_figure(rows: Sequence[SurveyRow]) -> Any:
    """Draw the ratio of each law's peak torque to the pseudoinverse law's, for each scenario.

    Returns:
        A `matplotlib.figure.Figure`; runs that did not finish are drawn hollow.
    """
    from matplotlib.figure import Figure

    scenarios = list(dict.fromkeys(row.scenario for row in rows))
    laws = list(dict.fromkeys(row.controller for row in rows))
    markers = "os^Dv*P"
    with style():
        figure: Any = Figure(figsize=(10.0, 1.6 + 0.42 * len(scenarios)), layout="constrained")
        axes = figure.subplots()
        for index, law in enumerate(laws):
            picked = [row for row in rows if row.controller == law and row.peak_ratio is not None]
            heights = np.array([scenarios.index(row.scenario) for row in picked]) + 0.16 * (index - (len(laws) - 1) / 2)
            for finished in (True, False):
                points = [
                    (row.peak_ratio, height)
                    for row, height in zip(picked, heights, strict=True)
                    if (row.status == "finished") == finished
                ]
                axes.plot(
                    [ratio for ratio, _ in points],
                    [height for _, height in points],
                    linestyle="none",
                    marker=markers[index % 7],
                    color=COLOURS[index % 7],
                    fillstyle="full" if finished else "none",
                    label=law_name(law) if finished else "_",
                )
        axes.plot([], [], "ko", fillstyle="none", label="ended early")
        axes.set_xscale("log")
        axes.set_yticks(range(len(scenarios)), scenarios)
        axes.set_ylim(len(scenarios) - 0.5, -0.5)
        axes.set(xlabel="peak torque over that of the pseudoinverse law")
        axes.axvline(1.0, color="black", linewidth=0.8)
        figure.legend(loc="outside upper center", ncols=3)
        return figure
