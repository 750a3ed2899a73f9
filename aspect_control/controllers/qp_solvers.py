"""The solvers that the law finds by their names."""

from __future__ import annotations

import warnings

import numpy as np

from ..exceptions import UnknownNameError
from .qp_osqp import KeptOSQP
from .qp_solver import Answer, Program, Solver, multipliers_of_rows

_NO_BOUND = 1e30
_DAQP_INFEASIBLE = -1


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
        multipliers = multipliers_of_rows(program, bounds) if len(bounds) else np.zeros(len(program.A))
        iterations = solution.extras.get("iterations")
        count_of_iterations = int(np.ravel(iterations)[0]) if iterations is not None else None
        return Answer(np.asarray(solution.x), multipliers, f"{self.name}: solved", count_of_iterations)


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
    if name == "osqp":
        return KeptOSQP()
    return ThroughQpsolvers(str(name))
