"""Where the task coordinates are to be, and how fast, at any time: one trajectory a file, one abstract base."""

from .circle import Circle
from .hold import Hold
from .path import PathTrajectory
from .profiles import PROFILES, Profile
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
]
