"""The quadratic program of one sample: the torques that a task leaves open, the limits on them, and a minimum of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...redundancy.array import Array, Matrix, Vector
from ...redundancy.kernels import kernel
from ...redundancy.pseudoinverse import RANK_TOLERANCE

if TYPE_CHECKING:
    import qpsolvers

TASK_WEIGHT = 1e6
"""Weight of the task beside the other costs: so large that the task gives way to limits alone."""

SELF_MOTION_COST = 10.0
"""Cost of the self-motion beside that of the torque, in units of the mean inertia of a joint."""

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

    def program(self) -> Program:
        """Return the program of these limits."""
        return Program(*program_of_rows(*self))


class Program(NamedTuple):
    """Minimise ½ xᵀ diag(p) x + qᵀx over x = (ζ, σ) subject to lower ≤ A x ≤ upper.

    Attributes:
        p: Diagonal of the cost matrix, shape (r + 1,), above zero.
        q: Linear cost, shape (r + 1,).
        A: Rows of the inequalities, shape (c, r + 1); the last is that of σ alone.
        lower: Lower bounds, shape (c,); minus infinity for none.
        upper: Upper bounds, shape (c,); infinity for none.
    """

    p: Array
    q: Array
    A: Array
    lower: Array
    upper: Array

    def problem(self) -> qpsolvers.Problem:
        """Return it in the form of qpsolvers, with a row of G for every finite bound: the upper ones, then the lower."""
        import qpsolvers

        above, below = np.isfinite(self.upper), np.isfinite(self.lower)
        G = np.vstack((self.A[above], -self.A[below]))
        h = np.concatenate((self.upper[above], -self.lower[below]))
        return qpsolvers.Problem(np.diag(self.p), self.q.copy(), G, h)


@kernel
def open_torques(
    M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, damping: float
) -> tuple[Matrix, Vector, Vector]:
    """Return B, c and d: the torques of the task accelerations s b are τ = B ζ + s c + d, whatever ζ is.

    With Z an orthonormal basis of the null space of J, which has n − m columns at the loss of rank as well, the null-space
    accelerations are θ̈_H + D θ̇_H = Z z. In ζ = R z, with RᵀR = Zᵀ(M² + ρ M)Z, the cost of `QPTorque` is ½‖ζ‖² but for
    a constant.

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
    m = len(J)
    U, S, Vt = np.linalg.svd(J, True)
    kept = S > RANK_TOLERANCE * S[0]
    J_pinv = Vt[:m].T @ (U / np.where(kept, S, np.inf)).T
    Z = np.ascontiguousarray(Vt[m:].T)
    task, damped = M @ (J_pinv @ b), nle - damping * (M @ (v - J_pinv @ (J @ v)))
    weighted, k = M @ Z, len(M)
    both = np.zeros((2 * k, k - m))
    both[:k] = weighted
    if damping > 0.0:
        both[k:] = np.sqrt(SELF_MOTION_COST * np.trace(M) / k) * (np.linalg.cholesky(M).T @ Z)
    R = np.linalg.qr(both)[1]
    B = np.ascontiguousarray(np.linalg.solve(R.T, weighted.T).T)
    return B, task - B @ (B.T @ task), damped - B @ (B.T @ damped)


@kernel
def program_of_rows(A: Matrix, g: Vector, lower: Vector, upper: Vector) -> tuple[Vector, Vector, Matrix, Vector, Vector]:
    """Return p, q, A, lower and upper of `Program` for the limits lower ≤ A ζ + s g ≤ upper, 0 ≤ s ≤ 1.

    σ is s times the largest |g|, so that it stands beside ζ as its like, N m.

    Args:
        A: Shape (c, r).
        g: Shape (c,), N m.
        lower: Shape (c,), N m.
        upper: Shape (c,), N m.
    """
    c, r = A.shape
    unit = max(1.0, np.max(np.abs(g)))
    sizes = np.abs(np.concatenate((lower, upper, g)))
    p, q = np.ones(r + 1), np.zeros(r + 1)
    q[r] = -TASK_WEIGHT * np.max(np.where(np.isfinite(sizes), sizes, 1.0))
    wide, below, above = np.zeros((c + 1, r + 1)), np.zeros(c + 1), np.full(c + 1, unit)
    wide[:c, :r], wide[:c, r], wide[c, r] = A, g / unit, 1.0
    below[:c], above[:c] = lower, upper
    return p, q, wide, below, above


