"""All commands of the application."""

# In the order of the help.
from . import motion_commands, hypothesis_command, survey_commands  # isort: skip  # noqa: F401
from . import study_commands, study_report_command, study_page_command, posture_commands  # isort: skip  # noqa: F401
from . import safety_commands, listing_commands  # isort: skip  # noqa: F401
from .application import app, run

__all__ = ["app", "run"]
