"""What the page shows of a run at an instant: time, torques and the tip."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ....arm import Arm
from ....redundancy import Array
from ....simulation import Run
from ...frames import torque_limits, torque_reference
from .robot import joint_poses

CALMEST = "the calmest run's largest"
"""What torques without a limit are compared with in a replay; see `frames.torque_reference`."""


class Reading(NamedTuple):
    """One run at one instant.

    Attributes:
        t: Time, s.
        tau: Joint torques, shape (nv,), N m.
        tip: Position of the task frame, shape (3,), m.
    """

    t: float
    tau: Array
    tip: Array

    def to_dict(self) -> dict[str, Any]:
        """Return the reading for JSON, rounded to what a picture shows."""
        return {
            "t": round(self.t, 6),
            "torque": [float(f"{value:.4g}") for value in np.abs(self.tau)],
            "tip": np.round(self.tip, 5).tolist(),
        }


def torque_marks(runs: Sequence[Run]) -> list[Array]:
    """Return what each run's torques are compared with, shape (nv,), N m: see `frames.torque_limits`."""
    alike = [[other for other in runs if other.arm.description == run.arm.description] for run in runs]
    return [torque_limits(run.arm, torque_reference(group)) for run, group in zip(runs, alike, strict=True)]


def run_data(node: str, label: str, arm: Arm, marks: Array, desired: Array) -> dict[str, Any]:
    """Return what the page needs to know of a run before it moves.

    Args:
        node: Path of its node in the scene.
        label: What it is called.
        arm: The arm.
        marks: What the torques are compared with, shape (nv,), N m (N for prismatic joints).
        desired: The desired path, shape (any, 3), m.
    """
    return {
        "node": node,
        "label": label,
        "joints": list(arm.joint_names),
        "units": ["N" if prismatic else "N m" for prismatic in arm.prismatic],
        "marks": [float(f"{mark:.4g}") for mark in marks],
        "limited": (arm.torque_limit == marks).tolist(),
        "desired": np.round(desired, 5).tolist(),
        "samples": [],
        "changes": [],
        "end": None,
    }


def change_data(arm: Arm, minor: int, t: float, q: Array) -> dict[str, Any]:
    """Return a change of the aspect for the page: when, which minor, counted from 0, and where the tip is at q."""
    return {"t": round(t, 6), "minor": arm.minors.describe([minor]), "tip": np.round(arm.skeleton(q)[-1], 5).tolist()}


def reading_message(index: int, arm: Arm, q: Array, reading: Reading) -> dict[str, Any]:
    """Return a message to a live page: a reading of run `index` and where its joints are at q, shape (nq,), rad."""
    return {"run": index, **reading.to_dict(), "poses": np.round(joint_poses(arm, q[None])[0], 6).tolist()}
