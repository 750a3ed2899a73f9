"""The classical Runge-Kutta method."""

from __future__ import annotations

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
        h = dt / 2.0
        a1 = plant.acceleration(q, v, tau)
        v2 = v + h * a1
        a2 = plant.acceleration(plant.integrate(q, h * v), v2, tau)
        v3 = v + h * a2
        a3 = plant.acceleration(plant.integrate(q, h * v2), v3, tau)
        v4 = v + dt * a3
        a4 = plant.acceleration(plant.integrate(q, dt * v3), v4, tau)
        displacement = (dt / 6.0) * (v + 2.0 * (v2 + v3) + v4)
        return plant.integrate(q, displacement), v + (dt / 6.0) * (a1 + 2.0 * (a2 + a3) + a4)
