"""The joint coordinates of an arm: their names, their limits and how they are added."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from ..checks import LARGEST, finite_vector, read_only
from ..exceptions import ParameterError
from ..redundancy import Array
from .chain import NO_LIMIT, is_prismatic, joint_position, position_limits, unit_hint


class JointCoordinates:
    """The joint coordinates of a chain of revolute, continuous and prismatic joints.

    Attributes:
        model: The `pin.Model` that q and v belong to.
        nq: Number of configuration coordinates.
        nv: Number of joint velocities, n in the paper.
    """

    def __init__(self, model: Any) -> None:
        """Set the model, a `pin.Model`."""
        self.model = model
        self.nq: int = model.nq
        self.nv: int = model.nv

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, from the base."""
        return tuple(self.model.names)[1:]

    @cached_property
    def prismatic(self) -> NDArray[np.bool_]:
        """Which joints slide, shape (nv,)."""
        return read_only(np.array([is_prismatic(self.model, joint) for joint in range(1, self.model.njoints)]))

    @cached_property
    def position_limits(self) -> tuple[Array, Array]:
        """Lower and upper limits of the joint positions, shapes (nv,), rad; infinite where the model has none."""
        lower, upper = position_limits(self.model)
        return read_only(lower), read_only(upper)

    @cached_property
    def torque_limit(self) -> Array:
        """Largest |τ| of each joint, shape (nv,), N m; infinite where the model has none."""
        return _limit(self.model.effortLimit)

    @cached_property
    def velocity_limit(self) -> Array:
        """Largest |θ̇| of each joint, shape (nv,), rad/s; infinite where the model has none."""
        return _limit(self.model.velocityLimit)

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

    def checked_configurations(self, q: Array) -> Array:
        """Return many configurations, shape (k, nq), rad, after checking them.

        Raises:
            AspectControlError: As `checked_configuration` does, of the first that is refused.
        """
        sound = q.ndim == 2 and q.shape[1] == self.nq == self.nv and np.abs(q).max(initial=0.0) <= LARGEST
        return q if sound else np.array([self.checked_configuration(each) for each in q]).reshape(len(q), self.nq)


def _limit(values: Array) -> Array:
    """Return limits with infinity for none, which Pinocchio writes as zero or as the largest number."""
    return read_only(np.where((values > 0.0) & (values < NO_LIMIT), values, np.inf))
