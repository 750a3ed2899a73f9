"""A chain of joints on Pinocchio and the task coordinates of one of its frames: states, Jacobians, positions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike
from pinocchio import (
    computeJointKinematicHessians,
    crba,
    forwardKinematics,
    getFrameClassicalAcceleration,
    getFrameJacobian,
    nonLinearEffects,
    updateFramePlacement,
)

from .arm_state import ArmState
from .chain import require_frame
from .checks import finite_vector
from .configuration_space import ConfigurationSpace
from .exceptions import ModelError
from .hessian import frame_kinematic_hessian
from .redundancy import Array
from .tasks import POSITION_AXES, Task, TaskValue

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_WORLD = pin.Convention.WORLD
_new_tuple = tuple.__new__


class TaskChain(ConfigurationSpace):
    """What Pinocchio computes of a chain and a task.

    It computes in buffers of its own and must not be shared between threads.

    Attributes:
        name: The robot's name.
        frame: Name of the task frame.
        task: The task coordinates, such as `("x", "y")`.
        coordinates: The same as a `Task`, which compares and displaces task values.
        task_dim: Number of task coordinates, m in the paper.
        redundancy: n − m.
    """

    def __init__(self, model: Any, frame: str, coordinates: Task) -> None:
        """Set the model, a `pin.Model` of a chain, the name of the frame and the task.

        Raises:
            FrameNotFoundError: If the model has no such frame.
            ModelError: If a joint moves no mass.
        """
        super().__init__(model)
        self.name: str = model.name
        self.frame = frame
        self.coordinates = coordinates
        self.task = coordinates.axes
        self.task_dim = coordinates.dim
        self.redundancy = self.nv - self.task_dim
        self._data = model.createData()
        self._frame_id = require_frame(model, frame)
        self._rows = coordinates.selection
        self._zero = np.zeros(self.nv)
        self._unknown = np.full(self.task_dim, np.nan)
        self._last_state: tuple[Any, ...] | None = None
        self._rows_first = self._rows == slice(0, self.task_dim)
        self._is_xyz = self.task == POSITION_AXES
        self._require_positive_inertia()

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
        q, v, M, nle, J, drift, x = self.unchecked_terms(q, v)
        self._last_state = state = _new_tuple(ArmState, (q, v, M, nle, J[: self.task_dim], drift, x))
        return state

    def unchecked_terms(self, q: Array, v: Array) -> tuple[Any, ...]:
        """Return `unchecked_state` as a plain tuple, for laws that only take it apart.

        Where the task's rows are the first of the frame's Jacobian, J is the whole of it, shape (6, nv).

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
        self._last_state = terms = (q, v, M, nle, J if self._rows_first else J[rows], drift, x)
        return terms

    def unchecked_state_without_task(self, q: Array, v: Array) -> ArmState:
        """Return `unchecked_state` with NaN for x and drift.

        For laws that resolve redundancy in velocities, ask for neither and need not wait for them.

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

    def _task_rows(self, frame_jacobian: Array) -> Array:
        """Return the task's rows of a frame Jacobian, which eigenpy hands over as a vector if there is one joint."""
        return (frame_jacobian if self.nv > 1 else frame_jacobian.reshape(6, 1))[self._rows]

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
