"""The quadratic program of one sample: the torques that a task leaves open, the limits on them, and a minimum of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...redundancy.array import Array, Matrix, Vector
from ...redundancy.kernels import kernel
from ...redundancy.pseudoinverse import pseudoinverse

if TYPE_CHECKING:
    import qpsolvers

TASK_WEIGHT = 1e4
"""Linear cost of the task, in units of the largest bound: so large that the task gives way to limits alone."""

SCALE_CURVATURE = 1e-3
"""Curvature of the cost in σ, which makes the program strictly convex."""

SELF_MOTION = 0.25
"""How fast the self-motion may become for the sake of torque, as part of the motion of the task."""

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
    """Return Q, c and d: the torques of the task accelerations s b are τ = Q ζ + s c + d, whatever ζ is.

    Q is an orthonormal basis of what J M⁻¹ does not see: the end of the square factor of the QR decomposition of M⁻¹Jᵀ,
    which has n − m columns at the loss of rank as well. c + d is the damped torque τ̃ − D M θ̇_H, moved towards the
    minimum torque of Eq. (11) by at most `SELF_MOTION` D ‖M J⁺Jθ̇‖.

    Args:
        M: Joint-space inertia matrix, shape (n, n), kg m².
        nle: Coriolis, centrifugal and gravity torques N, shape (n,), N m.
        J: Jacobian, shape (m, n).
        b: Task acceleration less its velocity part, ẍ − J̇θ̇, shape (m,).
        v: Joint velocity θ̇, shape (n,), rad/s.
        damping: D, 1/s.

    Returns:
        Q, shape (n, n − m), with QᵀQ = I and J M⁻¹Q = 0; c and d, shapes (n,), N m. The torque at ζ = 0 and s = 1 is
        the one that `QPTorque` gives without limits.
    """
    m, n = J.shape
    # Columns of zeros make the factor square: a reflection that has nothing to remove is the identity.
    wide = np.zeros((n, n))
    wide[:, :m] = np.linalg.solve(M, J.T)
    Q = np.ascontiguousarray(np.linalg.qr(wide)[0][:, m:])
    J_pinv = pseudoinverse(J)
    task, of_task = M @ (J_pinv @ b), M @ (J_pinv @ (J @ v))
    damped = nle - damping * (M @ v - of_task)
    share = 1.0
    if damping > 0.0:
        open_part, most = Q.T @ (task + damped), SELF_MOTION * damping * np.sqrt(of_task @ of_task)
        share = most / max(most, np.sqrt(open_part @ open_part), 1e-300)
    return Q, task - share * (Q @ (Q.T @ task)), damped - share * (Q @ (Q.T @ damped))


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
    p[r], q[r] = SCALE_CURVATURE, -TASK_WEIGHT * np.max(np.where(np.isfinite(sizes), sizes, 1.0))
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
        wrong_sign = np.max(-sign * mu) / (1.0 + np.max(np.abs(mu)))
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
    Q, c, d = open_torques(M, nle, J, b, v, damping)
    n, r = Q.shape
    tau = np.ones(n + 2)
    tau[:n] = c + d
    if np.all(np.abs(tau[:n]) <= limit):
        return tau
    p, q, A, lower, upper = program_of_rows(Q, c, -limit - d, limit - d)
    x, violation = minimum_on_bounds(p, q, A, lower, upper, side)
    s = x[r] / upper[n]
    tau[:n], tau[n] = Q @ x[:r] + s * c + d, s
    tau[n + 1] = 0.0 if violation <= TOLERANCE else -1.0
    return tau
