"""An arm, from a URDF or a Pinocchio model, and the minors of its task."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from ..exceptions import ModelError, TooManyMinorsError
from ..redundancy import MAX_MINORS, Array, minors, structural_minor_columns
from .arm_state import ArmState
from .chain import joints_to_lock, reduce_model
from .description import ArmDescription
from .inertia import require_possible_bodies
from .sources.pinocchio_model import record_chain
from .sources.urdf import mimic_joints, parse_urdf, read_urdf
from .task_chain import TaskChain
from .tasks import Task

__all__ = ["BORDER_TOLERANCE", "Arm", "ArmState"]

BORDER_TOLERANCE = 1e-6
"""Part of its own scale up to which a minor counts as zero at the start of a motion."""

_SAMPLED_POSTURES = 32
"""Random postures in which a minor must vanish to count as structurally zero."""


class Arm(TaskChain):
    """A chain of joints on Pinocchio and the task coordinates of one of its frames.

    An arm computes in buffers of its own and must not be shared between threads.

    Attributes:
        model: The (reduced) `pin.Model` that q and v belong to.
        description: What the arm was made from, enough to make it again.
        name: The robot's name.
        frame: Name of the task frame.
        task: The task coordinates, such as `("x", "y")`.
        coordinates: The same as a `Task`, which compares and displaces task values.
        nq: Number of configuration coordinates.
        nv: Number of joint velocities, n in the paper.
        task_dim: Number of task coordinates, m in the paper.
        redundancy: n − m.
    """

    def __init__(self, description: ArmDescription, model: Any, passive: Sequence[str] = ()) -> None:
        """Reduce a model to the chain that moves the task frame; `from_urdf` and its siblings are the usual way in.

        Args:
            description: What the arm is made from; its frame, task, gravity and locked joints are used here.
            model: The whole robot, a `pin.Model`.
            passive: Names of joints that no motor of their own drives.

        Raises:
            FrameNotFoundError: If the model has no such frame.
            JointNotFoundError: If a locked joint does not exist.
            ParameterError: If a locked joint's position is not possible.
            ModelError: If no joint moves the frame, a joint moves no mass, or a mass or an inertia is impossible.
        """
        locked, q = joints_to_lock(model, description.frame, description.locked, passive)
        reduced = reduce_model(model, locked, q)
        require_possible_bodies(reduced, range(1, reduced.njoints))
        reduced.gravity.linear = np.array(description.gravity)
        super().__init__(reduced, description.frame, Task(description.task))
        self.description = description

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str],
        *,
        frame: str,
        task: str | Sequence[str],
        gravity: ArrayLike | None = None,
        locked: Mapping[str, float] | None = None,
        package_dirs: Sequence[str | os.PathLike[str]] | None = None,
    ) -> Arm:
        """Load an arm from a URDF file of any robot.

        The arm is the chain of joints from the root to the frame. All other joints, mimic joints and joints of several
        degrees of freedom are locked at their neutral position; fingers, mobile bases and second arms need no further
        attention.

        Args:
            path: The URDF file.
            frame: Name of the frame whose motion is the task: any link, joint or frame of the URDF.
            task: `"xy"`, `"xz"`, `"yz"`, `"xyz"`, `"pose"`, or a sequence of distinct coordinates from `("x", "y", "z",
                "rx", "ry", "rz")`, in the world frame.
            gravity: Gravitational acceleration in the world frame, shape (3,), m/s²; None for (0, 0, −9.81).
            locked: Positions of joints to lock, rad or m, by name; they may belong to the chain.
            package_dirs: Folders in which `package://` meshes are found; needed only by `visuals.visual_geometry`.

        Raises:
            ModelError: If the file is missing, is no URDF, or has no joint that moves the frame.
            FrameNotFoundError: If there is no such frame; the message lists those that exist.
            JointNotFoundError: If `locked` names a joint that does not exist.
            ParameterError: If a locked position is not finite or outside the joint's limits.
            TaskError: If `task` is unknown.
            ShapeError: If `gravity` has not three entries.
            NonFiniteError: If `gravity` is not finite.
        """
        return cls.from_urdf_text(
            read_urdf(path),
            frame=frame,
            task=task,
            gravity=gravity,
            locked=locked,
            package_dirs=package_dirs,
            source=str(path),
        )

    @classmethod
    def from_urdf_text(
        cls,
        text: str,
        *,
        frame: str,
        task: str | Sequence[str],
        gravity: ArrayLike | None = None,
        locked: Mapping[str, float] | None = None,
        package_dirs: Sequence[str | os.PathLike[str]] | None = None,
        source: str = "the given text",
    ) -> Arm:
        """Load an arm from the text of a URDF.

        Args:
            text: The URDF.
            frame: As for `from_urdf`.
            task: As for `from_urdf`.
            gravity: As for `from_urdf`.
            locked: As for `from_urdf`.
            package_dirs: As for `from_urdf`.
            source: What the text is called in errors.

        Raises:
            AspectControlError: As for `from_urdf`.
        """
        model = parse_urdf(text, source)
        description = ArmDescription.of(
            model, frame=frame, task=task, gravity=gravity, locked=locked, urdf=text, package_dirs=package_dirs
        )
        return cls(description, model, mimic_joints(text))

    @classmethod
    def from_example(
        cls,
        name: str,
        *,
        frame: str,
        task: str | Sequence[str],
        gravity: ArrayLike | None = None,
        locked: Mapping[str, float] | None = None,
    ) -> Arm:
        """Load an arm of one of the robots that `example-robot-data` ships, or of `"planar3r"`.

        Args:
            name: Name of the robot; `aspect-control robots` lists them with the frames that end a chain.
            frame: As for `from_urdf`.
            task: As for `from_urdf`.
            gravity: As for `from_urdf`.
            locked: As for `from_urdf`.

        Raises:
            UnknownNameError: If there is no such robot.
            AspectControlError: As for `from_urdf`.
        """
        from .sources.examples import find_example, load_example_model

        robot = find_example(name)
        if robot.path.suffix == ".sdf":
            model = load_example_model(name)
            return cls.from_pinocchio(model, frame=frame, task=task, gravity=gravity, locked=locked)
        return cls.from_urdf(
            robot.path, frame=frame, task=task, gravity=gravity, locked=locked, package_dirs=robot.package_dirs
        )

    @classmethod
    def from_pinocchio(
        cls,
        model: Any,
        *,
        frame: str,
        task: str | Sequence[str],
        gravity: ArrayLike | None = None,
        locked: Mapping[str, float] | None = None,
    ) -> Arm:
        """Make an arm of a `pin.Model`, which is copied.

        Args:
            model: The whole robot.
            frame: As for `from_urdf`.
            task: As for `from_urdf`.
            gravity: As for `from_urdf`, but None keeps the model's own.
            locked: As for `from_urdf`.

        Raises:
            ModelError: If `model` is no `pin.Model`, or has a joint that is neither revolute nor prismatic.
            AspectControlError: As for `from_urdf`.
        """
        if not isinstance(model, pin.Model):
            raise ModelError(f"from_pinocchio takes a pin.Model, got {type(model).__name__}")
        arm = cls(ArmDescription.of(model, frame=frame, task=task, gravity=gravity, locked=locked), model.copy())
        chain = record_chain(arm.model, arm._frame_id)
        # Made again from what is recorded, so that the arm of a loaded run is the same to the last bit.
        return cls.from_description(replace(arm.description, locked={}, chain=chain))

    @classmethod
    def from_description(cls, description: ArmDescription) -> Arm:
        """Make an arm again from its description.

        Raises:
            AspectControlError: As for `from_urdf`.
        """
        return cls(description, description.model(), mimic_joints(description.urdf) if description.urdf else ())

    @property
    def gravity(self) -> Array:
        """Gravitational acceleration in the world frame, shape (3,), m/s²."""
        return np.array(self.model.gravity.linear)

    @property
    def minor_columns(self) -> NDArray[np.intp]:
        """Columns of the minors that are not structurally zero, shape (p, m).

        A minor is structurally zero if it vanishes in every posture, as one does that uses a joint which cannot move
        the task at all. Such minors say nothing about the aspect.

        Raises:
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        return self._sampled_minors[0]

    @property
    def minor_scales(self) -> Array:
        """Largest magnitude of each minor of `minor_columns` in a sample of random postures, shape (p,).

        Raises:
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        return self._sampled_minors[1]

    @cached_property
    def _sampled_minors(self) -> tuple[NDArray[np.intp], Array]:
        if math.comb(self.nv, self.task_dim) > MAX_MINORS:
            raise TooManyMinorsError(
                f"a task of {self.task_dim} coordinates on {self.nv} joints has "
                f"{math.comb(self.nv, self.task_dim):,} minors; at most {MAX_MINORS:,} are computed, for each is a "
                f"determinant at every sample: lock joints or take a task of fewer coordinates"
            )
        postures = np.random.default_rng(0).uniform(-np.pi, np.pi, (_SAMPLED_POSTURES, self.nv))
        jacobians = np.array([self.jacobian(self.configuration(positions)) for positions in postures])
        columns = structural_minor_columns(jacobians)
        return columns, np.abs(minors(jacobians, columns)).max(axis=0)

    @cached_property
    def first_joint(self) -> Array:
        """Where the first joint is, shape (3,), m, world frame."""
        return np.array(self.model.jointPlacements[1].translation)

    @cached_property
    def first_joint_in_task(self) -> list[float]:
        """The same in the position coordinates of the task, m."""
        return [float(self.first_joint[axis]) for axis in self.coordinates.position_axes]

    @cached_property
    def reach(self) -> float:
        """Upper bound of the distance between the first joint and the task frame, m.

        The distances between neighbouring joints added up, with the travel of prismatic joints; infinite for a
        prismatic joint without limits. The workspace may be smaller.
        """
        lower, upper = self.position_limits
        travel = np.maximum(np.abs(lower), np.abs(upper))[self.prismatic].sum()
        steps = np.diff(self.skeleton(pin.neutral(self.model)), axis=0)
        return float(np.linalg.norm(steps, axis=1).sum() + travel)

    def minors_on_border(self, q: ArrayLike) -> NDArray[np.intp]:
        """Return which minors of `minor_columns` are zero at q for practical purposes, as indices, shape (any,).

        Zero is `BORDER_TOLERANCE` times the minor's own scale, or less: at the start of a motion such a minor has no
        sign to keep.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        values = minors(self.jacobian(q), self.minor_columns)
        return np.flatnonzero(np.abs(values) <= BORDER_TOLERANCE * self.minor_scales)

    def describe_minors(self, indices: Sequence[int] | NDArray[np.intp]) -> str:
        """Name minors of `minor_columns` by their number, counted from 1, and by their joints."""
        columns = [[self.joint_names[column] for column in sorted(self.minor_columns[i])] for i in indices]
        return "; ".join(f"{i + 1} ({', '.join(names)})" for i, names in zip(indices, columns, strict=True))

    def __reduce__(self) -> tuple[Any, tuple[ArmDescription]]:
        """Pickle and copy an arm as its description, which makes the same arm to the last bit."""
        return type(self).from_description, (self.description,)

    def __repr__(self) -> str:
        """Name the arm, its task and its size."""
        return f"Arm({self.name!r}, frame={self.frame!r}, task={self.task}, nv={self.nv}, task_dim={self.task_dim})"
