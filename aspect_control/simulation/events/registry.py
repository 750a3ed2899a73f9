"""Events by name, this package's and anybody's, through the entry points `aspect_control.events`."""

from __future__ import annotations

from ...registry import Registry, describe_parameters, parameter_names
from .event import Event

__all__ = ["EVENTS", "available", "create", "describe_parameters", "find", "parameter_names"]

EVENTS: Registry[Event] = Registry("aspect_control.events", Event)
"""All installed events."""

available = EVENTS.available
"""Return the names of all installed events, sorted; see `Registry.available`."""

find = EVENTS.find
"""Return the class of an event by its name; see `Registry.find`."""

create = EVENTS.create
"""Construct an event by its name, with parameters; see `Registry.create`."""
