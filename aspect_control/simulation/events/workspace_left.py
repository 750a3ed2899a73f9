"""A target out of the arm's reach."""

from __future__ import annotations

from ...arm import Arm
from ...guard import Reach, check_reach, out_of_reach
from ...redundancy import Array
from ...trajectories import Trajectory
from .event import Event, Sample


class WorkspaceLeft(Event):
    """The target is where no posture of the arm can take the task frame, whatever the joint limits.

    The whole path is looked at once before the motion, by `guard.check_reach`.
    """

    name = "workspace-left"
    status = "workspace left"

    def begin(self, arm: Arm, trajectory: Trajectory, q0: Array) -> Event:
        """Return the event that ends a run of this motion where its path leaves the workspace."""
        return _PathLeaves(check_reach(arm, trajectory, q0, joint_limits=False))

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None, from the target of this sample alone."""
        return out_of_reach(sample.arm, sample.target.x, sample.q, joint_limits=False)


class _PathLeaves(WorkspaceLeft):
    """A path that has been looked at leaves the workspace."""

    def __init__(self, reach: Reach) -> None:
        self._reach = reach

    def check(self, sample: Sample) -> str | None:
        reach = self._reach
        return None if reach.t is None or sample.t <= reach.t else reach.message
