"""What every torque law is: a function of the state and the target, with checks around it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from inspect import signature
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm, ArmState
from ..checks import finite_vector, gain_matrix, is_finite, positive, restore_read_only
from ..exceptions import NonFiniteError, NotRedundantError, ParameterError, ShapeError
from ..redundancy import Array
from ..redundancy.feedback import commanded_acceleration
from ..trajectories import Target


class Controller(ABC):
    """A torque law for one arm.

    A law implements `command`; one with memory also implements `start`. Users call `reset` once and then `torque` at
    every sample.

    All that a law carries from one sample to the next is in `memory`, one value that `start` and `command` replace and
    never change: a call that is refused puts the old one back and leaves no trace.

    Attributes:
        name: Name in the registry.
        switches: Whether the law turns its null-space term on and off.
        arm: The arm.
        kp: Position gain K_p, 1/s², a square matrix, read-only.
        kv: Velocity gain K_v, 1/s, a square matrix, read-only.
        memory: What the law remembers of the motion; None for a law without memory, and before `reset`.
    """

    name: ClassVar[str]
    switches: ClassVar[bool] = False
    memory: Any = None
    kp: Array
    kv: Array
    _parameter_names: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, arm: Arm, gain_dim: int, kp: ArrayLike, kv: ArrayLike) -> None:
        """Set the arm and the gains.

        Args:
            arm: The arm; its task must leave a redundant degree of freedom.
            gain_dim: Number of coordinates that are fed back.
            kp: Position gain, 1/s²: a scalar, a vector or a matrix.
            kv: Velocity gain, 1/s: a scalar, a vector or a matrix.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain is negative.
        """
        if not isinstance(arm, Arm):
            raise ParameterError(f"{self.name} needs an Arm, got {type(arm).__name__}")
        if arm.redundancy < 1:
            raise NotRedundantError(
                f"{self.name} needs a redundant arm: the task {arm.task} has {arm.task_dim} coordinates, "
                f"{arm.name!r} has {arm.nv} joints; give a task of at most {arm.nv - 1} coordinates"
            )
        self.arm = arm
        self.kp, self.kv = gain_matrix("kp", kp, gain_dim), gain_matrix("kv", kv, gain_dim)

    def __init_subclass__(cls) -> None:
        """Note the names of the law's parameters."""
        super().__init_subclass__()
        cls._parameter_names = cls._parameter_names | frozenset(signature(cls).parameters)

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute; a parameter is set once, when the law is made, so that what is recorded is what counts."""
        if name in self._parameter_names and name in self.__dict__:
            raise AttributeError(f"{self.name}: {name} is fixed when a law is made; make another with {name}={value!r}")
        super().__setattr__(name, value)

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
        q = self.arm.joints.checked_configuration(q)
        v = finite_vector("v", v, self.arm.nv)
        dt, memory = positive("dt", dt, "s"), self.memory
        try:
            self.start(q, v, dt)
        except BaseException:
            self.memory = memory
            raise

    def torque(self, q: ArrayLike, v: ArrayLike, target: Target) -> Array:
        """Return the joint torque to apply until the next sample.

        What `command` or a criterion raises reaches the caller as it is.

        Args:
            q: Measured joint configuration, shape (nq,), rad.
            v: Measured joint velocity, shape (nv,), rad/s.
            target: What the task is to do now.

        Returns:
            τ, shape (nv,), N m. Always finite.

        Raises:
            ShapeError: If q, v, the target or the torque has the wrong shape.
            NonFiniteError: If q, v or the torque is not finite.
            ParameterError: If `target` is no `Target`, or the cosine and sine of a continuous joint have not length 1.
            NotResetError: If the law has memory and `reset` was not called.
        """
        self.require_target(target)
        return self.torque_at(self.arm.state(q, v), target)

    def torque_at(self, state: ArmState, target: Target) -> Array:
        """Return the joint torque at a state of the arm: `torque` for a caller that has the state, such as a guard.

        Args:
            state: The arm's state, `arm.state(q, v)`.
            target: What the task is to do now, a target that `require_target` takes.

        Returns:
            τ, shape (nv,), N m. Always finite.

        Raises:
            ShapeError: If the torque has the wrong shape.
            NonFiniteError: If the torque is not finite.
            NotResetError: If the law has memory and `reset` was not called.
        """
        memory = self.memory
        try:
            tau = self.command(state, target)
            if type(tau) is not np.ndarray or tau.shape != state.v.shape or not is_finite(tau):
                tau = self._checked(tau, state)
        except BaseException:
            self.memory = memory
            raise
        return tau

    def require_target(self, target: Target) -> None:
        """Make sure that a target is one for the arm's task.

        Raises:
            ParameterError: If it is no `Target`.
            ShapeError: If it has another number of coordinates, or a pose where positions are due or the reverse.
        """
        if not isinstance(target, Target):
            raise ParameterError(f"target must be a Target(x, dx, ddx), got {type(target).__name__}")
        arm, has_rotation = self.arm, self.arm.coordinates.has_rotation
        if len(target.dx) != arm.task_dim or isinstance(target.x, np.ndarray) is has_rotation:
            expected = "a pin.SE3 as x and" if has_rotation else "an array as x and"
            given = f"{type(target.x).__name__} and {len(target.dx)}"
            raise ShapeError(
                f"the target for the task {arm.task} must have {expected} {arm.task_dim} rates, got {given}"
            )

    @abstractmethod
    def command(self, state: ArmState, target: Target) -> Array:
        """Return the joint torque of the law, shape (nv,), N m, for a valid state and target."""

    def start(self, q: Array, v: Array, dt: float) -> None:  # noqa: B027
        """Set the law's memory for a motion that starts at (q, v); nothing to do for a law without memory.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
            dt: Sampling time, s.
        """

    def _checked(self, tau: Any, state: ArmState) -> Array:
        """Return a law's result as a torque, or say what is wrong with it."""
        try:
            torque = np.array(tau, dtype=np.float64)
        except (TypeError, ValueError):
            raise ShapeError(f"{self.name}: command must return {self.arm.nv} torques, got {tau!r}") from None
        if torque.shape != state.v.shape:
            raise ShapeError(f"{self.name}: command must return shape {state.v.shape}, got {torque.shape}")
        if not np.isfinite(torque).all():
            raise NonFiniteError(
                f"{self.name}: the torque is not finite at a joint speed of {np.abs(state.v).max():.3g} rad/s"
            )
        return torque

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over what was pickled or copied, with its arrays read-only again."""
        restore_read_only(self, state)


class TaskSpaceController(Controller):
    """A law that commands a task acceleration and feeds back the task error."""

    def __init__(self, arm: Arm, *, kp: ArrayLike = 100.0, kv: ArrayLike = 20.0) -> None:
        """Set the arm and the task-space gains.

        Args:
            arm: The arm; its task must leave a redundant degree of freedom.
            kp: Position gain K_p, 1/s²: a scalar, a vector of m entries or an (m, m) matrix.
            kv: Velocity gain K_v, 1/s: a scalar, a vector of m entries or an (m, m) matrix.

        Raises:
            NotRedundantError: If the task takes up every joint.
            ShapeError: If a gain has the wrong shape.
            NonFiniteError: If a gain is not finite.
            ParameterError: If a gain is negative.
        """
        super().__init__(arm, arm.task_dim if isinstance(arm, Arm) else 0, kp, kv)

    def commanded_acceleration(self, state: ArmState, target: Target) -> Array:
        """Return ẍ_d + K_v ė + K_p e − J̇θ̇ of Eq. (5), shape (m,), m/s² and rad/s².

        The rotation rows of e are the rotation vector from the actual to the desired orientation. A law whose subclass
        overrides this method uses what that returns.
        """
        error = self.arm.coordinates.error(target.x, state.x)
        b: Array = commanded_acceleration(state.J, state.drift, state.v, error, target.dx, target.ddx, self.kp, self.kv)
        return b


def _plain(gain: Array) -> float | list[float] | list[list[float]]:
    diagonal = np.diag(gain)
    if not np.array_equal(gain, np.diag(diagonal)):
        return [[float(entry) for entry in row] for row in gain]
    if np.all(diagonal == diagonal[0]):
        return float(diagonal[0])
    return [float(entry) for entry in diagonal]
