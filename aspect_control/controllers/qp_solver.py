"""Solvers of small dense quadratic programs: OSQP in a kept workspace, any other through qpsolvers."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..exceptions import UnknownNameError
from ..redundancy import Array
from ..redundancy.compiled import prepared
from ..redundancy.quadratic_program import evened, minimum_known, minimum_on_bounds, violations

if TYPE_CHECKING:
    import qpsolvers
    from scipy.sparse import csc_matrix

OSQP_SETTINGS = {
    "verbose": False,
    "eps_abs": 1e-7,
    "eps_rel": 1e-7,
    "eps_prim_inf": 1e-9,
    "max_iter": 1000,
    "check_termination": 10,
    "adaptive_rho_interval": 50,
}
"""OSQP's settings. The number of iterations bounds the time of a tick; its own polishing prints."""

TOLERANCE = 1e-6
"""By how much a solution may miss a bound, the stationarity or the duality: part of its size, plus 1e-6."""

NO_LIMIT = "no limit in the way, no solver called"
"""Message where the minimum is within all bounds."""

SAME_LIMITS = "held by the limits of the last solution, no solver called"
"""Message where the bounds that were reached before give the minimum."""

_NO_BOUND = 1e30
_DAQP_INFEASIBLE = -1

_GENTLE = 1e-2
"""Part of a linear cost that OSQP is given: it converges slowly on what is nearly a linear program."""


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

    def solve(self, program: Program) -> Answer:
        """Return the solution that the last one leads to or else the solver's answer.

        It may raise whatever the solver raises.
        """
        answer = self.known(program)
        if answer is None:
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


class KeptOSQP(Solver):
    """OSQP with one workspace a shape of program: set up once, then only updated and started from the last solution.

    The workspace holds P and A densely, zeros included, so that their pattern stays the same. OSQP sees the program in
    coordinates in which the bounds are about equally far apart in all directions, says which of them are reached, and
    the linear equations of those bounds make the solution exact. Where that fails on a program with a linear cost,
    HiGHS minimises that cost alone, and OSQP the quadratic one at that minimum.
    """

    def __init__(self) -> None:
        """Begin without a workspace."""
        super().__init__()
        self._workspaces: dict[tuple[int, ...], Any] = {}

    def forget(self) -> None:
        """Drop the workspaces."""
        super().forget()
        self._workspaces.clear()

    def search(self, program: Program) -> Answer:
        """Return OSQP's answer."""
        answer = self._solve(program, _GENTLE * program.q)
        if answer.x is None and not answer.infeasible and program.q.any():
            return self._in_two_steps(program, answer)
        return answer

    def _solve(self, program: Program, q: Array) -> Answer:
        import osqp

        P, q, A, lower, upper, coordinates, width, size = evened(program.p, q, *program[2:])
        workspace = self._workspaces.get(A.shape)
        if workspace is None:
            workspace = self._workspaces[A.shape] = osqp.OSQP()
            workspace.setup(_dense_pattern(P, upper=True), q, _dense_pattern(A), lower, upper, **OSQP_SETTINGS)
        else:
            workspace.update(Px=_upper_triangle(P), q=q, Ax=A.ravel(order="F"), l=lower, u=upper)
        result = workspace.solve(raise_error=False)
        message, iterations = f"osqp: {result.info.status}", int(result.info.iter)
        if result.info.status_val == osqp.SolverStatus.OSQP_SOLVED:
            answer = _polished(program, np.array(result.y) * size / width, message, iterations)
            if not answer.objection(program):
                return answer
            x, multipliers = coordinates @ np.array(result.x), np.array(result.y) * size / width
            answer = Answer(x, multipliers, message, iterations)
            objection = answer.objection(program)
            return answer if not objection else Answer(None, multipliers, objection, iterations)
        infeasible = result.info.status_val == osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE
        if not infeasible and not program.q.any() and np.isfinite(result.y).all():
            # It may have found out which bounds are reached even so.
            answer = _polished(program, np.array(result.y) * size / width, message, iterations)
            if not answer.objection(program):
                return answer
        return Answer(None, np.zeros(len(A)), message, iterations, infeasible)

    def _in_two_steps(self, program: Program, before: Answer) -> Answer:
        """Minimise qᵀx by HiGHS, then ½ xᵀPx where qᵀx is least; q has its last entry only, and so has the last row."""
        from scipy.optimize import linprog

        weight, problem = -float(program.q[-1]), program.problem()
        vertex = linprog(program.q / weight, A_ub=problem.G, b_ub=problem.h, bounds=(None, None), method="highs")
        message = f"{before.message}; highs: {'optimal' if vertex.x is not None else vertex.message}"
        if vertex.x is None:
            return before._replace(message=message)
        best = float(vertex.x[-1])
        held = program.lower.copy()
        held[-1] = max(held[-1], best - 1e-9 * (1.0 + abs(best)))
        least = self._solve(program._replace(q=np.zeros_like(program.q), lower=held), np.zeros_like(program.q))
        message, iterations = f"{message}; {least.message}", (before.iterations or 0) + (least.iterations or 0)
        at_vertex = weight * _of_rows(program, -vertex.ineqlin.marginals)
        if least.x is None:
            message += "; a torque of the largest task scale, perhaps not the least"
            return Answer(np.array(vertex.x), at_vertex, message, iterations, least=False)
        # The price of the held row is paid by the linear cost: together they are the multipliers of the whole.
        price, multipliers = max(-float(least.multipliers[-1]), 0.0), least.multipliers.copy()
        multipliers[-1] = max(multipliers[-1], 0.0)
        multipliers += (1.0 - price / weight) * at_vertex
        exact = _polished(program, multipliers, message, iterations)
        return Answer(least.x, multipliers, message, iterations) if exact.objection(program) else exact


