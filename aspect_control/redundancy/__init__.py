"""The mathematics of redundancy, free of robots: arrays in, arrays out."""

from .array import Array
from .minors import (
    MAX_MINORS,
    aspect_signature,
    border_tolerance,
    manipulability,
    manipulability_gradient,
    minor_columns,
    minor_measure,
    minor_measure_gradient,
    minors,
    structural_minor_columns,
)
from .null_vector import null_vector
from .pseudoinverse import null_space_basis, null_space_projector, pseudoinverse
from .stability import (
    homogeneous_acceleration,
    homogeneous_velocity,
    null_vector_derivative,
    stability_coefficient,
)
from .torque import (
    dynamically_consistent_null_torque,
    inertia_weighted_torque,
    minimum_torque,
    pseudoinverse_torque,
    task_acceleration,
)

__all__ = [
    "MAX_MINORS",
    "Array",
    "aspect_signature",
    "border_tolerance",
    "dynamically_consistent_null_torque",
    "homogeneous_acceleration",
    "homogeneous_velocity",
    "inertia_weighted_torque",
    "manipulability",
    "manipulability_gradient",
    "minimum_torque",
    "minor_columns",
    "minor_measure",
    "minor_measure_gradient",
    "minors",
    "null_space_basis",
    "null_space_projector",
    "null_vector",
    "null_vector_derivative",
    "pseudoinverse",
    "pseudoinverse_torque",
    "stability_coefficient",
    "structural_minor_columns",
    "task_acceleration",
]
