"""The classical Runge-Kutta method."""

from __future__ import annotations

import numpy as np

from ...plants import Plant
from ...redundancy import Array
from .integrator import Integrator


class RungeKutta4(Integrator):
    """The classical fourth-order Runge-Kutta method.

    Displacements of one-degree-of-freedom joints commute, so that adding them up in the tangent space at q
    keeps the order on the configuration manifold too.
    """

    name = "rk4"

    def step(self, plant: Plant, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Return (q, v) after `dt` seconds; see `Integrator.step`."""
        # NumPy multiplies by an array without dimensions in two thirds of the time that it takes for a float.
        whole, half, sixth = np.array(dt), np.array(dt / 2.0), np.array(dt / 6.0)
        a1 = plant.acceleration(q, v, tau)
        v2 = v + half * a1
        a2 = plant.acceleration(plant.integrate(q, half * v), v2, tau)
        v3 = v + half * a2
        a3 = plant.acceleration(plant.integrate(q, half * v2), v3, tau)
        v4 = v + whole * a3
        a4 = plant.acceleration(plant.integrate(q, whole * v3), v4, tau)
        v23, a23 = v2 + v3, a2 + a3
        return plant.integrate(q, sixth * (v + v23 + v23 + v4)), v + sixth * (a1 + a23 + a23 + a4)
