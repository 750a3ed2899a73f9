"""Figures, reports and replays. Importing this package loads matplotlib; importing `aspect_control` does not.

What needs meshcat is loaded when it is asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .animation import animate
from .atlas import atlas_figure, stability_figure
from .benchmark import benchmark_figure, benchmark_report
from .comparison import comparison_report, torque_figure
from .figures import comparison_figure, run_figure, save_figure
from .hypothesis import hypothesis_report, hypothesis_rows, hypothesis_verdict
from .hypothesis_figure import hypothesis_figure
from .report import reproduction_report
from .self_motion import self_motion_figure
from .style import law_name, plain_text
from .survey import survey_figure, survey_report

if TYPE_CHECKING:
    from .live import LiveView
    from .live_replay import LiveReplay
    from .replay_page import Replay, replay

_WITH_MESHCAT = {
    "LiveReplay": "live_replay",
    "LiveView": "live",
    "Replay": "replay_page",
    "replay": "replay_page",
}

__all__ = [
    "LiveReplay",
    "LiveView",
    "Replay",
    "animate",
    "atlas_figure",
    "benchmark_figure",
    "benchmark_report",
    "comparison_figure",
    "comparison_report",
    "hypothesis_figure",
    "hypothesis_report",
    "hypothesis_rows",
    "hypothesis_verdict",
    "law_name",
    "plain_text",
    "replay",
    "reproduction_report",
    "run_figure",
    "save_figure",
    "self_motion_figure",
    "stability_figure",
    "survey_figure",
    "survey_report",
    "torque_figure",
]


def __getattr__(name: str) -> Any:
    if name not in _WITH_MESHCAT:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_WITH_MESHCAT[name]}", __name__), name)
