"""All commands of the application."""

from . import motions, comparisons, postures, listings  # isort: skip  # noqa: F401  the order is that of the help
from .application import app, run

__all__ = ["app", "run"]