@kernel
def minimum_on_bounds(
    p: Vector, q: Vector, A: Matrix, lower: Vector, upper: Vector, side: Vector
) -> tuple[Vector, float]:
    """Return the minimum of a program with some rows held at a bound, and by how much it is none without.

    [P Wᵀ; W 0] (x, μ) = (−q, bounds held), with W the rows that are held. The cost is strictly convex: x is the only
    minimum if it is within all bounds and no μ pulls towards the bound that it holds.

    Args:
        p: See `Program`.
        q: See `Program`.
        A: See `Program`.
        lower: See `Program`.
        upper: See `Program`.
        side: Positive where the upper bound is held, negative where the lower, zero where neither is, shape (c,).

    Returns:
        x, shape (r + 1,), and the largest violation of a bound or of the sign of a multiplier, relative to its size.

    Raises:
        numpy.linalg.LinAlgError: If the rows that are held depend on each other.
    """
    k, held = len(p), np.flatnonzero(side)
    W, sign, size = A[held], np.sign(side[held]), k + len(held)
    K, right = np.zeros((size, size)), np.zeros(size)
    K[:k, :k], K[:k, k:], K[k:, :k] = np.diag(p), W.T, W
    right[:k], right[k:] = -q, np.where(sign > 0.0, upper[held], lower[held])
    solution = np.linalg.solve(K, right)
    # The large linear cost would leave its rounding in ζ.
    solution += np.linalg.solve(K, right - K @ solution)
    x, mu, values = solution[:k].copy(), solution[k:], A @ solution[:k]
    excess = np.max(np.maximum(lower - values, values - upper) / (1.0 + np.abs(values)))
    wrong_sign = 0.0
    if size > k:
        # The largest multiplier, the price of the task, is the measure of rounding alone.
        wrong_sign = np.max(-sign * mu) / (1.0 + np.max(np.abs(p * x)) + 1e-6 * np.max(np.abs(mu)))
    return x, max(excess, wrong_sign)


@kernel
def torque_on_bounds(
    M: Matrix, nle: Vector, J: Matrix, b: Vector, v: Vector, damping: float, limit: Vector, side: Vector
) -> Vector:
    """Return τ of the program with torque limits alone if no bound or those given hold its minimum.

    Args:
        M: See `open_torques`.
        nle: See `open_torques`.
        J: See `open_torques`.
        b: See `open_torques`.
        v: See `open_torques`.
        damping: See `open_torques`.
        limit: τ_max, shape (n,), N m.
        side: See `minimum_on_bounds`, shape (n + 1,).

    Returns:
        τ, shape (n,), N m; then s, and 1 if no bound holds the minimum, 0 if those given do, −1 if τ is not the torque.
    """
    B, c, d = open_torques(M, nle, J, b, v, damping)
    n, r = B.shape
    tau = np.ones(n + 2)
    tau[:n] = c + d
    if np.all(np.abs(tau[:n]) <= limit):
        return tau
    p, q, A, lower, upper = program_of_rows(B, c, -limit - d, limit - d)
    x, violation = minimum_on_bounds(p, q, A, lower, upper, side)
    s = x[r] / upper[n]
    tau[:n], tau[n] = np.minimum(np.maximum(B @ x[:r] + s * c + d, -limit), limit), s
    tau[n + 1] = 0.0 if violation <= TOLERANCE else -1.0
    return tau
