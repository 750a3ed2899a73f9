"""The artificial potential of obstacles: stay away from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..arm import Arm, ArmState
from ..checks import positive
from ..exceptions import ParameterError, UndefinedCriterionError
from ..redundancy import Array, repulsive_potential
from .criterion import Criterion
from .obstacles import Box, Obstacle, Sphere, obstacles_of

MAX_POINTS = 10_000
"""The most points of an arm that are kept away from obstacles: each is looked at at every sample."""


class Potential(Criterion):
    """H = −Σ ½(1/ρ − 1/ρ₀)² over points of the arm and obstacles with ρ < ρ₀: the artificial potential, negative.

    The points lie on the straight lines that join the origins of neighbouring joints and the task frame, a `spacing`
    apart; those that no joint can move are left out. ρ is the distance of a point from the surface of an obstacle: give
    obstacles that are larger by half the thickness of the links. Within a tenth of ρ₀ the potential goes on as its
    tangent, so that H stays finite and points outwards even inside an obstacle.

    O. Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", International Journal of Robotics
    Research 5 (1986), with unit gain: the law's κ is the gain.

    Attributes:
        spheres: The spheres.
        boxes: The boxes.
        influence: ρ₀, m.
        spacing: Largest distance between neighbouring points, m.
    """

    name = "potential"

    def __init__(
        self,
        arm: Arm,
        *,
        spheres: Iterable[Sphere | Mapping[str, Any]] = (),
        boxes: Iterable[Box | Mapping[str, Any]] = (),
        influence: float = 0.2,
        spacing: float = 0.05,
    ) -> None:
        """Set the arm and the obstacles.

        Args:
            arm: The arm.
            spheres: Spheres, or mappings with `centre` and `radius`.
            boxes: Boxes, or mappings with `centre`, `size` and, optionally, `rpy`.
            influence: Distance ρ₀ within which an obstacle repels, m.
            spacing: Largest distance between neighbouring points of the arm, m.

        Raises:
            ParameterError: If there is no obstacle, one has no size, a distance is not above zero, or the spacing would
                make more than `MAX_POINTS` points.
            UnknownNameError: If a mapping has a field that the obstacle has not.
            ShapeError: If a centre, a size or an orientation has not three entries.
            NonFiniteError: If an entry is not finite.
        """
        super().__init__(arm)
        self.spheres = obstacles_of(Sphere, "spheres", spheres)
        self.boxes = obstacles_of(Box, "boxes", boxes)
        if not self.spheres and not self.boxes:
            raise ParameterError(f"{self.name!r} needs at least one obstacle: give spheres or boxes")
        self.influence = positive("influence", influence, "m")
        self.spacing = positive("spacing", spacing, "m")
        self._weights = self._point_weights()

    @property
    def parameters(self) -> dict[str, Any]:
        """The obstacles as dicts, the influence distance and the spacing; see `Criterion.parameters`."""
        return {
            "spheres": [_plain(sphere) for sphere in self.spheres],
            "boxes": [_plain(box) for box in self.boxes],
            "influence": self.influence,
            "spacing": self.spacing,
        }

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The spheres, then the boxes."""
        return (*self.spheres, *self.boxes)

    def points(self, q: Array) -> Array:
        """Return the points of the arm that are kept away from the obstacles, shape (k, 3), m, world frame."""
        points: Array = self._weights @ self.arm.skeleton(q)
        return points

    def clearance(self, q: Array) -> Array:
        """Return the distance of the nearest point from each obstacle, m, negative inside, shape (obstacles,)."""
        points = self.points(q)
        return np.array([obstacle.distance(points)[0].min() for obstacle in self.obstacles])

    def start(self, q: Array) -> None:
        """Make sure that the arm is outside of all obstacles at q, shape (nq,), rad.

        Raises:
            UndefinedCriterionError: If a point of it is on or inside an obstacle.
        """
        points, names = self.points(q), (*self.arm.joint_names, self.arm.frame)
        for obstacle in self.obstacles:
            distance, _ = obstacle.distance(points)
            nearest = int(distance.argmin())
            if distance[nearest] <= 0.0:
                link = " and ".join(repr(names[i]) for i in np.flatnonzero(self._weights[nearest]))
                raise UndefinedCriterionError(
                    f"{self.name!r} is not defined at the start: the arm at {link} is "
                    f"{-distance[nearest]:.3g} m inside of {obstacle}"
                )

    def value(self, state: ArmState) -> float:
        """Return H ≤ 0, m⁻²; zero if no obstacle is within the influence distance."""
        points = self.points(state.q)
        distances = np.array([obstacle.distance(points)[0] for obstacle in self.obstacles])
        return -float(repulsive_potential(distances, self.influence)[0].sum())

    def gradient(self, state: ArmState) -> Array:
        """Return ∇H, shape (nv,), m⁻² per rad."""
        points = self.points(state.q)
        pushes = np.zeros_like(points)
        for obstacle in self.obstacles:
            distance, outward = obstacle.distance(points)
            pushes -= repulsive_potential(distance, self.influence)[1][:, np.newaxis] * outward
        # Jᵀ of all points at once: a point on a link moves with the mean of the link's ends that its weights are.
        gradient: Array = np.einsum("ix,ixk->k", self._weights.T @ pushes, self.arm.skeleton_jacobians(state.q))
        return gradient

    def _point_weights(self) -> Array:
        """Return how the points are made of those of `Arm.skeleton`, shape (k, nv + 1); rows add up to 1."""
        arm = self.arm
        posture = arm.configuration(np.random.default_rng(0).uniform(-1.0, 1.0, arm.nv))
        corners = np.eye(arm.nv + 1)
        lengths = np.linalg.norm(np.diff(arm.skeleton(posture), axis=0), axis=1)
        total = lengths.sum()
        if total / self.spacing > MAX_POINTS:
            raise ParameterError(
                f"a spacing of {self.spacing:g} m makes {total / self.spacing:.3g} points of {total:.3g} m of links; "
                f"at most {MAX_POINTS:,} are followed: give at least {total / MAX_POINTS:.1g} m"
            )
        rows = []
        for i, length in enumerate(lengths):
            shares = np.linspace(0.0, 1.0, int(np.ceil(length / self.spacing - 1e-9)), endpoint=False)
            rows += [(1.0 - share) * corners[i] + share * corners[i + 1] for share in shares]
        weights = np.array([*rows, corners[-1]])
        motion = np.einsum("pi,ixk->pxk", weights, arm.skeleton_jacobians(posture))
        moves = np.abs(motion).max(axis=(1, 2)) > 1e-12
        kept: Array = weights[moves]
        return kept


def _plain(obstacle: Sphere | Box) -> dict[str, Any]:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(obstacle).items()}
