"""What every torque law is: a function of the state and the target, with checks around it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import finite_vector, gain_matrix, positive
from ..exceptions import NonFiniteError, NotRedundantError, ShapeError
from ..redundancy import Array
from ..redundancy.compiled import prepared
from ..redundancy.feedback import commanded_acceleration
from ..trajectories import Target


class Controller(ABC):
    """A torque law for one arm.

    A law implements `command`; one with memory also implements `start`. Users call `reset` once and then `torque` at
    every sample.

    Attributes:
        name: Name in the registry.
        switches: Whether the law turns its null-space term on and off.
        is_compiled: Whether `command` is compiled text that refuses, by an exception and before the law's memory
            changes, what does not fit or is not finite, its own result included. A subclass with a `command` of its
            own says so itself.
        compiled_text: Functions made by `redundancy.compiled.compiled` that the law needs: they are loaded, or compiled
            the first time on a machine, when the law is made and not in its first tick.
        arm: The arm.
        kp: Position gain, 1/s².
        kv: Velocity gain, 1/s.
    """

    name: ClassVar[str]
    switches: ClassVar[bool] = False
    is_compiled: ClassVar[bool] = False
    compiled_text: ClassVar[tuple[Callable[..., Any], ...]] = ()

    def __init_subclass__(cls) -> None:
        """Take no `command` for compiled that does not say so."""
        super().__init_subclass__()
        if "command" in vars(cls) and "is_compiled" not in vars(cls):
            cls.is_compiled = False

    def __init__(self, arm: Arm, gain_dim: int, kp: ArrayLike, kv: ArrayLike) -> None:
        """Set the arm and the gains.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            gain_dim: Number of coordinates that are fed back.
            kp: Position gain, 1/s²: a scalar, a vector or a matrix.
            kv: Velocity gain, 1/s: a scalar, a vector or a matrix.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain is negative.
        """
        if arm.redundancy < 1:
            raise NotRedundantError(
                f"{self.name} needs a redundant arm: the task {arm.task} has {arm.task_dim} coordinates, "
                f"{arm.name!r} has {arm.nv} joints; give a task of at most {arm.nv - 1} coordinates"
            )
        self._texts = tuple(map(prepared, self.compiled_text))
        self.arm = arm
        self._state_at: Callable[[Array, Array], Any] = arm.unchecked_state
        self._has_rotation = arm.coordinates.has_rotation
        self._gains = np.stack((gain_matrix("kp", kp, gain_dim), gain_matrix("kv", kv, gain_dim)))
        self.kp, self.kv = self._gains

    @property
    def parameters(self) -> dict[str, Any]:
        """The law's parameters as numbers, strings and lists, enough to construct it again on the same arm."""
        return {"kp": _plain(self.kp), "kv": _plain(self.kv)}

    def reset(self, q: ArrayLike, v: ArrayLike, dt: float) -> None:
        """Prepare for a motion that starts at (q, v).

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
            dt: Time between calls of `torque`, s.

        Raises:
            ShapeError: If q or v has the wrong shape.
            NonFiniteError: If q or v is not finite.
            ParameterError: If dt is not above zero, or the cosine and sine of a continuous joint have not length 1.
        """
        q = self.arm.checked_configuration(q)
        v = finite_vector("v", v, self.arm.nv)
        self.start(q, v, positive("dt", dt, "s"))

    def torque(self, q: ArrayLike, v: ArrayLike, target: Target) -> Array:
        """Return the joint torque to apply until the next sample.

        Args:
            q: Measured joint configuration, shape (nq,), rad.
            v: Measured joint velocity, shape (nv,), rad/s.
            target: What the task is to do now.

        Returns:
            τ, shape (nv,), N m. Always finite.

        Raises:
            ShapeError: If q, v or the target has the wrong shape.
            NonFiniteError: If q or v is not finite, or the torque overflows.
            NotResetError: If the law has memory and `reset` was not called.
        """
        if self.is_compiled and target.is_pose == self._has_rotation:
            # Compiled text refuses what does not fit; only then it is worth the time to find out what was wrong.
            try:
                return self.command(self._state_at(q, v), target)  # type: ignore[arg-type]
            except Exception:  # noqa: S110
                pass
        self.require_target(target)
        state = self.arm.state(q, v)
        with np.errstate(over="ignore", invalid="ignore"):
            try:
                tau = self.command(state, target)
            except FloatingPointError:
                tau = np.full(self.arm.nv, np.nan)
        if not np.isfinite(tau).all():
            raise NonFiniteError(
                f"{self.name}: the torque overflows at a joint speed of {np.abs(state.v).max():.3g} rad/s"
            )
        return tau

    def require_target(self, target: Target) -> None:
        """Make sure that a target is one for the arm's task.

        Raises:
            ShapeError: If it has another number of coordinates, or a pose where positions are due or the reverse.
        """
        arm = self.arm
        if target.dx.shape != (arm.task_dim,) or target.is_pose != arm.coordinates.has_rotation:
            expected = "a pin.SE3 as x and" if arm.coordinates.has_rotation else "an array as x and"
            given = f"{type(target.x).__name__} and {target.dx.shape[0]}"
            raise ShapeError(
                f"the target for the task {arm.task} must have {expected} {arm.task_dim} rates, got {given}"
            )

    @abstractmethod
    def command(self, state: ArmState, target: Target) -> Array:
        """Return the joint torque of the law, shape (nv,), N m, for a valid state and target."""

    def start(self, q: Array, v: Array, dt: float) -> None:  # noqa: B027
        """Set the law's memory for a motion that starts at (q, v); nothing to do for a law without memory."""


class TaskSpaceController(Controller):
    """A law that commands a task acceleration and feeds back the task error."""

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0) -> None:
        """Set the arm and the task-space gains.

        Args:
            arm: The arm; its task must leave at least one joint spare.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain is negative.
        """
        super().__init__(arm, arm.task_dim, kp, kv)
        self._commanded_acceleration = prepared(commanded_acceleration)

    def commanded_acceleration(self, state: ArmState, target: Target) -> Array:
        """Return ẍ_d + K_v ė + K_p e − J̇θ̇ of Eq. (5), shape (m,), m/s² and rad/s².

        The rotation rows of e are the rotation vector from the actual to the desired orientation.
        """
        b: Array = self._commanded_acceleration(*self.terms(state, target)[2:])
        return b

    def terms(self, state: ArmState, target: Target) -> tuple[Any, ...]:
        """Return the arguments of a task-space law in compiled text: `redundancy.feedback.TASK_SPACE`."""
        _, v, M, nle, J, drift, x = state
        if self._has_rotation:
            x = -self.arm.coordinates.error(target.x, x)
        return M, nle, J, drift, x, v, target.rows, self._gains


def _plain(gain: Array) -> float | list[float] | list[list[float]]:
    diagonal = np.diag(gain)
    if not np.array_equal(gain, np.diag(diagonal)):
        return [[float(entry) for entry in row] for row in gain]
    if np.all(diagonal == diagonal[0]):
        return float(diagonal[0])
    return [float(entry) for entry in diagonal]
