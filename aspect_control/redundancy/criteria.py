"""Performance functions H(q) of the paper's introduction and their gradients, as functions of arrays.

Each is defined so that more is better: a law that follows ∇H climbs it. The manipulability of Eq. (25) and the minor
measure of Eq. (18), which are functions of the minors, stand in `minors`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .array import Array
from .generalized_inverse import RANK_TOLERANCE

CONTACT = 0.1
"""Part of the influence distance below which the repulsive potential goes on as a straight line."""


def joint_range_availability(positions: Array, lower: Array, upper: Array) -> Array:
    """Return H = −(1/n) Σ ((θ_i − θ̄_i) / Δθ_i)²: how far the joints are from the middle of their ranges.

    θ̄_i is the middle of a joint's range and Δθ_i half its width; the sum goes over the n joints that have both limits,
    the others contribute nothing. The function of A. Liégeois, "Automatic supervisory control of the configuration and
    behavior of multibody mechanisms" (1977), with the sign reversed.

    Args:
        positions: Joint positions θ, shape (..., n), rad or m.
        lower: Lower limits, shape (n,), rad or m; infinite for none.
        upper: Upper limits, shape (n,), rad or m; infinite for none.

    Returns:
        H, shape (...), dimensionless: 0 with all joints in the middle, −1 with all joints at a limit.
    """
    offset = _offset_from_middle(positions, lower, upper)
    value: Array = -(offset**2).sum(axis=-1) / max(_limited(lower, upper).sum(), 1)
    return value


def joint_range_availability_gradient(positions: Array, lower: Array, upper: Array) -> Array:
    """Return the gradient of `joint_range_availability`, shape (n,), per rad (per m for a prismatic joint).

    Args:
        positions: Joint positions θ, shape (n,), rad or m.
        lower: As for `joint_range_availability`.
        upper: As for `joint_range_availability`.
    """
    limited = _limited(lower, upper)
    gradient = np.zeros_like(positions)
    half = (upper[limited] - lower[limited]) / 2.0
    gradient[limited] = -2.0 * _offset_from_middle(positions, lower, upper)[limited] / half / max(limited.sum(), 1)
    return gradient


def inverse_condition_number(J: Array) -> Array:
    """Return H = σ_m / σ_1, the smallest over the largest singular value of J: 1 / κ(J).

    The condition number of J. K. Salisbury and J. J. Craig, "Articulated hands: force control and kinematic issues"
    (1982), is to be decreased; its inverse is increased instead, and stays finite at singular poses.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n) with m ≤ n.

    Returns:
        H, shape (...), from 0 at a singular pose to 1 at an isotropic one. It compares the rows of J as they are,
        metres with radians where a task has both.
    """
    sigma = np.linalg.svd(J, compute_uv=False)
    largest = sigma[..., 0]
    ratio: Array = sigma[..., -1] / np.where(largest > 0.0, largest, 1.0)
    return ratio


def inverse_condition_number_gradient(J: Array, dJ: Array) -> Array:
    """Return ∇(σ_m / σ_1), from ∂σ_i/∂q_k = u_iᵀ (∂J/∂q_k) v_i.

    Zero where J has lost rank, where H has a cusp. Where the smallest or the largest singular value is a double one,
    H has a ridge; the result is then the slope of one of its sides.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).

    Returns:
        ∇H, shape (n,), per rad (per m for a prismatic joint). Never NaN.
    """
    U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
    if sigma[-1] <= RANK_TOLERANCE * sigma[0]:
        return np.zeros(J.shape[1])
    d_sigma = np.einsum("is,ijk,sj->sk", U[:, [0, -1]], dJ, Vt[[0, -1]])
    gradient: Array = (d_sigma[1] - sigma[-1] / sigma[0] * d_sigma[0]) / sigma[0]
    return gradient


def velocity_compatibility(J: Array, direction: Array) -> Array:
    """Return H = [uᵀ(JJᵀ)⁻¹u]⁻¹: the square of the velocity transmission ratio along u.

    It is the square of the task speed along u that joint speeds of ‖θ̇‖ = 1 can give. The compatibility index of S. L.
    Chiu, "Task compatibility of manipulator postures" (1988), for fast motion along one direction.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        direction: Unit vector u in task coordinates, shape (m,).

    Returns:
        H, shape (...), m² for positions and revolute joints; zero where the arm cannot move along u.
    """
    U, sigma, _ = np.linalg.svd(J, full_matrices=False)
    weight = np.swapaxes(U, -1, -2) @ direction
    lost = sigma <= RANK_TOLERANCE * sigma[..., :1]
    # A lost direction counts only if u has a part along it; then no speed is possible at all.
    slowness = np.where(
        lost, np.where(np.abs(weight) > RANK_TOLERANCE, np.inf, 0.0), weight / np.where(lost, 1.0, sigma)
    )
    value: Array = 1.0 / (slowness**2).sum(axis=-1)
    return value


def velocity_compatibility_gradient(J: Array, dJ: Array, direction: Array) -> Array:
    """Return the gradient of `velocity_compatibility`: 2 wᵀ(∂J/∂q_k)Jᵀw with w = H (JJᵀ)⁻¹u.

    Zero where the arm cannot move along u.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).
        direction: Unit vector u in task coordinates, shape (m,).

    Returns:
        ∇H, shape (n,), in the unit of H per rad (per m for a prismatic joint). Never NaN.
    """
    U, sigma, _ = np.linalg.svd(J, full_matrices=False)
    weight, kept = U.T @ direction, sigma > RANK_TOLERANCE * sigma[0]
    if not kept.any() or np.any(np.abs(weight[~kept]) > RANK_TOLERANCE):
        return np.zeros(J.shape[1])
    slowness = weight[kept] / sigma[kept]
    w = U[:, kept] @ (slowness / sigma[kept]) / (slowness @ slowness)
    gradient: Array = 2.0 * np.einsum("i,ijk,j->k", w, dJ, J.T @ w)
    return gradient


def force_compatibility(J: Array, direction: Array) -> Array:
    """Return H = [uᵀ(JJᵀ)u]⁻¹: the square of the force transmission ratio along u.

    It is the square of the force along u that joint torques of ‖τ‖ = 1 can hold. The compatibility index of S. L. Chiu,
    "Task compatibility of manipulator postures" (1988), for large forces along one direction.

    Args:
        J: Jacobian or a stack of them, shape (..., m, n).
        direction: Unit vector u in task coordinates, shape (m,).

    Returns:
        H, shape (...), m⁻² for positions and revolute joints; infinite where a force along u needs no torque.
    """
    torque = np.linalg.norm(direction @ J, axis=-1)
    with np.errstate(divide="ignore"):
        value: Array = 1.0 / np.where(_needs_no_torque(J, torque), 0.0, torque) ** 2
    return value


def force_compatibility_gradient(J: Array, dJ: Array, direction: Array) -> Array:
    """Return the gradient of `force_compatibility`: −2H² uᵀ(∂J/∂q_k)Jᵀu.

    Zero where a force along u needs no torque and H is infinite.

    Args:
        J: Jacobian, shape (m, n).
        dJ: Its derivatives dJ[i, j, k] = ∂J[i, j] / ∂q_k, shape (m, n, n).
        direction: Unit vector u in task coordinates, shape (m,).

    Returns:
        ∇H, shape (n,), in the unit of H per rad (per m for a prismatic joint). Never NaN.
    """
    value = force_compatibility(J, direction)
    if np.isinf(value):
        return np.zeros(J.shape[1])
    gradient: Array = -2.0 * value**2 * np.einsum("i,ijk,j->k", direction, dJ, direction @ J)
    return gradient


def repulsive_potential(distance: Array, influence: float) -> tuple[Array, Array]:
    """Return the potential U of obstacles at given distances, and its slope dU/dρ.

    U = ½(1/ρ − 1/ρ₀)² for ρ < ρ₀ and 0 farther away, as in O. Khatib, "Real-time obstacle avoidance for manipulators
    and mobile robots" (1986), with unit gain. Below `CONTACT` ρ₀ it goes on as its tangent, so that it stays finite and
    pushes outwards even for a point that is inside an obstacle (ρ < 0).

    Args:
        distance: Distances ρ, any shape, m; negative inside an obstacle.
        influence: Influence distance ρ₀, m, above zero.

    Returns:
        U, m⁻², and dU/dρ ≤ 0, m⁻³, both of the shape of `distance`.
    """
    nearest = CONTACT * influence
    rho = np.clip(distance, nearest, influence)
    excess = 1.0 / rho - 1.0 / influence
    slope = -excess / rho / rho
    return 0.5 * excess**2 + slope * np.minimum(distance - nearest, 0.0), slope


def sphere_distance(points: Array, centre: Array, radius: float) -> tuple[Array, Array]:
    """Return the distance of points from the surface of a sphere, negative inside, and its gradient.

    Args:
        points: Shape (k, 3), m.
        centre: Shape (3,), m.
        radius: Above zero, m.

    Returns:
        Distances, shape (k,), m, and outward unit vectors, shape (k, 3); along x at the centre itself.
    """
    offset = points - centre
    length = np.linalg.norm(offset, axis=-1)
    at_centre = length == 0.0
    outward = np.where(at_centre[:, np.newaxis], np.eye(3)[0], offset) / np.where(at_centre, 1.0, length)[:, np.newaxis]
    return length - radius, outward


def box_distance(points: Array, centre: Array, rotation: Array, size: Array) -> tuple[Array, Array]:
    """Return the distance of points from the surface of a box, negative inside, and its gradient.

    Args:
        points: Shape (k, 3), m.
        centre: Shape (3,), m.
        rotation: Rotation matrix from the axes of the box to those of the points, shape (3, 3).
        size: Lengths of its edges, shape (3,), above zero, m.

    Returns:
        Distances, shape (k,), m, and outward unit vectors, shape (k, 3), from the nearest point of the surface.
    """
    local = (points - centre) @ rotation
    beyond = np.abs(local) - size / 2.0
    outside = np.maximum(beyond, 0.0)
    length = np.linalg.norm(outside, axis=-1)
    is_inside = length == 0.0
    nearest_face = np.eye(3)[beyond.argmax(axis=-1)]
    outward = np.where(
        is_inside[:, np.newaxis], nearest_face, outside / np.where(is_inside, 1.0, length)[:, np.newaxis]
    )
    distance = np.where(is_inside, beyond.max(axis=-1), length)
    return distance, (outward * np.where(local < 0.0, -1.0, 1.0)) @ rotation.T


def _limited(lower: Array, upper: Array) -> NDArray[np.bool_]:
    return np.isfinite(lower) & np.isfinite(upper)


def _offset_from_middle(positions: Array, lower: Array, upper: Array) -> Array:
    """Return (θ − θ̄) / Δθ, shape (..., n): −1 to 1 between the limits, 0 for joints without."""
    limited = _limited(lower, upper)
    offset = np.zeros_like(positions)
    middle, half = (lower[limited] + upper[limited]) / 2.0, (upper[limited] - lower[limited]) / 2.0
    offset[..., limited] = (positions[..., limited] - middle) / half
    return offset


def _needs_no_torque(J: Array, torque: Array) -> NDArray[np.bool_]:
    none: NDArray[np.bool_] = torque <= RANK_TOLERANCE * np.linalg.norm(J, axis=(-2, -1))
    return none
