"""Integrators by name, this package's and anybody's, through the entry points `aspect_control.integrators`."""

from __future__ import annotations

from ...registry import Registry, describe_parameters, parameter_names
from .integrator import Integrator

__all__ = ["INTEGRATORS", "available", "create", "describe_parameters", "find", "parameter_names"]

INTEGRATORS: Registry[Integrator] = Registry("aspect_control.integrators", Integrator)
"""All installed integrators."""

available = INTEGRATORS.available
"""Return the names of all installed integrators, sorted; see `Registry.available`."""

find = INTEGRATORS.find
"""Return the class of an integrator by its name; see `Registry.find`."""

create = INTEGRATORS.create
"""Construct an integrator by its name, with parameters; see `Registry.create`."""
