"""The arm as ideal rigid bodies, on Pinocchio."""

from __future__ import annotations

import pinocchio as pin
from pinocchio import aba, integrate

from ..arm import Arm
from ..redundancy import Array
from .plant import Plant


class RigidBodyPlant(Plant):
    """Ideal rigid-body dynamics of an arm, by the articulated body algorithm."""

    name = "rigid-body"

    def __init__(self, arm: Arm) -> None:
        """Set the arm, whose model is shared and whose buffers are not.

        Raises:
            ParameterError: If it is no arm.
        """
        super().__init__(arm)
        self._model = arm.model
        self._data = arm.model.createData()

    def acceleration(self, q: Array, v: Array, tau: Array) -> Array:
        """Return θ̈ = M⁻¹(τ − N), shape (nv,), rad/s²; see `Plant.acceleration`."""
        result: Array = aba(self._model, self._data, q, v, tau)
        return result

    def integrate(self, q: Array, displacement: Array) -> Array:
        """Return q ⊕ displacement on the configuration manifold, shape (nq,), rad."""
        result: Array = integrate(self._model, q, displacement)
        return result

    def energy(self, q: Array, v: Array) -> float:
        """Return the kinetic plus the potential energy, J; the potential is zero at the world's origin.

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
        """
        return float(pin.computeMechanicalEnergy(self._model, self._data, q, v))
