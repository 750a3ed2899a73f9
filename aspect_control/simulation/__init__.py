"""The closed loop: integrators, events, the loop itself and its recording."""

from . import events, integrators
from .events import (
    DEFAULT_EVENTS,
    Diverged,
    Event,
    JointLimit,
    Sample,
    Singular,
    TorqueLimit,
    TrackingLost,
    WorkspaceLeft,
)
from .integrators import Integrator, RungeKutta4, SemiImplicitEuler
from .loop import completed, simulate
from .run import Run
from .run_file import RunInfo

__all__ = [
    "DEFAULT_EVENTS",
    "Diverged",
    "Event",
    "Integrator",
    "JointLimit",
    "Run",
    "RunInfo",
    "RungeKutta4",
    "Sample",
    "SemiImplicitEuler",
    "Singular",
    "TorqueLimit",
    "TrackingLost",
    "WorkspaceLeft",
    "completed",
    "events",
    "integrators",
    "simulate",
]
