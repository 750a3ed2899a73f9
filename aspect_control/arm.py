"""An arm and what a torque law needs to know of it at one state."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from .checks import finite_vector
from .exceptions import FrameNotFoundError, ModelError
from .redundancy import Array
from .tasks import task_axes
from .urdf import parse_urdf, read_urdf

_WORLD_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass(frozen=True, slots=True, eq=False)
class ArmState:
    """Everything that a torque law needs at (q, v). Arrays belong to the state and do not change.

    Attributes:
        q: Joint configuration θ, shape (nq,), rad (m for prismatic joints).
        v: Joint velocity θ̇, shape (nv,), rad/s.
        M: Joint-space inertia matrix M(θ), shape (nv, nv), kg m².
        nle: Coriolis, centrifugal and gravity torques N(θ, θ̇), shape (nv,), N m.
        J: Jacobian of the task coordinates, shape (m, nv), world frame.
        drift: J̇θ̇, the task acceleration at θ̈ = 0, shape (m,), m/s².
        x: Task coordinates, shape (m,), m.
        dx: Task velocity ẋ = Jθ̇, shape (m,), m/s.
    """

    q: Array
    v: Array
    M: Array
    nle: Array
    J: Array
    drift: Array
    x: Array
    dx: Array


class Arm:
    """A chain of joints on Pinocchio and the task coordinates of one of its frames.

    An arm computes in buffers of its own and must not be shared between threads.

    Attributes:
        model: The `pin.Model` that q and v belong to.
        name: The robot's name.
        frame: Name of the task frame.
        task: The task coordinates, such as `("x", "y")`.
        nq: Number of configuration coordinates.
        nv: Number of joint velocities, n in the paper.
        task_dim: Number of task coordinates, m in the paper.
        redundancy: n − m.
    """

    def __init__(self, model: Any, *, frame: str, task: str | Sequence[str], urdf: str) -> None:
        """Wrap a model; `from_urdf` is the usual way in.

        Args:
            model: A `pin.Model`, gravity included.
            frame: Name of the task frame.
            task: Task coordinates, as for `from_urdf`.
            urdf: Text of the URDF that the model was read from, for recordings.

        Raises:
            FrameNotFoundError: If the model has no such frame.
            TaskError: If `task` is unknown.
            ModelError: If the model has no joints, or a massless link makes its inertia matrix singular.
        """
        self.task = task_axes(task)
        if model.nv == 0:
            raise ModelError(f"{model.name!r} has no joints that move: an arm needs at least one")
        if not isinstance(frame, str) or not model.existFrame(frame):
            raise FrameNotFoundError(frame, [each.name for each in model.frames], context=repr(model.name))
        self.model = model
        self.name: str = model.name
        self.frame = frame
        self.urdf = urdf
        self.nq: int = model.nq
        self.nv: int = model.nv
        self.task_dim = len(self.task)
        self.redundancy = self.nv - self.task_dim
        self._data = model.createData()
        self._frame_id = model.getFrameId(frame)
        self._rows = ["xyz".index(axis) for axis in self.task]
        self._zero = np.zeros(self.nv)
        self._require_positive_inertia()

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str],
        *,
        frame: str,
        task: str | Sequence[str],
        gravity: ArrayLike | None = None,
    ) -> Arm:
        """Load an arm from a URDF file.

        Args:
            path: The URDF file.
            frame: Name of the frame whose motion is the task: any link, joint or frame of the URDF.
            task: `"xy"`, `"xz"`, `"yz"`, `"xyz"`, or a sequence of distinct coordinates from `("x", "y", "z")`;
                positions in the world frame, m.
            gravity: Gravitational acceleration in the world frame, shape (3,), m/s²; None for (0, 0, −9.81).

        Raises:
            ModelError: If the file is missing or is no URDF of an arm.
            FrameNotFoundError: If there is no such frame; the message lists those that exist.
            TaskError: If `task` is unknown.
            ShapeError: If `gravity` has not three entries.
            NonFiniteError: If `gravity` is not finite.
        """
        return cls.from_urdf_text(read_urdf(path), frame=frame, task=task, gravity=gravity, source=str(path))

    @classmethod
    def from_urdf_text(
        cls,
        text: str,
        *,
        frame: str,
        task: str | Sequence[str],
        gravity: ArrayLike | None = None,
        source: str = "the given text",
    ) -> Arm:
        """Load an arm from the text of a URDF.

        Args:
            text: The URDF.
            frame: As for `from_urdf`.
            task: As for `from_urdf`.
            gravity: As for `from_urdf`.
            source: What the text is called in errors.

        Raises:
            AspectControlError: As for `from_urdf`.
        """
        model = parse_urdf(text, source)
        if gravity is not None:
            model.gravity.linear = finite_vector("gravity", gravity, 3)
        return cls(model, frame=frame, task=task, urdf=text)

    @property
    def gravity(self) -> Array:
        """Gravitational acceleration in the world frame, shape (3,), m/s²."""
        return np.array(self.model.gravity.linear)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, from the base."""
        return tuple(self.model.names)[1:]

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
        """
        q = finite_vector("q", q, self.nq)
        v = finite_vector("v", v, self.nv)
        model, data, frame = self.model, self._data, self._frame_id
        M = pin.crba(model, data, q, pin.Convention.WORLD)
        nle = pin.rnea(model, data, q, v, self._zero)
        pin.forwardKinematics(model, data, q, v, self._zero)
        x = pin.updateFramePlacement(model, data, frame).translation[self._rows]
        J = pin.getFrameJacobian(model, data, frame, _WORLD_ALIGNED)[self._rows]
        drift = pin.getFrameClassicalAcceleration(model, data, frame, _WORLD_ALIGNED).linear[self._rows]
        return ArmState(q, v, M, nle, J, drift, x, J @ v)

    def jacobian(self, q: ArrayLike) -> Array:
        """Return the Jacobian J of the task coordinates, shape (m, nv), world frame.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        q = finite_vector("q", q, self.nq)
        J: Array = pin.computeFrameJacobian(self.model, self._data, q, self._frame_id, _WORLD_ALIGNED)[self._rows]
        return J

    def jacobian_derivative(self, q: ArrayLike) -> Array:
        """Return ∂J[i, j] / ∂q_k, the kinematic Hessian of the task coordinates, shape (m, nv, nv).

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        q = finite_vector("q", q, self.nq)
        pin.computeJointKinematicHessians(self.model, self._data, q)
        derivative: Array = _frame_hessian(self.model, self._data, self._frame_id)[self._rows]
        return derivative

    def task_position(self, q: ArrayLike) -> Array:
        """Return the task coordinates x at q, shape (m,), m.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        x: Array = self.skeleton(q)[-1][self._rows]
        return x

    def skeleton(self, q: ArrayLike) -> Array:
        """Return where the joints and the task frame are, for drawing.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Returns:
            Positions in the world frame, shape (number of joints + 1, 3), m: the joints from the base, then the frame.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
        """
        q = finite_vector("q", q, self.nq)
        pin.forwardKinematics(self.model, self._data, q)
        tip = pin.updateFramePlacement(self.model, self._data, self._frame_id)
        joints = [self._data.oMi[i].translation for i in range(1, self.model.njoints)]
        return np.array([*joints, tip.translation])

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

    def _require_positive_inertia(self) -> None:
        M = pin.crba(self.model, self._data, pin.neutral(self.model), pin.Convention.WORLD)
        eigenvalues = np.linalg.eigvalsh(M)
        if not eigenvalues[0] > np.finfo(np.float64).eps * max(eigenvalues[-1], 0.0):
            raise ModelError(
                f"{self.name!r} has a singular inertia matrix (smallest eigenvalue {eigenvalues[0]:.3g} kg m²): "
                "every joint must move a mass; check the <inertial> elements of the URDF"
            )


def _frame_hessian(model: Any, data: Any, frame_id: int) -> Array:
    hessian: Array = pin.getFrameKinematicHessian(model, data, frame_id, _WORLD_ALIGNED)
    return hessian.reshape(hessian.shape[::-1]).transpose() if _hessian_is_column_major() else hessian


@lru_cache(maxsize=1)
def _hessian_is_column_major() -> bool:
    """Tell whether Pinocchio labels its column-major Hessian as row-major, as 4.1.0 does, by comparing H v with J̇."""
    model = pin.buildSampleModelManipulator()
    data = model.createData()
    frame_id = model.nframes - 1
    q, v = np.linspace(0.3, 1.1, model.nv), np.linspace(-0.7, 0.9, model.nv)
    pin.computeJointJacobiansTimeVariation(model, data, q, v)
    pin.updateFramePlacements(model, data)
    expected = pin.getFrameJacobianTimeVariation(model, data, frame_id, _WORLD_ALIGNED)
    pin.computeJointKinematicHessians(model, data, q)
    hessian = pin.getFrameKinematicHessian(model, data, frame_id, _WORLD_ALIGNED)
    return not np.allclose(hessian @ v, expected)
