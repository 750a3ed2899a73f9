"""What every plant is: an arm that accelerates under a torque."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from ..arm import Arm
from ..exceptions import ParameterError, shown
from ..redundancy import Array


class Plant(ABC):
    """What moves under a torque, in the joint coordinates of an arm.

    Attributes:
        name: Name in the registry; that of the class for a plant that is in none.
        arm: The arm whose joint coordinates q, v and τ are.
    """

    name: ClassVar[str]

    def __init__(self, arm: Arm) -> None:
        """Set the arm.

        Raises:
            ParameterError: If it is no arm.
        """
        if not isinstance(arm, Arm):
            raise ParameterError(f"a plant is made for an Arm, got {shown(arm)}")
        self.arm = arm

    def __init_subclass__(cls) -> None:
        """Name a plant that has no name of its own."""
        super().__init_subclass__()
        if not hasattr(cls, "name"):
            cls.name = cls.__name__

    @abstractmethod
    def acceleration(self, q: Array, v: Array, tau: Array) -> Array:
        """Return θ̈, shape (nv,), rad/s².

        Args:
            q: Joint configuration, shape (nq,), rad.
            v: Joint velocity, shape (nv,), rad/s.
            tau: Joint torque, shape (nv,), N m.
        """

    def integrate(self, q: Array, displacement: Array) -> Array:
        """Return q ⊕ displacement on the configuration manifold, shape (nq,), rad.

        Args:
            q: Joint configuration, shape (nq,), rad.
            displacement: Joint velocity times time, shape (nv,), rad.
        """
        return self.arm.integrate(q, displacement)
