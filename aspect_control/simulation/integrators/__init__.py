"""How a plant is moved on by one sample: one integrator a file, one abstract base, one registry."""

from .integrator import Integrator
from .registry import available, create, describe_parameters, find, parameter_names
from .runge_kutta_4 import RungeKutta4
from .semi_implicit_euler import SemiImplicitEuler

__all__ = [
    "Integrator",
    "RungeKutta4",
    "SemiImplicitEuler",
    "available",
    "create",
    "describe_parameters",
    "find",
    "parameter_names",
]
