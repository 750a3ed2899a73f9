"""The command line: parse, call, print. Each module holds the commands about one thing."""

from . import motions, comparisons, postures, cost, listings  # isort: skip  # noqa: F401  the order is that of the help
from .application import app, main

__all__ = ["app", "main"]
