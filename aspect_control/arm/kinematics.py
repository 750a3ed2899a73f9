"""A chain of joints on Pinocchio and the task coordinates of one of its frames: states, Jacobians, positions."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike
from pinocchio import (
    computeJointJacobiansTimeVariation,
    computeJointKinematicHessians,
    crba,
    forwardKinematics,
    getFrameClassicalAcceleration,
    getFrameJacobian,
    getFrameJacobianTimeVariation,
    nonLinearEffects,
    updateFramePlacement,
)

from ..checks import finite_vector, read_only
from ..exceptions import ModelError
from ..redundancy import Array
from .arm_state import ArmState
from .chain import require_frame
from .hessian import frame_kinematic_hessian
from .joint_coordinates import JointCoordinates
from .state_samples import StateSamples
from .tasks import Task, TaskValue

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_WORLD = pin.Convention.WORLD


class Kinematics:
    """What Pinocchio computes of a chain of joints and the task coordinates of one of its frames.

    It computes in buffers of its own and must not be shared between threads.
    """

    def __init__(self, joints: JointCoordinates, frame: str, task: Task) -> None:
        """Set the joint coordinates, the name of the task frame and the task.

        Raises:
            FrameNotFoundError: If the model has no such frame.
            ModelError: If a joint moves no mass.
        """
        self._joints = joints
        self._task = task
        self._model = joints.model
        self._data = joints.model.createData()
        self._frame_id = require_frame(joints.model, frame)
        self._rows = task.selection
        self._zero = np.zeros(joints.nv)
        self._require_positive_inertia()

    def state(self, q: ArrayLike, v: ArrayLike) -> ArmState:
        """Compute everything that a torque law needs at (q, v).

        M by the composite rigid body algorithm, N by recursive Newton-Euler at θ̈ = 0, J̇θ̇ as the frame's
        classical acceleration at θ̈ = 0.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.

        Raises:
            ShapeError: If q or v has the wrong shape or holds no real numbers.
            NonFiniteError: If q or v holds NaN, infinity or a number beyond `checks.LARGEST`.
            ParameterError: If the cosine and sine of a continuous joint have not length 1.
        """
        joints = self._joints
        q, v = joints.checked_configuration(q), finite_vector("v", v, joints.nv)
        model, data, frame, rows = self._model, self._data, self._frame_id, self._rows
        M = crba(model, data, q, _WORLD)
        nle = nonLinearEffects(model, data, q, v)
        forwardKinematics(model, data, q, v, self._zero)
        x = self._task.value(updateFramePlacement(model, data, frame))
        J = getFrameJacobian(model, data, frame, _WORLD_ALIGNED)
        drift = getFrameClassicalAcceleration(model, data, frame, _WORLD_ALIGNED).vector[rows].copy()
        if joints.nv == 1:  # eigenpy hands a matrix of one column over as a vector
            M, J = M.reshape(1, 1), J.reshape(6, 1)
        J = np.ascontiguousarray(J[rows])
        for array in (M, nle, J, drift):
            array.setflags(False)  # type: ignore[call-arg]  # as write=False in half the time
        if not self._task.has_rotation:
            x.setflags(False)
        return ArmState(q, v, M, nle, J, drift, x)

    def state_samples(self, q: Array, v: Array) -> StateSamples:
        """Compute what `state` does, and J̇, at many samples, in a fifth of the time for each.

        Args:
            q: Joint configurations, shape (k, nq), rad.
            v: Joint velocities, shape (k, nv), rad/s.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN, infinity or a number beyond `checks.LARGEST`.
            ParameterError: If the cosine and sine of a continuous joint have not length 1.
        """
        model, data, frame, rows, task = self._model, self._data, self._frame_id, self._rows, self._task
        k, n, m = len(q), self._joints.nv, task.dim
        M, nle = np.empty((k, n, n)), np.empty((k, n))
        J, dJ, x = np.empty((k, m, n)), np.empty((k, m, n)), np.empty((k, task.encoded_size))
        for i, (q_i, v_i) in enumerate(zip(self._joints.checked_configurations(q), v, strict=True)):
            computeJointJacobiansTimeVariation(model, data, q_i, v_i)
            x[i] = task.encode(task.value(updateFramePlacement(model, data, frame)))
            J[i] = getFrameJacobian(model, data, frame, _WORLD_ALIGNED).reshape(6, n)[rows]
            dJ[i] = getFrameJacobianTimeVariation(model, data, frame, _WORLD_ALIGNED).reshape(6, n)[rows]
            M[i] = crba(model, data, q_i, _WORLD).reshape(n, n)
            nle[i] = nonLinearEffects(model, data, q_i, v_i)
        return StateSamples(*(read_only(array) for array in (M, nle, J, dJ, x)))

    def jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian J of the task coordinates, shape (m, nv), world frame.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        q = self._joints.checked_configuration(q)
        return self._task_rows(pin.computeFrameJacobian(self._model, self._data, q, self._frame_id, _WORLD_ALIGNED))

    def jacobian_derivative(self, q: ArrayLike) -> Array:
        """Return ∂J[i, j] / ∂q_k, the kinematic Hessian of the task coordinates, shape (m, nv, nv).

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        computeJointKinematicHessians(self._model, self._data, self._joints.checked_configuration(q))
        return np.ascontiguousarray(frame_kinematic_hessian(self._model, self._data, self._frame_id)[self._rows])

    def task_position(self, q: ArrayLike) -> TaskValue:
        """Return the task value x at q: shape (m,), m, or a `pin.SE3` for a task with rotations.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        forwardKinematics(self._model, self._data, self._joints.checked_configuration(q))
        return self._task.value(updateFramePlacement(self._model, self._data, self._frame_id))

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
        pin.forwardKinematics(self._model, self._data, self._joints.checked_configuration(q))
        tip = pin.updateFramePlacement(self._model, self._data, self._frame_id)
        joints = [self._data.oMi[i].translation for i in range(1, self._model.njoints)]
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
        model, data, frame = self._model, self._data, self._frame_id
        pin.computeJointJacobians(model, data, self._joints.checked_configuration(q))
        pin.updateFramePlacement(model, data, frame)
        joints = [pin.getJointJacobian(model, data, i, _WORLD_ALIGNED) for i in range(1, model.njoints)]
        tip = pin.getFrameJacobian(model, data, frame, _WORLD_ALIGNED)
        return np.array([each.reshape(6, self._joints.nv)[:3] for each in (*joints, tip)])

    @cached_property
    def first_joint(self) -> Array:
        """Where the first joint is, shape (3,), m, world frame."""
        return np.array(self._model.jointPlacements[1].translation)

    @cached_property
    def first_joint_in_task(self) -> list[float]:
        """The same in the position coordinates of the task, m."""
        return [float(self.first_joint[axis]) for axis in self._task.position_axes]

    @cached_property
    def reach(self) -> float:
        """Upper bound of the distance between the first joint and the task frame, m.

        The distances between neighbouring joints added up, with the travel of prismatic joints; infinite for a
        prismatic joint without limits. The workspace may be smaller.
        """
        lower, upper = self._joints.position_limits
        travel = np.maximum(np.abs(lower), np.abs(upper))[self._joints.prismatic].sum()
        steps = np.diff(self.skeleton(pin.neutral(self._model)), axis=0)
        return float(np.linalg.norm(steps, axis=1).sum() + travel)

    def _task_rows(self, frame_jacobian: Array) -> Array:
        """Return the task's rows of a frame Jacobian, which eigenpy hands over as a vector if there is one joint."""
        if self._joints.nv == 1:
            frame_jacobian = frame_jacobian.reshape(6, 1)
        return np.ascontiguousarray(frame_jacobian[self._rows])

    def _require_positive_inertia(self) -> None:
        name, nv = self._model.name, self._joints.nv
        M = pin.crba(self._model, self._data, pin.neutral(self._model), _WORLD)
        if not np.isfinite(M).all():
            raise ModelError(
                f"{self._model.name!r} has an inertia matrix that is not finite; check masses and inertias"
            )
        eigenvalues = np.linalg.eigvalsh(M.reshape(nv, nv))
        if not eigenvalues[0] > np.finfo(np.float64).eps * max(eigenvalues[-1], 0.0):
            raise ModelError(
                f"{name!r} has a singular inertia matrix (smallest eigenvalue {eigenvalues[0]:.3g} kg m²): "
                "every joint must move a mass; check the <inertial> elements of the URDF"
            )
