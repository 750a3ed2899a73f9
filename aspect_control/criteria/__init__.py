"""Performance functions H(q) that a law climbs: one a file, one abstract base, one registry."""

from .criterion import Criterion, JacobianCriterion
from .force_compatibility import ForceCompatibility
from .inverse_condition_number import InverseConditionNumber
from .joint_range import JointRange
from .manipulability import Manipulability
from .minor_measure import MinorMeasure
from .obstacles import Box, Obstacle, Sphere
from .potential import Potential
from .registry import available, create, describe_parameters, find, make, parameter_names, specification
from .velocity_compatibility import VelocityCompatibility

__all__ = [
    "Box",
    "Criterion",
    "ForceCompatibility",
    "InverseConditionNumber",
    "JacobianCriterion",
    "JointRange",
    "Manipulability",
    "MinorMeasure",
    "Obstacle",
    "Potential",
    "Sphere",
    "VelocityCompatibility",
    "available",
    "create",
    "describe_parameters",
    "find",
    "make",
    "parameter_names",
    "specification",
]
