"""Figures and reports. Importing this package loads matplotlib; importing `aspect_control` does not."""

from .figures import comparison_figure, run_figure, save_figure
from .report import reproduction_report

__all__ = ["comparison_figure", "reproduction_report", "run_figure", "save_figure"]
