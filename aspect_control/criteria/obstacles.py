"""Obstacles in the workspace: spheres and boxes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from ..checks import finite_vector, positive
from ..exceptions import ParameterError, UnknownNameError, shown
from ..redundancy import Array, box_distance, sphere_distance


class Obstacle(ABC):
    """A body that stands in the world frame."""

    @abstractmethod
    def distance(self, points: Array) -> tuple[Array, Array]:
        """Return how far points are from the surface, negative inside, and the gradient of that.

        Args:
            points: Shape (k, 3), m.

        Returns:
            Distances, shape (k,), m, and outward unit vectors, shape (k, 3).
        """


@dataclass(frozen=True)
class Sphere(Obstacle):
    """A sphere.

    Attributes:
        centre: x, y, z in the world frame, m.
        radius: m.

    Raises:
        ShapeError: If the centre has not three coordinates.
        NonFiniteError: If one is not finite.
        ParameterError: If the radius is not above zero.
    """

    centre: tuple[float, ...]
    radius: float

    def __post_init__(self) -> None:
        """Check the numbers and keep copies."""
        object.__setattr__(self, "centre", _triple("the centre of a sphere", self.centre))
        object.__setattr__(self, "radius", positive("the radius of a sphere", self.radius, "m"))

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Return distances and outward unit vectors; see `Obstacle.distance`."""
        return sphere_distance(points, np.array(self.centre), self.radius)


@dataclass(frozen=True)
class Box(Obstacle):
    """A box.

    Attributes:
        centre: x, y, z in the world frame, m.
        size: Lengths of its edges, m.
        rpy: Its orientation: roll, pitch and yaw about the fixed axes of the world frame, as in a URDF, rad.

    Raises:
        ShapeError: If one of them has not three entries.
        NonFiniteError: If an entry is not finite.
        ParameterError: If an edge is not longer than zero.
    """

    centre: tuple[float, ...]
    size: tuple[float, ...]
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check the numbers and keep copies."""
        object.__setattr__(self, "centre", _triple("the centre of a box", self.centre))
        object.__setattr__(self, "rpy", _triple("rpy of a box", self.rpy))
        size = _triple("the size of a box", self.size)
        if min(size) <= 0.0:
            raise ParameterError(f"the size of a box must be three lengths above 0 m, got {list(size)}")
        object.__setattr__(self, "size", size)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Return distances and outward unit vectors; see `Obstacle.distance`."""
        rotation = pin.rpy.rpyToMatrix(np.array(self.rpy))
        return box_distance(points, np.array(self.centre), rotation, np.array(self.size))


Kind = TypeVar("Kind", Sphere, Box)


def obstacles_of(kind: type[Kind], name: str, given: Iterable[Kind | Mapping[str, Any]]) -> tuple[Kind, ...]:
    """Return obstacles of one kind from obstacles or tables of their fields.

    Args:
        kind: `Sphere` or `Box`.
        name: What the list is called in errors.
        given: Obstacles, or mappings with their fields.

    Raises:
        ParameterError: If it is no list of these, or a field is missing or has an impossible value.
        UnknownNameError: If a table has a field that the obstacle has not.
        AspectControlError: As the obstacle's constructor does.
    """
    if isinstance(given, (str, Mapping)) or not isinstance(given, Iterable):
        raise ParameterError(f"{name} must be a list of {kind.__name__} or of tables, got {shown(given)}")
    return tuple(_obstacle_of(kind, f"{name}[{i}]", each) for i, each in enumerate(given))


def _obstacle_of(kind: type[Kind], name: str, given: Kind | Mapping[str, Any]) -> Kind:
    if isinstance(given, kind):
        return given
    known = [field.name for field in fields(kind)]
    needed = known[:2]
    if not isinstance(given, Mapping):
        raise ParameterError(
            f"{name} must be a {kind.__name__} or a table with {' and '.join(needed)}, got {shown(given)}"
        )
    for key in given:
        if key not in known:
            raise UnknownNameError(key, known, context=name, kind="field")
    missing = [key for key in needed if key not in given]
    if missing:
        raise ParameterError(f"{name} lacks {' and '.join(missing)}, got {shown(dict(given))}")
    return kind(**given)


def _triple(name: str, value: Any) -> tuple[float, ...]:
    return tuple(finite_vector(name, value, 3).tolist())
