"""Torque control of redundant arms that stays inside an aspect.

After W. J. Chung, W. K. Chung and Y. Youm, "Analysis of Dynamic Performance of Redundant Manipulators Using the
Concept of Aspects". Equation numbers in this package are the paper's.
"""

from . import aspects, controllers, redundancy, simulation
from .arm import Arm, ArmState
from .exceptions import AspectControlError
from .simulation import Run, simulate
from .trajectories import Circle, Hold, StraightLine, Target, Trajectory, Waypoints

__version__ = "0.1.0"

__all__ = [
    "Arm",
    "ArmState",
    "AspectControlError",
    "Circle",
    "Hold",
    "Run",
    "StraightLine",
    "Target",
    "Trajectory",
    "Waypoints",
    "aspects",
    "controllers",
    "redundancy",
    "simulate",
    "simulation",
]
