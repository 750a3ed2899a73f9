"""A target out of the arm's reach."""

from __future__ import annotations

from math import dist

from .event import Event, Sample


class WorkspaceLeft(Event):
    """The target is farther from the first joint than the arm can possibly reach."""

    name = "workspace-left"
    status = "tracking lost"

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None."""
        arm, coordinates = sample.arm, sample.arm.coordinates
        x = sample.target.x.translation[coordinates.position_axes] if coordinates.has_rotation else sample.target.x
        distance = dist(x.tolist(), arm.kinematics.first_joint_in_task)
        if distance <= arm.reach * (1.0 + 1e-9):
            return None
        return (
            f"the path leaves the workspace: the target is {distance:.6g} m from the first joint, "
            f"{distance - arm.reach:.3g} m beyond the reach of {arm.reach:.6g} m"
        )
