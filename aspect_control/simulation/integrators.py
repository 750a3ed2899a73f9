"""Integrators: one step of the plant under a torque that is held."""

from __future__ import annotations

from abc import ABC, abstractmethod

from ..checks import known_name
from ..plants import Plant
from ..redundancy import Array


class Integrator(ABC):
    """Moves the plant on by one sample.

    Attributes:
        name: Name under which `simulate` finds it.
    """

    name: str

    @abstractmethod
    def step(self, plant: Plant, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Return (q, v) after `dt` seconds under the constant torque `tau`.

        Args:
            plant: The plant.
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
            tau: Joint torque, shape (nv,), N m.
            dt: Time, s.
        """


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


class SemiImplicitEuler(Integrator):
    """The symplectic Euler method of first order: the new velocity moves the configuration."""

    name = "semi-implicit-euler"

    def step(self, plant: Plant, q: Array, v: Array, tau: Array, dt: float) -> tuple[Array, Array]:
        """Return (q, v) after `dt` seconds; see `Integrator.step`."""
        v = v + dt * plant.acceleration(q, v, tau)
        return plant.integrate(q, dt * v), v


INTEGRATORS: dict[str, type[Integrator]] = {law.name: law for law in (RungeKutta4, SemiImplicitEuler)}
"""Integrators by name."""


def find_integrator(integrator: str | Integrator) -> Integrator:
    """Return the integrator of that name, or the integrator itself.

    Raises:
        UnknownNameError: If there is none of that name.
    """
    if isinstance(integrator, Integrator):
        return integrator
    return INTEGRATORS[known_name(integrator, INTEGRATORS, "integrator")]()
