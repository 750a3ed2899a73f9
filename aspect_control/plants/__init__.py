"""What an arm does under a torque: one plant a file, one abstract base, one registry."""

from .plant import Plant
from .registry import available, create, describe_parameters, find, parameter_names
from .rigid_body import RigidBodyPlant

__all__ = [
    "Plant",
    "RigidBodyPlant",
    "available",
    "create",
    "describe_parameters",
    "find",
    "parameter_names",
]
