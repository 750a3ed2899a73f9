"""Maciejewski's condition as a property of configurations: where minimum torque feeds a self-motion, and which way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..arm.postures import require_one_redundant_degree
from ..redundancy import Array, null_vector, null_vector_derivative, stability_coefficient
from .self_motion import SelfMotion


def stability(arm: Arm, q: ArrayLike) -> float:
    """Return c of s̈ = −c ṡ² at a configuration, for travel in the direction of `redundancy.null_vector`.

    Gravity is left out: c is about what the self-motion does by itself. For travel the other way it is −c.

    Args:
        arm: The arm, with one redundant degree of freedom.
        q: Joint configuration, shape (nq,), rad.

    Returns:
        c, 1/rad: minimum torque brakes the self-motion if c > 0 and feeds it if c < 0. At rank loss z has no direction
        and c no meaning.

    Raises:
        ParameterError: If there is not exactly one redundant degree of freedom.
        ShapeError: If q has the wrong shape.
        NonFiniteError: If q is not finite.
    """
    require_one_redundant_degree(arm)
    z = null_vector(arm.jacobian(q))
    moving, resting = arm.state(q, z), arm.state(q, np.zeros(arm.nv))
    return stability_coefficient(moving.M, moving.nle - resting.nle, z, null_vector_derivative(moving.J, moving.drift))


@dataclass(frozen=True, eq=False)
class Growth:
    """How the speed of a free self-motion under minimum torque changes along its curve.

    Attributes:
        s: Arc lengths, shape (k,), rad, as those of the curve.
        c: The coefficient in the direction of growing s, shape (k,), 1/rad.
        logarithm: ln(|ṡ(s)| / |ṡ(0)|) = −∫c ds, shape (k,): the same function of the place for both directions of
            travel, for c and ds both change sign.
        closed: Whether the curve is closed.
    """

    s: Array
    c: Array
    logarithm: Array
    closed: bool

    @property
    def factor(self) -> float:
        """ṡ at the last sample over ṡ at the first: once round a closed curve, the growth of a turn."""
        return float(np.exp(self.logarithm[-1] - self.logarithm[0]))

    @property
    def largest_factor(self) -> float:
        """The most by which |ṡ| grows from one place to another, in either direction and less than once round."""
        if not self.closed:
            return float(np.exp(np.ptp(self.logarithm)))
        turn = self.logarithm[-1] - self.logarithm[0]
        once, count = self.logarithm[:-1], len(self.logarithm) - 1
        twice = np.concatenate([once, once + turn])
        windows = np.lib.stride_tricks.sliding_window_view(twice, count)[:count] - once[:, np.newaxis]
        # Forwards from the first place of a window to any other, or backwards from any other to the first.
        return float(np.exp(np.abs(windows).max()))


def growth(curve: SelfMotion) -> Growth:
    """Return how the speed of a free self-motion changes along its curve: dṡ/ds = −c ṡ.

    Args:
        curve: The self-motion.
    """
    from scipy.interpolate import CubicSpline

    c = np.array([stability(curve.arm, q) for q in curve.q])
    if curve.closed:
        c[-1] = c[0]
    integral = CubicSpline(curve.s, c, bc_type="periodic" if curve.closed else "not-a-knot").antiderivative()
    return Growth(curve.s, c, integral(0.0) - integral(curve.s), curve.closed)
