"""The quadratic program of one sample: the torques that a task leaves open, the limits on them, and a minimum of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...redundancy.array import Array, Matrix, Vector
from ...redundancy.generalized_inverse import RANK_TOLERANCE
from ...redundancy.kernels import kernel

if TYPE_CHECKING:
    import qpsolvers

TASK_WEIGHT = 1e6
"""Weight of the task beside the other costs: so large that the task gives way to limits alone."""

SELF_MOTION_COST = 15.0
"""ρ of the law's cost, in units of the mean inertia of the joints, trace(M)/n."""

TOLERANCE = 1e-9
"""By how much a minimum may miss a bound, or a multiplier its sign, relative to their sizes."""


class Rows(NamedTuple):
    """Limits on the torques of the tasks s b: lower ≤ A ζ + s g ≤ upper; infinite where there is none."""

    A: Array
    g: Array
    lower: Array
    upper: Array

    def unit(self) -> Rows:
        """Return the same limits with rows of A of length 1, those aside that are as good as zero."""
        length = np.linalg.norm(self.A, axis=1)
        factor = 1.0 / np.maximum(length, 1e-3 * length.max()) if length.any() else np.ones(len(length))
        return Rows(self.A * factor[:, None], self.g * factor, self.lower * factor, self.upper * factor)


class Program(NamedTuple):
    """Minimise ½‖x‖² + qᵀx over x = (ζ, σ), shape (r + 1,), subject to lower ≤ A x ≤ upper.

    Attributes:
        q: Linear cost, shape (r + 1,): the weight of σ.
        A: Rows of the inequalities, shape (c, r + 1); the last is that of σ alone.
        lower: Lower bounds, shape (c,); minus infinity for none.
        upper: Upper bounds, shape (c,); infinity for none.
    """

    q: Array
    A: Array
    lower: Array
    upper: Array

    def problem(self) -> qpsolvers.Problem:
        """Return it in the form of qpsolvers, with a row of G for every finite bound, the upper ones first."""
        import qpsolvers

        above, below = np.isfinite(self.upper), np.isfinite(self.lower)
        G = np.vstack((self.A[above], -self.A[below]))
        h = np.concatenate((self.upper[above], -self.lower[below]))
        return qpsolvers.Problem(np.eye(len(self.q)), self.q.copy(), G, h)


@kernel
def null_space_torques(
    M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, damping: float
) -> tuple[Matrix, Vector, Vector]:
    """Return B, c and d: the torques of the task accelerations s b are τ = B ζ + s c + d, whatever ζ is.

    With Z an orthonormal basis of the null space of J, which has n − m columns at the loss of rank as well, the
    null-space accelerations are θ̈_H = Z z. With RᵀR = Zᵀ(M² + ρM)Z and ζ = R z + … the cost of `QPTorque` is ½‖ζ‖² and
    what does not depend on ζ.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).
        v: Joint velocity θ̇, shape (n,), rad/s.
        damping: D, 1/s; 0 for ρ = 0.

    Returns:
        B = M Z R⁻¹, shape (n, n − m); c and d, shapes (n,), N m. τ at ζ = 0 and s = 1 is what minimises the cost.
    """
    m, n = J.shape
    U, singular_values, Vt = np.linalg.svd(J, True)
    kept = np.where(singular_values > RANK_TOLERANCE * singular_values[0], singular_values, np.inf)
    J_pinv = np.ascontiguousarray(Vt[:m].T) @ np.ascontiguousarray((U / kept).T)
    Z = np.ascontiguousarray(Vt[m:].T)
    # τ̃ − D M θ̇_H = s task + damped
    task, damped = M @ (J_pinv @ b), nle - damping * (M @ (v - J_pinv @ (J @ v)))
    MZ = M @ Z
    both_costs = np.zeros((2 * n, n - m))
    both_costs[:n] = MZ
    if damping > 0.0:
        both_costs[n:] = np.sqrt(SELF_MOTION_COST * np.trace(M) / n) * (
            np.ascontiguousarray(np.linalg.cholesky(M).T) @ Z
        )
    B = np.ascontiguousarray(np.linalg.solve(np.linalg.qr(both_costs)[1].T, MZ.T).T)
    return B, task - B @ (B.T @ task), damped - B @ (B.T @ damped)