class DAQP(Solver):
    """The dual active-set solver DAQP by its own call, which takes both bounds of a row as they are."""

    def search(self, program: Program) -> Answer:
        """Return the solver's answer."""
        import daqp

        p, q, A, lower, upper = program
        if len(A) == 0:
            return Answer(-q / p, np.zeros(0), "daqp: no limits", 0)
        # DAQP takes bounds beyond 1e30 for none, and writes to what it is given.
        bounds = np.minimum(upper, _NO_BOUND), np.maximum(lower, -_NO_BOUND)
        sense = np.zeros(len(A), dtype=np.intc)
        x, _, flag, info = daqp.solve(np.diag(p), q.copy(), np.ascontiguousarray(A), *bounds, sense)
        iterations = int(info["iterations"])
        if flag < 1:
            return Answer(None, np.zeros(len(A)), "daqp: no solution", iterations, flag == _DAQP_INFEASIBLE)
        return Answer(np.array(x), np.array(info["lam"]), "daqp: solved", iterations)


class ThroughQpsolvers(Solver):
    """Any solver that qpsolvers finds."""

    def __init__(self, name: str) -> None:
        """Set the solver's name among `qpsolvers.available_solvers`."""
        super().__init__()
        self.name = name

    def search(self, program: Program) -> Answer:
        """Return the solver's answer."""
        import qpsolvers

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(program.problem(), solver=self.name)
        if not solution.found or solution.x is None:
            return Answer(None, np.zeros(len(program.A)), f"{self.name}: no solution", None)
        bounds = solution.z if solution.z is not None and len(solution.z) else np.zeros(0)
        multipliers = _of_rows(program, bounds) if len(bounds) else np.zeros(len(program.A))
        iterations = solution.extras.get("iterations")
        count_of_iterations = int(np.ravel(iterations)[0]) if iterations is not None else None
        return Answer(np.asarray(solution.x), multipliers, f"{self.name}: solved", count_of_iterations)


def _polished(program: Program, multipliers: Array, message: str, iterations: int) -> Answer:
    """Return the minimum on the bounds that have a multiplier."""
    reached = np.abs(multipliers) > 1e-7 * np.abs(multipliers).max(initial=0.0)
    x, exact = minimum_on_bounds(*program, np.where(reached, multipliers, 0.0))
    return Answer(x, exact, message, iterations)


def _of_rows(program: Program, of_bounds: Array) -> Array:
    """Return one multiplier a row, given those of `Program.problem`, one a finite bound."""
    above, below = np.isfinite(program.upper), np.isfinite(program.lower)
    count = int(np.count_nonzero(above))
    multipliers = np.zeros(len(program.A))
    multipliers[above] += of_bounds[:count]
    multipliers[below] -= of_bounds[count:]
    return multipliers


def find_solver(name: object) -> Solver:
    """Return a solver by its name.

    Raises:
        UnknownNameError: If it is not installed; the message lists those that are.
    """
    import qpsolvers

    if name not in qpsolvers.available_solvers:
        raise UnknownNameError(name, sorted(qpsolvers.available_solvers), kind="QP solver")
    if name == "daqp":
        return DAQP()
    return KeptOSQP() if name == "osqp" else ThroughQpsolvers(str(name))


def _dense_pattern(matrix: Array, *, upper: bool = False) -> csc_matrix:
    """Return a sparse matrix with every entry stored, zeros too, or every entry of the upper triangle."""
    from scipy.sparse import csc_matrix

    rows, columns = matrix.shape
    if upper:
        indices = np.concatenate([np.arange(column + 1) for column in range(columns)])
        starts = np.cumsum(np.arange(columns + 1))
        return csc_matrix((_upper_triangle(matrix), indices, starts), shape=matrix.shape)
    indices = np.tile(np.arange(rows), columns)
    return csc_matrix((matrix.ravel(order="F"), indices, rows * np.arange(columns + 1)), shape=matrix.shape)


def _upper_triangle(matrix: Array) -> Array:
    """Return the entries on and above the diagonal, column by column."""
    entries: Array = matrix.T[np.tril_indices(len(matrix))]
    return entries
