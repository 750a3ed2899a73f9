"""OSQP for small dense quadratic programs, in a workspace that is kept."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..redundancy import Array
from ..redundancy.compiled import prepared
from ..redundancy.quadratic_program import evened, minimum_on_bounds
from .qp_solver import Answer, Program, Solver, multipliers_of_rows

if TYPE_CHECKING:
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

_GENTLE = 1e-2
"""Part of a linear cost that OSQP is given: it converges slowly on what is nearly a linear program."""


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
        self._evened = prepared(evened)
        prepared(minimum_on_bounds)

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

        P, q, A, lower, upper, coordinates, width, size = self._evened(program.p, q, *program[2:])
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
        at_vertex = weight * multipliers_of_rows(program, -vertex.ineqlin.marginals)
        if least.x is None:
            message += "; a torque of the largest task scale, perhaps not the least"
            return Answer(np.array(vertex.x), at_vertex, message, iterations, least=False)
        # The price of the held row is paid by the linear cost: together they are the multipliers of the whole.
        price, multipliers = max(-float(least.multipliers[-1]), 0.0), least.multipliers.copy()
        multipliers[-1] = max(multipliers[-1], 0.0)
        multipliers += (1.0 - price / weight) * at_vertex
        exact = _polished(program, multipliers, message, iterations)
        return Answer(least.x, multipliers, message, iterations) if exact.objection(program) else exact


def _polished(program: Program, multipliers: Array, message: str, iterations: int) -> Answer:
    """Return the minimum on the bounds that have a multiplier."""
    reached = np.abs(multipliers) > 1e-7 * np.abs(multipliers).max(initial=0.0)
    x, exact = minimum_on_bounds(*program, np.where(reached, multipliers, 0.0))
    return Answer(x, exact, message, iterations)


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
    entries: Array = matrix.T[_lower_indices(len(matrix))]
    return entries


@cache
def _lower_indices(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    # NumPy takes longer to make them than OSQP to solve the program.
    return np.tril_indices(size)
