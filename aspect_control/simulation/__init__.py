"""The closed loop: plant, integrators, the loop itself and its recording."""

from .integrators import INTEGRATORS, Integrator, RungeKutta4, SemiImplicitEuler
from .loop import simulate
from .plant import Plant
from .run import Run
from .run_file import RunInfo

__all__ = [
    "INTEGRATORS",
    "Integrator",
    "Plant",
    "Run",
    "RunInfo",
    "RungeKutta4",
    "SemiImplicitEuler",
    "simulate",
]
