"""Torque control of redundant arms that stays inside an aspect.

After W. J. Chung, W. K. Chung and Y. Youm, "Analysis of Dynamic Performance of Redundant Manipulators Using the
Concept of Aspects". Equation numbers in this package are the paper's.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from . import aspects, controllers, criteria, redundancy, simulation
from .arm import Arm, ArmState
from .exceptions import AspectControlError
from .simulation import Run, simulate
from .trajectories import Circle, Hold, StraightLine, Target, Trajectory, Waypoints

if TYPE_CHECKING:
    from . import views

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
    "criteria",
    "redundancy",
    "simulate",
    "simulation",
    "views",
]


def __getattr__(name: str) -> Any:
    # Loaded when it is asked for, because it brings matplotlib.
    if name == "views":
        return import_module(".views", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
