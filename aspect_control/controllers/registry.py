"""Control laws by name, this package's and anybody's, through the entry points `aspect_control.controllers`."""

from __future__ import annotations

from ..exceptions import ControllerLoadError, ControllerNotFoundError
from ..registry import Registry, describe_parameters, parameter_names
from .base import Controller

__all__ = ["ENTRY_POINT_GROUP", "available", "create", "describe_parameters", "find", "parameter_names"]

ENTRY_POINT_GROUP = "aspect_control.controllers"
"""A package adds a law by an entry point of this group: registry name = "module:Class"."""

_LAWS: Registry[Controller] = Registry(ENTRY_POINT_GROUP, "law", ControllerNotFoundError, ControllerLoadError)

available = _LAWS.available
"""Return the registry names of all installed laws, sorted; see `Registry.available`."""

find = _LAWS.find
"""Return the class of a law by its registry name; see `Registry.find`."""

create = _LAWS.create
"""Construct a law by its registry name, on an arm, with parameters; see `Registry.create`."""
