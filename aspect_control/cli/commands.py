"""All commands of the application."""

# In the order of the help.
from . import motion_commands, survey_commands, comparison_commands, posture_commands, listing_commands  # isort: skip  # noqa: F401
from .application import app, run

__all__ = ["app", "run"]
