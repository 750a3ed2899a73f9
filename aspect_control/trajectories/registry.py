"""Trajectories by name, this package's and anybody's, through the entry points `aspect_control.trajectories`."""

from __future__ import annotations

from ..registry import Registry, describe_parameters, parameter_names
from .trajectory import Trajectory

__all__ = ["TRAJECTORIES", "available", "create", "describe_parameters", "find", "parameter_names"]

TRAJECTORIES: Registry[Trajectory] = Registry("aspect_control.trajectories", Trajectory)
"""All installed trajectories."""

available = TRAJECTORIES.available
"""Return the names of all installed trajectories, sorted; see `Registry.available`."""

find = TRAJECTORIES.find
"""Return the class of a trajectory by its name; see `Registry.find`."""

create = TRAJECTORIES.create
"""Construct a trajectory by its name, with parameters; see `Registry.create`."""
