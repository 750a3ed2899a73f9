"""What ends a run early: one event a file, one abstract base, one registry."""

from .diverged import Diverged
from .event import Event, Sample
from .joint_limit import JointLimit
from .registry import available, create, describe_parameters, find, parameter_names
from .singular import Singular
from .torque_limit import TorqueLimit
from .tracking_lost import TrackingLost
from .workspace_left import WorkspaceLeft

__all__ = [
    "DEFAULT_EVENTS",
    "Diverged",
    "Event",
    "JointLimit",
    "Sample",
    "Singular",
    "TorqueLimit",
    "TrackingLost",
    "WorkspaceLeft",
    "available",
    "create",
    "describe_parameters",
    "find",
    "parameter_names",
]

DEFAULT_EVENTS: tuple[Event, ...] = (WorkspaceLeft(), Diverged(), TrackingLost())
"""What ends a run unless told otherwise."""
