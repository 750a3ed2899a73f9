"""An arm and what a torque law needs to know of it at one state."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray
from pinocchio import (
    computeJointKinematicHessians,
    crba,
    forwardKinematics,
    getFrameClassicalAcceleration,
    getFrameJacobian,
    nonLinearEffects,
    updateFramePlacement,
)

from .chain import (
    NO_LIMIT,
    is_prismatic,
    joint_position,
    joints_to_lock,
    position_limits,
    reduce_model,
    require_frame,
    unit_hint,
)
from .chain_record import record_chain
from .checks import finite_vector
from .description import ArmDescription
from .exceptions import ModelError, ParameterError, TooManyMinorsError
from .hessian import frame_kinematic_hessian
from .redundancy import MAX_MINORS, Array, minors, structural_minor_columns
from .tasks import POSITION_AXES, Task, TaskValue
from .urdf import mimic_joints, parse_urdf, read_urdf

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_WORLD = pin.Convention.WORLD
_new_tuple = tuple.__new__

BORDER_TOLERANCE = 1e-6
"""Part of its own scale up to which a minor counts as zero at the start of a motion."""

_SAMPLED_POSTURES = 32
"""Random postures in which a minor must vanish to count as structurally zero."""


class ArmState(NamedTuple):
    """Everything that a torque law needs at (q, v). Arrays belong to the state and do not change.

    Rows of J, drift and dx are the task coordinates: positions in m, rotations in rad, world frame.

    Attributes:
        q: Joint configuration θ, shape (nq,), rad (m for prismatic joints, cosine and sine for continuous ones).
        v: Joint velocity θ̇, shape (nv,), rad/s.
        M: Joint-space inertia matrix M(θ), shape (nv, nv), kg m².
        nle: Coriolis, centrifugal and gravity torques N(θ, θ̇), shape (nv,), N m.
        J: Jacobian of the task coordinates, shape (m, nv).
        drift: J̇θ̇, the task acceleration at θ̈ = 0, shape (m,), m/s² and rad/s².
        x: Task value: shape (m,), m, for a task of positions; a `pin.SE3` for one with rotations.
    """

    q: Array
    v: Array
    M: Array
    nle: Array
    J: Array
    drift: Array
    x: TaskValue

    @property
    def dx(self) -> Array:
        """Task velocity ẋ = Jθ̇, shape (m,), m/s and rad/s."""
        velocity: Array = self.J @ self.v
        return velocity


class Arm:
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
            ModelError: If no joint moves the frame, or a joint moves no mass.
        """
        locked, q = joints_to_lock(model, description.frame, description.locked, passive)
        self.model = reduce_model(model, locked, q)
        self.model.gravity.linear = np.array(description.gravity)
        self.description = description
        self.coordinates = Task(description.task)
        self.name: str = model.name
        self.frame = description.frame
        self.task = self.coordinates.axes
        self.nq: int = self.model.nq
        self.nv: int = self.model.nv
        self.task_dim = self.coordinates.dim
        self.redundancy = self.nv - self.task_dim
        self._data = self.model.createData()
        self._frame_id = require_frame(self.model, self.frame)
        self._rows = self.coordinates.selection
        self._zero = np.zeros(self.nv)
        self._unknown = np.full(self.task_dim, np.nan)
        self._last_state: tuple[Any, ...] | None = None
        self._is_xyz = self.task == POSITION_AXES
        self._require_positive_inertia()

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
        from .examples import find_example, load_example_model

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
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, from the base."""
        return tuple(self.model.names)[1:]

    @cached_property
    def prismatic(self) -> NDArray[np.bool_]:
        """Which joints slide, shape (nv,)."""
        return np.array([is_prismatic(self.model, joint) for joint in range(1, self.model.njoints)])

    @cached_property
    def position_limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of the joint positions, shapes (nv,), rad; infinite where the model has none."""
        return position_limits(self.model)

    @cached_property
    def torque_limit(self) -> Array:
        """Largest |τ| of each joint, shape (nv,), N m; infinite where the model has none."""
        return _limit(self.model.effortLimit)

    @cached_property
    def velocity_limit(self) -> Array:
        """Largest |θ̇| of each joint, shape (nv,), rad/s; infinite where the model has none."""
        return _limit(self.model.velocityLimit)

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

    def __repr__(self) -> str:
        """Name the arm, its task and its size."""
        return f"Arm({self.name!r}, frame={self.frame!r}, task={self.task}, nv={self.nv}, task_dim={self.task_dim})"

    def state(self, q: ArrayLike, v: ArrayLike) -> ArmState:
        """Compute everything that a torque law needs at (q, v).

        M by the composite rigid body algorithm, N by recursive Newton-Euler at θ̈ = 0, J̇θ̇ as the frame's
        classical acceleration at θ̈ = 0.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.

        Raises:
            ShapeError: If q or v has the wrong shape.
            NonFiniteError: If q or v holds NaN or infinity.
            ParameterError: If the cosine and sine of a continuous joint have not length 1.
        """
        state = self.unchecked_state(self.checked_configuration(q), finite_vector("v", v, self.nv))
        self._last_state = state = state._replace(x=state.x.copy())
        return state

    def unchecked_state(self, q: Array, v: Array) -> ArmState:
        """Return the state at (q, v) for a moment: q and v are kept as they are, and x only until the next call.

        For laws whose own text checks what they take.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
        """
        # What a NamedTuple's own constructor does, in half the time.
        self._last_state = state = _new_tuple(ArmState, self.unchecked_terms(q, v))
        return state

    def unchecked_terms(self, q: Array, v: Array) -> tuple[Any, ...]:
        """Return `unchecked_state` as a plain tuple, for laws that only take it apart.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
        """
        model, data, frame, rows = self.model, self._data, self._frame_id, self._rows
        M = crba(model, data, q, _WORLD)
        nle = nonLinearEffects(model, data, q, v)
        forwardKinematics(model, data, q, v, self._zero)
        pose = updateFramePlacement(model, data, frame)
        J = getFrameJacobian(model, data, frame, _WORLD_ALIGNED)
        acceleration = getFrameClassicalAcceleration(model, data, frame, _WORLD_ALIGNED)
        if self._is_xyz:
            x, drift = pose.translation, acceleration.linear
        else:
            x, drift = self.coordinates.value(pose), acceleration.vector[rows]
        if self.nv == 1:  # eigenpy hands a matrix of one column over as a vector
            M, J = M.reshape(1, 1), J.reshape(6, 1)
        self._last_state = terms = (q, v, M, nle, J[rows], drift, x)
        return terms

    def unchecked_state_without_task(self, q: Array, v: Array) -> ArmState:
        """Return `unchecked_state` with NaN for x and drift, which take half of its time.

        For laws that resolve redundancy in velocities and ask for neither.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
        """
        model, data = self.model, self._data
        M = crba(model, data, q, _WORLD)
        nle = nonLinearEffects(model, data, q, v)
        J = getFrameJacobian(model, data, self._frame_id, _WORLD_ALIGNED)
        if self.nv == 1:
            M, J = M.reshape(1, 1), J.reshape(6, 1)
        unknown = self._unknown
        self._last_state = state = _new_tuple(ArmState, (q, v, M, nle, J[self._rows], unknown, unknown))
        return state

    def jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian J of the task coordinates, shape (m, nv), world frame.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        q = self.checked_configuration(q)
        self._last_state = None
        return self._task_rows(pin.computeFrameJacobian(self.model, self._data, q, self._frame_id, _WORLD_ALIGNED))

    def jacobian_derivative(self, q: ArrayLike) -> Array:
        """Return ∂J[i, j] / ∂q_k, the kinematic Hessian of the task coordinates, shape (m, nv, nv).

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        self._last_state = None
        computeJointKinematicHessians(self.model, self._data, self.checked_configuration(q))
        derivative: Array = frame_kinematic_hessian(self.model, self._data, self._frame_id)[self._rows]
        return derivative

    def jacobian_derivative_at(self, state: ArmState) -> Array:
        """Return `jacobian_derivative` at a state; for the last one computed, with what Pinocchio still knows of it.

        Args:
            state: A state of this arm.
        """
        if state is not self._last_state:
            return self.jacobian_derivative(state.q)
        computeJointKinematicHessians(self.model, self._data)
        derivative: Array = frame_kinematic_hessian(self.model, self._data, self._frame_id)[self._rows]
        return derivative

    def task_position(self, q: ArrayLike) -> TaskValue:
        """Return the task value x at q: shape (m,), m, or a `pin.SE3` for a task with rotations.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        self._last_state = None
        pin.forwardKinematics(self.model, self._data, self.checked_configuration(q))
        return self.coordinates.value(pin.updateFramePlacement(self.model, self._data, self._frame_id))

    def task_position_at(self, q: Array) -> TaskValue:
        """Return `task_position` at a valid configuration; at the q of the last state, the same array, what it holds.

        Args:
            q: Joint configuration, shape (nq,), rad; an array that has not changed since.
        """
        if self._last_state is None:
            return self.task_position(q)
        q_last, *_, x_last = self._last_state
        if q_last is not q or x_last is self._unknown:
            return self.task_position(q)
        return x_last if self.coordinates.has_rotation else x_last.copy()

    def skeleton(self, q: ArrayLike) -> Array:
        """Return where the joints and the task frame are, for drawing.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Returns:
            Positions in the world frame, shape (nv + 1, 3), m: the joints from the base, then the frame.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        self._last_state = None
        pin.forwardKinematics(self.model, self._data, self.checked_configuration(q))
        tip = pin.updateFramePlacement(self.model, self._data, self._frame_id)
        joints = [self._data.oMi[i].translation for i in range(1, self.model.njoints)]
        return np.array([*joints, tip.translation])

    def skeleton_jacobians(self, q: ArrayLike) -> Array:
        """Return the derivatives of `skeleton` with respect to the joint coordinates.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Returns:
            Jacobian of each point in the world frame, shape (nv + 1, 3, nv).

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        model, data, frame = self.model, self._data, self._frame_id
        pin.computeJointJacobians(model, data, self.checked_configuration(q))
        pin.updateFramePlacement(model, data, frame)
        joints = [pin.getJointJacobian(model, data, i, _WORLD_ALIGNED) for i in range(1, model.njoints)]
        tip = pin.getFrameJacobian(model, data, frame, _WORLD_ALIGNED)
        return np.array([each.reshape(6, self.nv)[:3] for each in (*joints, tip)])

    def configuration(self, positions: ArrayLike) -> Array:
        """Return the configuration q of given joint positions.

        Args:
            positions: Positions of the joints, shape (nv,), rad (m for prismatic joints).

        Returns:
            q, shape (nq,): the positions themselves, with cosine and sine in place of a continuous joint's angle.

        Raises:
            ShapeError: If there is not one position a joint.
            NonFiniteError: If a position is not finite.
        """
        positions = finite_vector("positions", positions, self.nv)
        q: Array = pin.integrate(self.model, pin.neutral(self.model), positions)
        return q

    def positions(self, q: ArrayLike) -> Array:
        """Return the joint positions of a configuration, shape (nv,), rad; in (−π, π] for continuous joints.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        q = self.checked_configuration(q)
        return np.array([joint_position(self.model, q, joint) for joint in range(1, self.model.njoints)])

    def require_within_limits(self, q: ArrayLike) -> None:
        """Make sure that a configuration is inside the joints' position limits.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ParameterError: If a joint is outside; the message names it and hints at a mistaken unit.
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        lower, upper = self.position_limits
        for i, position in enumerate(self.positions(q)):
            if not lower[i] <= position <= upper[i]:
                hint = unit_hint(position, lower[i], upper[i], prismatic=bool(self.prismatic[i]))
                raise ParameterError(
                    f"joint {self.joint_names[i]!r} at {position:g} is outside its limits "
                    f"[{lower[i]:g}, {upper[i]:g}]{hint}"
                )

    def integrate(self, q: Array, displacement: Array) -> Array:
        """Return the configuration that `displacement` leads to from q, on the configuration manifold.

        Args:
            q: Joint configuration, shape (nq,), rad.
            displacement: Joint velocity times time, shape (nv,), rad.

        Returns:
            q ⊕ displacement, shape (nq,), rad.
        """
        result: Array = pin.integrate(self.model, q, displacement)
        return result

    def difference(self, q0: Array, q1: Array) -> Array:
        """Return the displacement that leads from q0 to q1, shape (nv,), rad.

        Args:
            q0: Joint configuration, shape (nq,), rad.
            q1: Joint configuration, shape (nq,), rad.
        """
        result: Array = pin.difference(self.model, q0, q1)
        return result

    def _task_rows(self, frame_jacobian: Array) -> Array:
        """Return the task's rows of a frame Jacobian, which eigenpy hands over as a vector if there is one joint."""
        return (frame_jacobian if self.nv > 1 else frame_jacobian.reshape(6, 1))[self._rows]

    def checked_configuration(self, q: ArrayLike) -> Array:
        """Return a copy of q after checking it, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
            ParameterError: If the cosine and sine of a continuous joint have not length 1.
        """
        q = finite_vector("q", q, self.nq)
        if self.nq != self.nv and not pin.isNormalized(self.model, q, 1e-6):
            raise ParameterError(
                "q holds the cosine and sine of each continuous joint, which must have length 1; "
                f"got {q.tolist()}; arm.configuration(positions) makes a q of angles"
            )
        return q

    def _require_positive_inertia(self) -> None:
        M = pin.crba(self.model, self._data, pin.neutral(self.model), pin.Convention.WORLD)
        if not np.isfinite(M).all():
            raise ModelError(f"{self.name!r} has an inertia matrix that is not finite; check masses and inertias")
        eigenvalues = np.linalg.eigvalsh(M.reshape(self.nv, self.nv))
        if not eigenvalues[0] > np.finfo(np.float64).eps * max(eigenvalues[-1], 0.0):
            raise ModelError(
                f"{self.name!r} has a singular inertia matrix (smallest eigenvalue {eigenvalues[0]:.3g} kg m²): "
                "every joint must move a mass; check the <inertial> elements of the URDF"
            )


def _limit(values: Array) -> Array:
    """Return limits with infinity for none, which Pinocchio writes as zero or as the largest number."""
    return np.where((values > 0.0) & (values < NO_LIMIT), values, np.inf)
