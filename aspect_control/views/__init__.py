"""Figures, reports and replays. Importing this package loads matplotlib; importing `aspect_control` does not.

What needs meshcat is loaded when it is asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .figures.animation import animate
from .figures.atlas_figures import atlas_figure, stability_figure
from .figures.hypothesis_figure import hypothesis_figure
from .figures.run_figures import comparison_figure, run_figure, save_figure
from .figures.self_motion_figure import self_motion_figure
from .figures.shares_figure import shares_figure
from .figures.study_figure import grid_figure, study_figure
from .figures.survey_figure import survey_figure
from .figures.torque_figure import torque_figure
from .reports.comparison_report import comparison_report
from .reports.hypothesis_report import hypothesis_report, hypothesis_rows
from .reports.hypothesis_verdict import hypothesis_verdict
from .reports.reproduction_report import reproduction_report
from .reports.safety_report import safety_report, sequence_lines
from .reports.study_report import study_report
from .reports.survey_report import survey_report
from .style import law_name, plain_text

if TYPE_CHECKING:
    from .replays.live import LiveView
    from .replays.live_replay import LiveReplay
    from .replays.replay_page import Replay, replay

_WITH_MESHCAT = {
    "LiveReplay": "replays.live_replay",
    "LiveView": "replays.live",
    "Replay": "replays.replay_page",
    "replay": "replays.replay_page",
}

__all__ = [
    "LiveReplay",
    "LiveView",
    "Replay",
    "animate",
    "atlas_figure",
    "comparison_figure",
    "comparison_report",
    "grid_figure",
    "hypothesis_figure",
    "hypothesis_report",
    "hypothesis_rows",
    "hypothesis_verdict",
    "law_name",
    "plain_text",
    "replay",
    "reproduction_report",
    "run_figure",
    "safety_report",
    "save_figure",
    "self_motion_figure",
    "sequence_lines",
    "shares_figure",
    "stability_figure",
    "study_figure",
    "study_report",
    "survey_figure",
    "survey_report",
    "torque_figure",
]


def __getattr__(name: str) -> Any:
    if name not in _WITH_MESHCAT:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_WITH_MESHCAT[name]}", __name__), name)
