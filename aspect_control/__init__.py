"""Torque control of redundant arms that stays inside an aspect.

After W. J. Chung, W. K. Chung and Y. Youm, "Analysis of Dynamic Performance of Redundant Manipulators Using the
Concept of Aspects". Equation numbers in this package are the paper's.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import (
        aspects,
        controllers,
        criteria,
        guard,
        plants,
        realtime,
        redundancy,
        simulation,
        studies,
        trajectories,
        views,
    )
    from .arm import Arm, ArmState
    from .exceptions import AspectControlError
    from .guard import Blend, Guard, check_reach
    from .realtime import RealTimeLoop
    from .simulation import Run, simulate
    from .studies.study import Study
    from .trajectories import Circle, Hold, StraightLine, Target, Trajectory, Waypoints

__version__ = "0.1.0"

__all__ = [
    "Arm",
    "ArmState",
    "AspectControlError",
    "Blend",
    "Circle",
    "Guard",
    "Hold",
    "RealTimeLoop",
    "Run",
    "StraightLine",
    "Study",
    "Target",
    "Trajectory",
    "Waypoints",
    "aspects",
    "check_reach",
    "controllers",
    "criteria",
    "guard",
    "plants",
    "realtime",
    "redundancy",
    "simulate",
    "simulation",
    "studies",
    "trajectories",
    "views",
]


_HOMES = {
    **dict.fromkeys(("Arm", "ArmState"), "arm"),
    "AspectControlError": "exceptions",
    **dict.fromkeys(("Blend", "Guard", "check_reach"), "guard"),
    "RealTimeLoop": "realtime",
    **dict.fromkeys(("Run", "simulate"), "simulation"),
    "Study": "studies.study",
    **dict.fromkeys(("Circle", "Hold", "StraightLine", "Target", "Trajectory", "Waypoints"), "trajectories"),
}
"""The module of each name that is not a module itself."""


def __getattr__(name: str) -> Any:
    # Loaded when it is asked for: the views bring matplotlib, and the command line answers Ctrl-C from the beginning.
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    module = f"{__name__}.{name}"
    if not name.startswith("_"):
        try:
            return import_module(module)
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
