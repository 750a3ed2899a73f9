"""Plants by name, this package's and anybody's, through the entry points `aspect_control.plants`."""

from __future__ import annotations

from ..registry import Registry, describe_parameters, parameter_names
from .plant import Plant

__all__ = ["PLANTS", "available", "create", "describe_parameters", "find", "parameter_names"]

PLANTS: Registry[Plant] = Registry("aspect_control.plants", Plant)
"""All installed plants."""

available = PLANTS.available
"""Return the names of all installed plants, sorted; see `Registry.available`."""

find = PLANTS.find
"""Return the class of a plant by its name; see `Registry.find`."""

create = PLANTS.create
"""Construct a plant by its name, of an arm, with parameters; see `Registry.create`."""
