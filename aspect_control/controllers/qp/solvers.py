"""The solvers that the law finds by their names: which bounds hold the minimum of a program."""

from __future__ import annotations

import warnings
from typing import Any, TypeAlias

import numpy as np

from ...checks import known_name
from ...redundancy import Array
from .program import TASK_WEIGHT, Program

OSQP_SETTINGS = {
    "verbose": False,
    "max_iter": 100,
    "check_termination": 20,
    "eps_abs": 1e-7,
    "eps_rel": 1e-7,
    "rho": 100.0,
    "adaptive_rho": 0,
    "scaling": 0,
}
"""OSQP's settings. What it adapts or scales by itself would make an answer depend on the programs before."""

_GENTLE = 1e-4
"""Part of the task's weight that OSQP is given: it converges slowly on what is nearly a linear program."""

_INFINITY = 1e30
"""Bounds beyond this are none to OSQP and to DAQP."""

Answer: TypeAlias = tuple[Array, str, int]
"""The `side` of `minimum_on_bounds`, the solver's own words, and its iterations, 0 if it does not tell."""


class NoSolutionFound(Exception):
    """A solver found no minimum, which its message says in its own words."""


class DAQP:
    """The dual active-set solver DAQP by its own call."""

    name = "daqp"

    def solve(self, program: Program) -> Answer:
        """Return the bounds that hold the minimum, or raise whatever the solver raises."""
        import daqp

        q, A, lower, upper = program
        bounds = np.minimum(upper, _INFINITY), np.maximum(lower, -_INFINITY)
        # It writes to what it is given.
        _, _, flag, info = daqp.solve(np.eye(len(q)), q.copy(), A, *bounds, np.zeros(len(A), np.intc), primal_tol=1e-9)
        if flag < 1:
            raise NoSolutionFound("no solution")
        return info["lam"], "daqp: solved", int(info["iterations"])


class KeptOSQP:
    """OSQP with one workspace: set up once with every entry of A, then updated, and started afresh each time."""

    name = "osqp"

    def __init__(self) -> None:
        """Begin without a workspace."""
        self._workspace: Any = None

    def __getstate__(self) -> dict[str, Any]:
        """Leave the workspace behind: a copy sets up its own."""
        return {"_workspace": None}

    def solve(self, program: Program) -> Answer:
        """Return the bounds that hold the minimum; near it, if the iterations do not suffice."""
        q, A, lower, upper = program
        size = -q[-1] / TASK_WEIGHT
        q, lower, upper = q * (_GENTLE / size), lower / size, upper / size
        if self._workspace is None:
            import osqp
            from scipy.sparse import csc_matrix

            P, pattern = csc_matrix(np.eye(len(q))), csc_matrix(np.ones(A.shape))
            self._workspace = osqp.OSQP()
            self._workspace.setup(P, q, pattern, lower, upper, **OSQP_SETTINGS)
        self._workspace.update(q=q, Ax=A.ravel(order="F"), l=lower, u=upper)
        self._workspace.warm_start(x=np.zeros(len(q)), y=np.zeros(len(A)))
        result = self._workspace.solve(raise_error=False)
        multipliers = np.array(result.y)
        if not np.isfinite(multipliers).all():
            raise NoSolutionFound(result.info.status)
        return _without_rounding(multipliers), f"osqp: {result.info.status}", int(result.info.iter)


class ThroughQpsolvers:
    """Any solver that qpsolvers finds."""

    def __init__(self, name: str) -> None:
        """Set the solver's name among `qpsolvers.available_solvers`."""
        self.name = name

    def solve(self, program: Program) -> Answer:
        """Return the bounds that hold the minimum."""
        import qpsolvers

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(program.problem(), solver=self.name)
        if not solution.found or solution.z is None:
            raise NoSolutionFound("no solution")
        side, above, below = np.zeros(len(program.A)), np.isfinite(program.upper), np.isfinite(program.lower)
        side[above] += solution.z[: np.count_nonzero(above)]
        side[below] -= solution.z[np.count_nonzero(above) :]
        return _without_rounding(side), f"{self.name}: solved", 0


Solver: TypeAlias = DAQP | KeptOSQP | ThroughQpsolvers


def find_solver(name: object) -> Solver:
    """Return a solver by its name.

    Raises:
        UnknownNameError: If it is not installed; the message lists those that are.
    """
    import qpsolvers

    known = known_name(name, sorted(qpsolvers.available_solvers), "QP solver")
    if known == "daqp":
        return DAQP()
    return KeptOSQP() if known == "osqp" else ThroughQpsolvers(known)


def _without_rounding(multipliers: Array) -> Array:
    return np.where(np.abs(multipliers) > 1e-6 * np.abs(multipliers).max(), multipliers, 0.0)
