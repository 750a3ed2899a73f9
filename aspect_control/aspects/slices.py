"""Two-dimensional slices through an arm's configurations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.postures import jacobian, sampling_range, wrap_angles
from ..checks import known_name
from ..exceptions import JointNotFoundError, ParameterError
from ..redundancy import Array, minors, null_vector
from .self_motion import SelfMotion, self_motion

_SWEEP = 60
"""Positions of a joint at which the signs of the minors are compared to see what it changes."""


class Axis(NamedTuple):
    """One of the two coordinates of a slice.

    Attributes:
        name: What it is.
        low: Its smallest value, rad (m for prismatic joints).
        high: Its largest value, rad.
        unit: `"rad"` or `"m"`.
        angle: Whether it is a joint angle, which is best shown in degrees.
    """

    name: str
    low: float
    high: float
    unit: str
    angle: bool

    @property
    def full_turn(self) -> bool:
        """Whether the axis is a whole turn of a joint, so that its ends are the same."""
        return self.angle and bool(np.isclose(self.high - self.low, 2.0 * np.pi))

    def centres(self, count: int) -> Array:
        """Return the centres of `count` equal cells, shape (count,)."""
        cells: Array = self.low + (np.arange(count) + 0.5) * (self.high - self.low) / count
        return cells


class Slice(ABC):
    """A surface in an arm's configurations with two coordinates.

    Attributes:
        arm: The arm.
        horizontal: The first coordinate.
        vertical: The second coordinate.
        start: Joint positions that the slice was laid through, shape (nv,), rad.
    """

    arm: Arm
    horizontal: Axis
    vertical: Axis
    start: Array

    @abstractmethod
    def posture(self, a: float, b: float) -> Array:
        """Return the joint positions at coordinates (a, b), shape (nv,), rad."""

    @abstractmethod
    def direction(self, a: Array, displacement: Array) -> Array:
        """Return the components of joint displacements along the two coordinates.

        Args:
            a: First coordinates of the places, shape (k,), rad.
            displacement: Joint displacements there, shape (..., k, nv), rad.

        Returns:
            The components, shape (..., k, 2), rad; what leads out of the slice is left out.
        """

    @abstractmethod
    def trace(self, positions: Array) -> Array:
        """Return the coordinates of the places nearest to joint positions, shapes (k, 2) and (k, nv), rad."""


class JointSlice(Slice):
    """Two joints vary, the others stay."""

    def __init__(self, arm: Arm, q: ArrayLike, joints: tuple[str, str] | None = None) -> None:
        """Lay the slice through a posture.

        Args:
            arm: The arm.
            q: Joint configuration at which the other joints stay, shape (nq,), rad.
            joints: Names of the two joints; None for those two that change the signs of most minors, looked at one by
                one from q.

        Raises:
            JointNotFoundError: If there is no such joint; the message lists those that exist.
            ParameterError: If the two are one and the same, or the arm has only one joint.
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q is not finite.
        """
        self.arm, self.start = arm, arm.positions(q)
        first, second = joints if joints is not None else _most_sign_changing_joints(arm, self.start)
        self.joints = joint_index(arm, first), joint_index(arm, second)
        if first == second:
            raise ParameterError(f"a slice needs two joints, got {first!r} twice")
        self.horizontal, self.vertical = (_joint_axis(arm, joint) for joint in self.joints)

    def posture(self, a: float, b: float) -> Array:
        """Return the joint positions at (a, b), shape (nv,), rad."""
        positions: Array = self.start.copy()
        positions[list(self.joints)] = a, b
        return positions

    def direction(self, a: Array, displacement: Array) -> Array:
        """Return the components of the two joints, shape (..., k, 2)."""
        components: Array = displacement[..., list(self.joints)]
        return components

    def trace(self, positions: Array) -> Array:
        """Return the positions of the two joints, shape (k, 2), angles turned into the range of the axes."""
        columns = list(self.joints)
        middles = np.zeros(self.arm.nv)
        middles[columns] = [(axis.low + axis.high) / 2.0 for axis in (self.horizontal, self.vertical)]
        coordinates: Array = (middles + wrap_angles(self.arm, positions - middles))[:, columns]
        return coordinates


class SelfMotionSlice(Slice):
    """Along the self-motion through a posture, and away from it by one joint."""

    def __init__(self, arm: Arm, q: ArrayLike, joint: str) -> None:
        """Lay the slice through the self-motion of a posture.

        Args:
            arm: The arm, with one redundant degree of freedom.
            q: Joint configuration, shape (nq,), rad.
            joint: Name of the joint that is turned away from where the self-motion has it.

        Raises:
            JointNotFoundError: If there is no such joint; the message lists those that exist.
            AspectControlError: As `self_motion` does.
        """
        self.arm, self.joint = arm, joint_index(arm, joint)
        self.start = arm.positions(q)
        self.curve: SelfMotion = self_motion(arm, q)
        own = _joint_axis(arm, self.joint)
        half = (own.high - own.low) / 2.0 if not own.angle else np.pi
        first, last = float(self.curve.s[0]), float(self.curve.s[-1])
        # A closed curve is cut open opposite to the posture.
        self._cut = last / 2.0 if self.curve.closed else last
        low = self._cut - last if self.curve.closed else first
        self.horizontal = Axis("arc length of the self-motion", low, self._cut, "rad", False)
        self.vertical = Axis(f"{joint} away from the self-motion", -half, half, own.unit, own.angle)

    def posture(self, a: float, b: float) -> Array:
        """Return the joint positions at (a, b), shape (nv,), rad."""
        positions = self.curve.at(a)
        positions[self.joint] += b
        return positions

    def direction(self, a: Array, displacement: Array) -> Array:
        """Return the components along the self-motion and along the joint, shape (..., k, 2)."""
        configurations = [self.arm.configuration(self.curve.at(each)) for each in a]
        tangent = null_vector(np.array([self.arm.jacobian(q) for q in configurations]))
        along, own = np.einsum("...ki,ki->...k", displacement, tangent), displacement[..., self.joint]
        # The two directions of the slice, both of length 1, are not orthogonal.
        cosine = tangent[:, self.joint]
        components = np.stack([along - cosine * own, own - cosine * along], axis=-1)
        result: Array = components / (1.0 - cosine**2)[:, np.newaxis]
        return result

    def trace(self, positions: Array) -> Array:
        """Return the arc length nearest in all other joints, and the distance in the joint, shape (k, 2)."""
        found = np.empty((len(positions), 2))
        for row, posture in enumerate(positions):
            away = wrap_angles(self.arm, posture - self.curve.positions)
            others = np.delete(away, self.joint, axis=1)
            nearest = int(np.linalg.norm(others, axis=1).argmin())
            found[row] = self.curve.s[nearest], away[nearest, self.joint]
        found[found[:, 0] > self._cut, 0] -= self.curve.length
        return found


def joint_index(arm: Arm, name: str) -> int:
    """Return the index of a joint.

    Raises:
        JointNotFoundError: If there is no such joint; the message lists those that exist.
    """
    return arm.joint_names.index(known_name(name, arm.joint_names, error=JointNotFoundError, context=arm.name))


def _joint_axis(arm: Arm, joint: int) -> Axis:
    lower, upper = (float(bound[joint]) for bound in sampling_range(arm))
    if arm.prismatic[joint]:
        return Axis(arm.joint_names[joint], lower, upper, "m", False)
    if upper - lower >= 2.0 * np.pi:
        lower, upper = -np.pi, np.pi
    return Axis(arm.joint_names[joint], lower, upper, "rad", True)


def _most_sign_changing_joints(arm: Arm, base: Array) -> tuple[str, str]:
    """Return the two joints that change the signs of most minors when each is moved through its range by itself."""
    if arm.nv < 2:
        raise ParameterError(f"a slice needs two joints, {arm.name!r} has {arm.nv}")
    changes = []
    for joint in range(arm.nv):
        postures = np.tile(base, (_SWEEP, 1))
        postures[:, joint] = _joint_axis(arm, joint).centres(_SWEEP)
        values = minors(np.array([jacobian(arm, each) for each in postures]), arm.minor_columns)
        clear = np.abs(values) > 1e-9 * arm.minor_scales
        changes.append(np.count_nonzero(np.any((values > 0) & clear, axis=0) & np.any((values < 0) & clear, axis=0)))
    first, second = sorted(np.argsort(-np.array(changes), kind="stable")[:2])
    return arm.joint_names[first], arm.joint_names[second]
