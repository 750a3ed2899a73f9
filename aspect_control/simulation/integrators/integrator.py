"""What every integrator is: one step of the plant under a torque that is held."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from ...plants import Plant
from ...redundancy import Array


class Integrator(ABC):
    """Moves the plant on by one sample.

    Attributes:
        name: Name in the registry.
    """

    name: ClassVar[str]

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
