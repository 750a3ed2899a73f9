"""An arm: joint coordinates, the kinematics of a frame and its task, made of a URDF or a Pinocchio model."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from ..exceptions import ModelError
from ..redundancy import Array
from .arm_state import ArmState
from .chain import joints_to_lock, reduce_model
from .description import ArmDescription, LockedJoints
from .inertia import require_possible_bodies
from .joint_coordinates import JointCoordinates
from .kinematics import Kinematics
from .sources.pinocchio_model import record_chain
from .sources.urdf import mimic_joints, parse_urdf, read_urdf
from .task_minors import TaskMinors
from .tasks import Task, TaskChoice, TaskValue


class Arm:
    """A chain of joints on Pinocchio and the task coordinates of one of its frames.

    An arm is composed of joints, kinematics, minors and a task, which describe in full what it hands on. It computes
    in buffers of its own and must not be shared between threads.

    Attributes:
        model: The (reduced) `pin.Model` that q and v belong to.
        description: What the arm was made from, enough to make it again.
        joints: Its joint coordinates: names, limits, and how configurations are added.
        kinematics: What is computed of it at (q, v): states, Jacobians, positions.
        minors: The minors of its task that are not structurally zero.
        coordinates: Its task, which compares and displaces task values.
        name: The robot's name.
        frame: Name of the task frame.
        task: The task coordinates, such as `("x", "y")`.
        nq: Number of configuration coordinates.
        nv: Number of joint velocities, n in the paper.
        task_dim: Number of task coordinates, m in the paper.
        redundancy: n − m.
        joint_names: Names of the joints, from the base.
        prismatic: Which joints slide, shape (nv,).
        position_limits: Lower and upper limits of the positions, shapes (nv,), rad; infinite where there are none.
        velocity_limit: Largest |θ̇| of each joint, shape (nv,), rad/s; infinite where there is none.
        torque_limit: Largest |τ| of each joint, shape (nv,), N m; infinite where there is none.
    """

    def __init__(self, description: ArmDescription, model: Any, passive: Sequence[str] = ()) -> None:
        """Reduce a model to the chain that moves the task frame; `from_urdf` and its siblings are the usual way in.

        Args:
            description: What the arm is made from; its frame, task, gravity and locked joints are used here.
            model: The whole robot, a `pin.Model`.
            passive: Names of joints that no motor of their own drives.

        Raises:
            AspectControlError: As for `from_urdf`.
        """
        locked, q = joints_to_lock(model, description.frame, description.locked, passive)
        reduced = reduce_model(model, locked, q)
        require_possible_bodies(reduced, range(1, reduced.njoints))
        reduced.gravity.linear = np.array(description.gravity)
        self.description = description
        self.model = reduced
        self.name: str = reduced.name
        self.frame = description.frame
        self.coordinates = Task(description.task)
        self.joints = joints = JointCoordinates(reduced)
        self.kinematics = Kinematics(joints, self.frame, self.coordinates)
        self.minors = TaskMinors(joints, self.kinematics, self.coordinates.dim)
        self.task = self.coordinates.axes
        self.nq, self.nv, self.task_dim = joints.nq, joints.nv, self.coordinates.dim
        self.redundancy = joints.nv - self.task_dim
        self.joint_names, self.prismatic = joints.joint_names, joints.prismatic
        self.position_limits, self.velocity_limit = joints.position_limits, joints.velocity_limit
        self.torque_limit = joints.torque_limit

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str],
        *,
        frame: str,
        task: TaskChoice,
        gravity: ArrayLike | None = None,
        locked: LockedJoints = None,
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
        text = read_urdf(path)
        return cls.from_urdf_text(
            text, frame=frame, task=task, gravity=gravity, locked=locked, package_dirs=package_dirs, source=str(path)
        )

    @classmethod
    def from_urdf_text(
        cls,
        text: str,
        *,
        frame: str,
        task: TaskChoice,
        gravity: ArrayLike | None = None,
        locked: LockedJoints = None,
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
        cls, name: str, *, frame: str, task: TaskChoice, gravity: ArrayLike | None = None, locked: LockedJoints = None
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
        cls, model: Any, *, frame: str, task: TaskChoice, gravity: ArrayLike | None = None, locked: LockedJoints = None
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
        description = ArmDescription.of(model, frame=frame, task=task, gravity=gravity, locked=locked)
        # Made again from what is recorded, so that the arm of a loaded run is the same to the last bit.
        chain = record_chain(cls(description, model.copy()).model, frame)
        return cls.from_description(replace(description, locked={}, chain=chain))

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
    def reach(self) -> float:
        """Upper bound of the distance between the first joint and the task frame, m."""
        return self.kinematics.reach

    @property
    def minor_columns(self) -> NDArray[np.intp]:
        """Columns of the minors that are not structurally zero, shape (p, m); see `TaskMinors.columns`."""
        return self.minors.columns

    @property
    def minor_scales(self) -> Array:
        """Largest magnitude of each of these minors in a sample of postures, shape (p,)."""
        return self.minors.scales

    def configuration(self, positions: ArrayLike) -> Array:
        """Return the configuration q, shape (nq,), of given joint positions, shape (nv,), rad."""
        return self.joints.configuration(positions)

    def positions(self, q: ArrayLike) -> Array:
        """Return the joint positions at q, shape (nv,), rad; in (−π, π] for continuous joints."""
        return self.joints.positions(q)

    def require_within_limits(self, q: ArrayLike) -> None:
        """Make sure that q is inside the joints' position limits; a `ParameterError` names the joint that is not."""
        self.joints.require_within_limits(q)

    def integrate(self, q: Array, displacement: Array) -> Array:
        """Return q ⊕ displacement, shape (nq,), rad, on the configuration manifold."""
        return self.joints.integrate(q, displacement)

    def difference(self, q0: Array, q1: Array) -> Array:
        """Return the displacement that leads from q0 to q1, shape (nv,), rad."""
        return self.joints.difference(q0, q1)

    def state(self, q: ArrayLike, v: ArrayLike) -> ArmState:
        """Compute everything that a torque law needs at q, shape (nq,), rad, and v, shape (nv,), rad/s.

        Raises:
            ShapeError: If q or v has the wrong shape or holds no real numbers.
            NonFiniteError: If q or v holds NaN, infinity or a number beyond `checks.LARGEST`.
            ParameterError: If the cosine and sine of a continuous joint have not length 1.
        """
        return self.kinematics.state(q, v)

    def jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian J of the task coordinates at q, shape (m, nv), world frame."""
        return self.kinematics.jacobian(q)

    def jacobian_derivative(self, q: ArrayLike) -> Array:
        """Return ∂J[i, j] / ∂q_k at q, shape (m, nv, nv)."""
        return self.kinematics.jacobian_derivative(q)

    def task_position(self, q: ArrayLike) -> TaskValue:
        """Return the task value x at q: shape (m,), m, or a `pin.SE3` for a task with rotations."""
        return self.kinematics.task_position(q)

    def skeleton(self, q: ArrayLike) -> Array:
        """Return where the joints and the task frame are at q, shape (nv + 1, 3), m, world frame."""
        return self.kinematics.skeleton(q)

    def skeleton_jacobians(self, q: ArrayLike) -> Array:
        """Return the derivatives of `skeleton` at q, shape (nv + 1, 3, nv)."""
        return self.kinematics.skeleton_jacobians(q)

    def minors_on_border(self, q: ArrayLike) -> NDArray[np.intp]:
        """Return which minors of `minor_columns` are zero at q for practical purposes, as indices, shape (any,)."""
        return self.minors.on_border(q)

    def __reduce__(self) -> tuple[Any, tuple[ArmDescription]]:
        """Pickle and copy an arm as its description, which makes the same arm to the last bit."""
        return type(self).from_description, (self.description,)

    def __repr__(self) -> str:
        """Name the arm, its task and its size."""
        return f"Arm({self.name!r}, frame={self.frame!r}, task={self.task}, nv={self.nv}, task_dim={self.task_dim})"
