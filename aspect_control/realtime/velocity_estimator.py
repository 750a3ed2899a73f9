"""Joint velocity from encoder positions, for robots that give none."""

from __future__ import annotations

from math import pi, sqrt, tan

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import finite_vector, positive
from ..exceptions import ParameterError
from ..redundancy import Array


class VelocityEstimator:
    """The difference quotient of the positions through a Butterworth low-pass filter of second order.

    With x_k = (θ_k − θ_{k−1}) / Δt and K = tan(π f Δt), the bilinear transform of the analogue filter of bandwidth f,

    v_k = b (x_k + 2x_{k−1} + x_{k−2}) − a₁ v_{k−1} − a₂ v_{k−2}
    b = K² / d,   a₁ = 2(K² − 1) / d,   a₂ = (1 − √2 K + K²) / d,   d = 1 + √2 K + K²

    A motion that is slow beside f is seen late by Δt (1 / (√2 K) + 1/2), which is about √2 / (2πf) + Δt/2: 5.0 ms at
    50 Hz and 1 kHz. At f the filter lets 1/√2 of the amplitude pass. A lower f means less noise of the encoders and
    more delay, which a law's velocity gain K_v bears up to a small part of 1/K_v.

    Attributes:
        dt: Time between two calls of `update`, Δt, s.
        bandwidth: f, Hz.
    """

    def __init__(self, arm: Arm, dt: float, bandwidth: float = 50.0) -> None:
        """Set the filter.

        Args:
            arm: The arm whose configurations are measured.
            dt: Time between two calls of `update`, s.
            bandwidth: Frequency at which the filter lets 1/√2 of the amplitude pass, Hz; below 1 / (2 dt).

        Raises:
            ParameterError: If dt or the bandwidth is not above zero, or the bandwidth too high.
        """
        self.dt, self.bandwidth, self._arm = positive("dt", dt, "s"), positive("bandwidth", bandwidth, "Hz"), arm
        if bandwidth * dt >= 0.5:
            raise ParameterError(f"bandwidth must be below 1 / (2 dt) = {0.5 / dt:g} Hz, got {bandwidth:g} Hz")
        self._K = K = tan(pi * bandwidth * dt)
        d = 1.0 + sqrt(2.0) * K + K**2
        self._b, self._a1, self._a2 = K**2 / d, 2.0 * (K**2 - 1.0) / d, (1.0 - sqrt(2.0) * K + K**2) / d
        self._begun = False

    @property
    def delay(self) -> float:
        """Time by which a slow motion is seen late, s."""
        return self.dt * (1.0 / (sqrt(2.0) * self._K) + 0.5)

    def reset(self, q: ArrayLike, v: ArrayLike | None = None) -> None:
        """Begin at a configuration.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity that the arm has had for long, shape (nv,), rad/s; None for rest.

        Raises:
            ShapeError: If q or v has the wrong shape.
            NonFiniteError: If q or v is not finite.
        """
        self._q, self._begun = finite_vector("q", q, self._arm.nq), True
        self._x = self._v = np.zeros(self._arm.nv) if v is None else finite_vector("v", v, self._arm.nv)
        self._x_before, self._v_before = self._x, self._v

    def update(self, q: ArrayLike) -> Array:
        """Return the joint velocity, shape (nv,), rad/s, after the next configuration, shape (nq,), rad.

        The first call is a `reset` at rest.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q is not finite.
        """
        q = finite_vector("q", q, self._arm.nq)
        if not self._begun:
            self.reset(q)
        x = self._arm.difference(self._q, q) / self.dt
        v = self._b * (x + 2.0 * self._x + self._x_before) - self._a1 * self._v - self._a2 * self._v_before
        self._q, self._x, self._x_before, self._v, self._v_before = q, x, self._x, v, self._v
        return v.copy()
