"""A scenario ready to run: everything that its file describes, built once."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arm import Arm
from ..checks import finite_vector
from ..controllers import Controller
from ..exceptions import WorkspaceWarning
from ..guard import Reach, check_reach
from ..plants import Plant
from ..redundancy import Array
from ..simulation import Event, Integrator, Run, Sample, completed, simulate
from ..trajectories import Trajectory
from .sections import RobotSection, StartSection


@dataclass(frozen=True, eq=False)
class Setup:
    """What `Scenario.build` makes of a scenario file, and how it is run.

    The laws share the arm; each is reset when its run begins. Plant, integrator and events serve every run and must
    carry nothing from one to the next.

    Attributes:
        arm: The arm.
        q0: Joint configuration at the start, shape (nq,), rad; read-only.
        v0: Joint velocity at the start, shape (nv,), rad/s; read-only.
        trajectory: What the task is to do.
        laws: The laws by their labels, in the order of the file.
        events: What ends a run early.
        plant: What moves under the torque.
        dt: Sampling time, s.
        integrator: How the plant's motion is integrated.
        saturation: Largest |τ| of each joint, shape (nv,), N m; None for motors without limits.
        description: What the scenario shows, in a sentence.
    """

    arm: Arm
    q0: Array
    v0: Array
    trajectory: Trajectory
    laws: Mapping[str, Controller]
    events: tuple[Event, ...]
    plant: Plant
    dt: float
    integrator: Integrator
    saturation: Array | None = None
    description: str = ""

    def reach(self) -> Reach:
        """Return whether the arm can reach all of the path inside its joint limits, and if not, where it leaves.

        Raises:
            AspectControlError: As `check_reach` does.
        """
        return check_reach(self.arm, self.trajectory, self.q0)

    def run(self, progress: Callable[[str, float], None] | None = None) -> dict[str, Run]:
        """Run every law and return the runs by their labels.

        Args:
            progress: Called with the label of the law and the part of all work that is done, 0 to 1.

        Raises:
            AspectControlError: As `simulate` does.
        """
        runs: dict[str, Run] = {}
        self.run_each(runs.__setitem__, progress)
        return runs

    def run_each(
        self,
        keep: Callable[[str, Run], None],
        progress: Callable[[str, float], None] | None = None,
        before: Callable[[str, Controller], None] | None = None,
        watch: Callable[[str], Callable[[Sample], None]] | None = None,
    ) -> None:
        """Run every law and hand each run over as soon as it is there; first say where the path leaves the workspace.

        That is a `WorkspaceWarning`; a run ends there only if no posture at all reaches farther, see `WorkspaceLeft`.
        One that Ctrl-C or an exception in `watch` or `progress` interrupts is handed over too, and is the last.

        Args:
            keep: Called with label and run.
            progress: As for `run`.
            before: Called with the label and the law before each run.
            watch: Called with each label; what it returns is called with every sample of that law, see `simulate`.

        Raises:
            AspectControlError: As `simulate` does.
            BaseException: What interrupted the last run: `run.error`.
        """
        reach = self.reach()
        if not reach.reachable:
            warnings.warn(reach.message, WorkspaceWarning, stacklevel=2)
        for i, (label, law) in enumerate(self.laws.items()):
            if before is not None:
                before(label, law)
            run = simulate(
                law,
                self.trajectory,
                q0=self.q0,
                v0=self.v0,
                dt=self.dt,
                plant=self.plant,
                integrator=self.integrator,
                saturation=self.saturation,
                events=self.events,
                progress=_share(progress, label, i, len(self.laws)),
                watch=None if watch is None else watch(label),
            )
            keep(label, run)
            completed(run)


def build_arm(robot: RobotSection, folder: Path) -> Arm:
    """Return the arm that `[robot]` describes.

    Args:
        robot: The section.
        folder: What its paths are relative to.

    Raises:
        AspectControlError: As `Arm.from_urdf` does.
    """
    if robot.example is not None:
        return Arm.from_example(
            robot.example, frame=robot.frame, task=robot.task, gravity=robot.gravity, locked=robot.locked
        )
    return Arm.from_urdf(
        folder / str(robot.urdf),
        frame=robot.frame,
        task=robot.task,
        gravity=robot.gravity,
        locked=robot.locked,
        package_dirs=[folder / each for each in robot.package_dirs],
    )


def start_configuration(start: StartSection, arm: Arm) -> Array:
    """Return the configuration at t = 0, shape (nq,), rad; read-only.

    Raises:
        ShapeError: If there is not one position a joint.
        ParameterError: If a joint is outside its limits.
    """
    if start.degrees is not None:
        degrees = finite_vector("start.degrees", start.degrees, arm.nv)
        positions = np.where(arm.prismatic, degrees, np.deg2rad(degrees))
    else:
        positions = finite_vector("start.positions", start.positions or [], arm.nv)
    q = arm.configuration(positions)
    arm.require_within_limits(q)
    q.setflags(write=False)
    return q


def start_velocity(start: StartSection, arm: Arm) -> Array:
    """Return the joint velocity at t = 0, shape (nv,), rad/s; read-only.

    Raises:
        ShapeError: If there is not one velocity a joint.
    """
    return finite_vector("start.velocities", np.zeros(arm.nv) if start.velocities is None else start.velocities, arm.nv)


def _share(
    progress: Callable[[str, float], None] | None, label: str, index: int, count: int
) -> Callable[[float], None] | None:
    return None if progress is None else lambda part: progress(label, (index + part) / count)
