"""Small dense quadratic programs, their answers and their solvers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..redundancy import Array
from ..redundancy.compiled import prepared
from ..redundancy.quadratic_program import minimum_known, violations

if TYPE_CHECKING:
    import qpsolvers

TOLERANCE = 1e-6
"""By how much a solution may miss a bound, the stationarity or the duality: part of its size, plus 1e-6."""

NO_LIMIT = "no limit in the way, no solver called"
"""Message where the minimum is within all bounds."""

SAME_LIMITS = "held by the limits of the last solution, no solver called"
"""Message where the bounds that were reached before give the minimum."""


class Program(NamedTuple):
    """Minimise ½ xᵀ diag(p) x + qᵀx subject to lower ≤ A x ≤ upper.

    Attributes:
        p: Diagonal of the cost matrix, shape (k,), above zero.
        q: Linear cost, shape (k,).
        A: Rows of the inequalities, shape (c, k).
        lower: Lower bounds, shape (c,); minus infinity for none.
        upper: Upper bounds, shape (c,); infinity for none.
    """

    p: Array
    q: Array
    A: Array
    lower: Array
    upper: Array

    def problem(self) -> qpsolvers.Problem:
        """Return it in the form of qpsolvers: P, q, G, h, with a row of G for every finite bound."""
        import qpsolvers

        above, below = np.isfinite(self.upper), np.isfinite(self.lower)
        G = np.vstack((self.A[above], -self.A[below]))
        h = np.concatenate((self.upper[above], -self.lower[below]))
        return qpsolvers.Problem(np.diag(self.p), self.q.copy(), *((G, h) if len(h) else (None, None)))


class Answer(NamedTuple):
    """What a solver says.

    Attributes:
        x: The solution, shape (k,); None if it found none.
        multipliers: One a row of A, shape (c,): positive at the upper bound, negative at the lower.
        message: The solver's own words, or the reason why there is no solution.
        iterations: How many it took, if known.
        infeasible: Whether the solver is sure that there is no solution.
        least: Whether x is claimed to minimise the whole cost; otherwise the linear part of it only.
    """

    x: Array | None
    multipliers: Array
    message: str
    iterations: int | None
    infeasible: bool = False
    least: bool = True

    def objection(self, program: Program) -> str:
        """Return why this is not the solution of a program, empty if it is.

        Checked to `TOLERANCE` are the bounds, P x + q + Aᵀμ = 0, and that each multiplier μ is of a bound that is
        reached: the conditions for the minimum, so that an old solution is not taken for a new one.

        Args:
            program: The program.
        """
        x, mu = self.x, self.multipliers
        if x is None:
            return self.message
        if x.shape != program.q.shape or mu.shape != program.upper.shape:
            return f"{self.message}, but its solution is not of this program"
        p = program.p if self.least else np.zeros_like(program.p)
        _, q, A, lower, upper = program
        excess, stationarity, gap = violations(p, q, A, lower, upper, x, mu)
        if excess <= TOLERANCE and stationarity <= TOLERANCE and gap <= TOLERANCE:
            return ""
        if not (np.isfinite(x).all() and np.isfinite(mu).all()):
            return f"{self.message}, but its solution is not finite"
        if excess > TOLERANCE:
            return f"{self.message}, but its solution breaks a limit by {excess:.1e}"
        return f"{self.message}, but its solution is not optimal: {stationarity:.1e}, {gap:.1e}"


class Solver(ABC):
    """Solves programs, one after the other, and begins with the bounds that held the solution before.

    Where no bound is in the way of the minimum, or the bounds that held the solution of the last program of the same
    shape hold this one as well, the conditions for the minimum say so, and nothing is left to search for.
    """

    def __init__(self) -> None:
        """Begin without a solution before."""
        self._multipliers: dict[tuple[int, ...], Array] = {}
        self._minimum_known = prepared(minimum_known)
        # Called by `Answer.objection`.
        prepared(violations)

    def solve(self, program: Program) -> Answer:
        """Return the solution that the last one leads to or else the solver's answer.

        It may raise whatever the solver raises.
        """
        return self.known(program) or self.searched(program)

    def searched(self, program: Program) -> Answer:
        """Return the solver's answer, and keep its multipliers; it may raise whatever the solver raises."""
        answer = self.search(program)
        if answer.x is not None and answer.least:
            self._multipliers[program.A.shape] = answer.multipliers
        return answer

    def known(self, program: Program) -> Answer | None:
        """Return the solution that the last one leads to, if it does."""
        known, x, multipliers = self._minimum_known(*program, self.multipliers(program.A.shape))
        return Answer(x, multipliers, SAME_LIMITS if multipliers.any() else NO_LIMIT, 0) if known else None

    def multipliers(self, shape: tuple[int, ...]) -> Array:
        """Return those of the last program with A of a shape that the solver was called for, shape (c,)."""
        before = self._multipliers.get(shape)
        if before is None:
            before = self._multipliers[shape] = np.zeros(shape[0])
        return before

    @abstractmethod
    def search(self, program: Program) -> Answer:
        """Return the solver's answer; it may raise whatever the solver raises."""

    def forget(self) -> None:
        """Forget what is kept between calls, so that equal programs have equal answers."""
        self.forget_multipliers()

    def forget_multipliers(self) -> None:
        """Forget which bounds were reached, but nothing of the solver's own."""
        self._multipliers.clear()


def multipliers_of_rows(program: Program, of_bounds: Array) -> Array:
    """Return one multiplier a row, given those of `Program.problem`, one a finite bound."""
    above, below = np.isfinite(program.upper), np.isfinite(program.lower)
    count = int(np.count_nonzero(above))
    multipliers = np.zeros(len(program.A))
    multipliers[above] += of_bounds[:count]
    multipliers[below] -= of_bounds[count:]
    return multipliers
