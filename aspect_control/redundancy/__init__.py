"""The mathematics of redundancy, free of robots: arrays in, arrays out."""

from .array import Array
from .gradients import manipulability_gradient, minor_measure_gradient
from .minors import (
    MAX_MINORS,
    aspect_signature,
    border_tolerance,
    manipulability,
    minor_columns,
    minor_measure,
    minors,
    structural_minor_columns,
)
from .pseudoinverse import null_space_basis, null_space_projector, pseudoinverse
from .stability import (
    brake_torque,
    dead_beat_torque,
    homogeneous_acceleration,
    homogeneous_velocity,
    switched_torque,
)
from .torque import (
    damped_torque,
    inertia_weighted_torque,
    minimum_torque,
    operational_space_torque,
    pseudoinverse_torque,
    task_acceleration,
)

__all__ = [
    "MAX_MINORS",
    "Array",
    "aspect_signature",
    "border_tolerance",
    "brake_torque",
    "damped_torque",
    "dead_beat_torque",
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
    "operational_space_torque",
    "pseudoinverse",
    "pseudoinverse_torque",
    "structural_minor_columns",
    "switched_torque",
    "task_acceleration",
]
