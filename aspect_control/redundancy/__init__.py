"""The mathematics of redundancy, free of robots: arrays in, arrays out."""

from .array import Array
from .criteria import (
    box_distance,
    force_compatibility,
    force_compatibility_gradient,
    inverse_condition_number,
    inverse_condition_number_gradient,
    joint_range_availability,
    joint_range_availability_gradient,
    repulsive_potential,
    sphere_distance,
    velocity_compatibility,
    velocity_compatibility_gradient,
)
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
from .pseudoinverse import null_space_basis, null_space_projector, pseudoinverse
from .stability import homogeneous_acceleration, homogeneous_velocity
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
    "box_distance",
    "dynamically_consistent_null_torque",
    "force_compatibility",
    "force_compatibility_gradient",
    "homogeneous_acceleration",
    "homogeneous_velocity",
    "inertia_weighted_torque",
    "inverse_condition_number",
    "inverse_condition_number_gradient",
    "joint_range_availability",
    "joint_range_availability_gradient",
    "manipulability",
    "manipulability_gradient",
    "minimum_torque",
    "minor_columns",
    "minor_measure",
    "minor_measure_gradient",
    "minors",
    "null_space_basis",
    "null_space_projector",
    "pseudoinverse",
    "pseudoinverse_torque",
    "repulsive_potential",
    "sphere_distance",
    "structural_minor_columns",
    "task_acceleration",
    "velocity_compatibility",
    "velocity_compatibility_gradient",
]
