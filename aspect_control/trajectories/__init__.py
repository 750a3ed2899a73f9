"""Where the task coordinates are to be, and how fast, at any time: one trajectory a file, one base, one registry."""

from .circle import Circle
from .hold import Hold
from .path import PathTrajectory
from .profiles import PROFILES, Profile
from .registry import available, create, describe_parameters, find, parameter_names
from .straight_line import StraightLine
from .target import Target
from .trajectory import Trajectory
from .waypoints import Waypoints

__all__ = [
    "PROFILES",
    "Circle",
    "Hold",
    "PathTrajectory",
    "Profile",
    "StraightLine",
    "Target",
    "Trajectory",
    "Waypoints",
    "available",
    "create",
    "describe_parameters",
    "find",
    "parameter_names",
]
