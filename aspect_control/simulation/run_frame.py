"""A run as a table, one row a sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..redundancy import Array

if TYPE_CHECKING:
    import pandas as pd

    from .run import Run

_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
"""How the numbers of an encoded pose are called."""


def frame_of(run: Run) -> pd.DataFrame:
    """Return the table that `Run.to_frame` describes."""
    import pandas as pd

    arm = run.arm
    task = arm.coordinates
    value = _POSE if task.has_rotation else task.axes
    positions = np.array([arm.positions(q) for q in run.q]).reshape(len(run.t), arm.nv)
    groups: list[tuple[str, tuple[str, ...], Array]] = [
        ("q", arm.joint_names, positions),
        ("v", arm.joint_names, run.v),
        ("tau", arm.joint_names, run.tau),
        ("x", value, run.x),
        ("x_desired", value, run.x_desired),
        ("dx_desired", task.axes, run.dx_desired),
        ("ddx_desired", task.axes, run.ddx_desired),
        ("minor", tuple(str(i + 1) for i in range(run.minors.shape[1])), run.minors),
    ]
    columns: dict[str, Array] = {"t": run.t}
    for group, names, values in groups:
        columns |= {f"{group}.{name}": values[:, i] for i, name in enumerate(names)}
    columns |= {
        "tracking_error": run.tracking_error,
        "orientation_error": run.orientation_error,
        "minor_measure": run.minor_measure,
        "manipulability": run.manipulability,
        "border_distance": run.border_distance,
        "time_to_border": run.time_to_border,
        "self_motion": np.linalg.norm(run.homogeneous_velocity, axis=1),
        "self_motion_energy": run.self_motion_energy,
        "maciejewski_product": run.maciejewski_product,
    }
    return pd.DataFrame(columns)
