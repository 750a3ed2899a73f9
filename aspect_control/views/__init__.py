"""Figures and reports. Importing this package loads matplotlib; importing `aspect_control` does not."""

from .benchmark import benchmark_figure, benchmark_report
from .comparison import comparison_report, torque_figure
from .figures import comparison_figure, run_figure, save_figure
from .report import reproduction_report
from .style import law_name, plain_text
from .survey import survey_figure, survey_report

__all__ = [
    "benchmark_figure",
    "benchmark_report",
    "comparison_figure",
    "comparison_report",
    "law_name",
    "plain_text",
    "reproduction_report",
    "run_figure",
    "save_figure",
    "survey_figure",
    "survey_report",
    "torque_figure",
]