@kernel
def program_of_rows(A: Matrix, g: Vector, lower: Vector, upper: Vector) -> tuple[Vector, Matrix, Vector, Vector]:
    """Return q, A, lower and upper of `Program` for the limits of `Rows` and 0 ≤ s ≤ 1.

    σ is s times the largest |g|, so that it stands beside ζ as its like, N m.
    """
    c, r = A.shape
    unit = max(1.0, np.max(np.abs(g)))
    sizes = np.abs(np.concatenate((lower, upper, g)))
    q = np.zeros(r + 1)
    q[r] = -TASK_WEIGHT * np.max(np.where(np.isfinite(sizes), sizes, 1.0))
    wide, below, above = np.zeros((c + 1, r + 1)), np.zeros(c + 1), np.full(c + 1, unit)
    wide[:c, :r], wide[:c, r], wide[c, r] = A, g / unit, 1.0
    below[:c], above[:c] = lower, upper
    return q, wide, below, above


@kernel
def minimum_on_bounds(q: Vector, A: Matrix, lower: Vector, upper: Vector, side: Vector) -> tuple[Vector, float]:
    """Return the minimum of a program with some rows held at a bound, and by how much it is none without.

    `side` is positive for a row that is held at its upper bound, negative at the lower, else zero, shape (c,).
    x + q + Wᵀμ = 0 and W x = the bounds held, with W the rows that are held. The cost is strictly convex: x is the only
    minimum of the program if it is within all bounds and no μ pulls towards the bound that it holds.

    Returns:
        x, shape (r + 1,), and the largest violation of a bound or of the sign of a multiplier, relative to its size.

    Raises:
        numpy.linalg.LinAlgError: If the rows that are held depend on each other.
    """
    held = np.flatnonzero(side)
    W, sign, x, violation = A[held], np.sign(side[held]), -q, 0.0
    if len(held) > 0:
        bounds, gram_inv = np.where(sign > 0.0, upper[held], lower[held]), np.linalg.inv(W @ W.T)
        mu = gram_inv @ (W @ x - bounds)
        x = x - W.T @ mu
        # The large linear cost has left its rounding.
        x = x - W.T @ (gram_inv @ (W @ x - bounds))
        violation = float(np.max(-sign * mu) / (1.0 + np.max(np.abs(x)) + 1e-6 * np.max(np.abs(mu))))
    values = A @ x
    return x, max(violation, float(np.max(np.maximum(lower - values, values - upper) / (1.0 + np.abs(values)))))


@kernel
def torque_on_bounds(
    M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, damping: float, limit: Vector, side: Vector
) -> Vector:
    """Return τ of the program with torque limits alone, if no limit or those of `side` are active, in one array.

    The arguments are those of `null_space_torques`, τ_max and `side` of `minimum_on_bounds`.

    Returns:
        1 if no limit is active, 0 if those given are, −1 if τ is not the torque; s; then τ, and B, c and d, row by row.
    """
    B, c, d = null_space_torques(M, nle, J, b, v, damping)
    n, r = B.shape
    s, tau, kind = 1.0, c + d, 1.0
    if not np.all(np.abs(tau) <= limit):
        q, A, lower, upper = program_of_rows(B, c, -limit - d, limit - d)
        x, violation = minimum_on_bounds(q, A, lower, upper, side)
        s, kind = float(x[r] / upper[n]), 0.0 if violation <= TOLERANCE else -1.0
        tau = np.minimum(np.maximum(B @ x[:r] + s * c + d, -limit), limit)
    return np.concatenate((np.array([kind, s]), tau, B.reshape(-1), c, d))
