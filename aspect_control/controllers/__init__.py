"""Torque laws: one a file, one abstract base, one registry."""

from .controller import Controller, TaskSpaceController
from .damped_null_space import DampedNullSpace
from .inertia_weighted import InertiaWeighted
from .jmdc import JMinorDynamicControl
from .modified_null_space_vector import ModifiedNullSpaceVector
from .null_space_vector import NullSpaceVector
from .operational_space import OperationalSpace
from .pseudoinverse import Pseudoinverse
from .qp import QPStatus, QPTorque
from .registry import available, create, describe_parameters, find, parameter_names
from .resolved_motion import ResolvedMotion

__all__ = [
    "Controller",
    "DampedNullSpace",
    "InertiaWeighted",
    "JMinorDynamicControl",
    "ModifiedNullSpaceVector",
    "NullSpaceVector",
    "OperationalSpace",
    "Pseudoinverse",
    "QPStatus",
    "QPTorque",
    "ResolvedMotion",
    "TaskSpaceController",
    "available",
    "create",
    "describe_parameters",
    "find",
    "parameter_names",
]
