"""Torque laws: one a file, one abstract base, one registry."""

from .base import Controller, TaskSpaceController
from .jmdc import JMinorDynamicControl
from .modified_null_space_vector import ModifiedNullSpaceVector
from .null_space_vector import NullSpaceVector
from .pseudoinverse import Pseudoinverse
from .registry import available, create, describe_parameters, find, parameter_names

__all__ = [
    "Controller",
    "JMinorDynamicControl",
    "ModifiedNullSpaceVector",
    "NullSpaceVector",
    "Pseudoinverse",
    "TaskSpaceController",
    "available",
    "create",
    "describe_parameters",
    "find",
    "parameter_names",
]
