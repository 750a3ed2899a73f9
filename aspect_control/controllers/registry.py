"""Control laws by name, this package's and anybody's, through the entry points `aspect_control.controllers`."""

from __future__ import annotations

from ..exceptions import ControllerLoadError, ControllerNotFoundError
from ..registry import Registry, describe_parameters, parameter_names
from .controller import Controller

__all__ = ["CONTROLLERS", "available", "create", "describe_parameters", "find", "parameter_names"]

CONTROLLERS: Registry[Controller] = Registry(
    "aspect_control.controllers", Controller, not_found=ControllerNotFoundError, load_error=ControllerLoadError
)
"""All installed laws."""

available = CONTROLLERS.available
"""Return the registry names of all installed laws, sorted; see `Registry.available`."""

find = CONTROLLERS.find
"""Return the class of a law by its registry name; see `Registry.find`."""

create = CONTROLLERS.create
"""Construct a law by its registry name, on an arm, with parameters; see `Registry.create`."""
