"""The symplectic Euler method."""

from __future__ import annotations

from ...plants import Plant
from ...redundancy import Array
from .integrator import Integrator


class SemiImplicitEuler(Integrator):
    """The symplectic Euler method of first order: the new velocity moves the configuration."""

    name = "semi-implicit-euler"

    def step(self, plant: Plant, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Return (q, v) after `dt` seconds; see `Integrator.step`."""
        v = v + dt * plant.acceleration(q, v, tau)
        return plant.integrate(q, dt * v), v
