"""The solvers that the law finds by their names: which bounds hold the minimum of a program."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from ...exceptions import UnknownNameError
from ...redundancy import Array
from .program import TASK_WEIGHT, Program

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

OSQP_SETTINGS = {
    "verbose": False,
    "max_iter": 200,
    "check_termination": 20,
    "eps_abs": 1e-7,
    "eps_rel": 1e-7,
    "rho": 10.0,
    "adaptive_rho": 0,
    "scaling": 0,
}
"""OSQP's settings. What it adapts or scales by itself would make an answer depend on the programs before."""

_GENTLE = 1e-5
"""Part of the task's weight that OSQP is given: it converges slowly on what is nearly a linear program."""

_INFINITY = 1e30
"""Bounds beyond this are none to OSQP and to DAQP."""


class Answer(NamedTuple):
    """What a solver found.

    Attributes:
        side: Positive for a row whose upper bound holds the minimum, negative for the lower, zero for neither, shape
            (c,).
        message: The solver's own words.
        iterations: How many it took; 0 if it does not tell.
    """

    side: Array
    message: str
    iterations: int


class NoSolutionFound(Exception):  # noqa: N818
    """A solver found no minimum, which its message says in its own words."""


class Solver(Protocol):
    """Solves programs, each without regard to those before."""

    def solve(self, program: Program) -> Answer:
        """Return the bounds that hold the minimum.

        Raises:
            NoSolutionFound: If the solver finds none; it may raise whatever it raises besides.
        """


class DAQP:
    """The dual active-set solver DAQP by its own call."""

    def solve(self, program: Program) -> Answer:
        """Return the bounds that hold the minimum."""
        import daqp

        p, q, A, lower, upper = program
        bounds = np.minimum(upper, _INFINITY), np.maximum(lower, -_INFINITY)
        # It writes to what it is given.
        _, _, flag, info = daqp.solve(np.diag(p), q.copy(), A, *bounds, np.zeros(len(A), np.intc), primal_tol=1e-9)
        if flag < 1:
            raise NoSolutionFound("daqp: no solution")
        return Answer(info["lam"], "daqp: solved", int(info["iterations"]))


class KeptOSQP:
    """OSQP with one workspace, set up once and then updated, and started afresh for every program.

    The workspace holds A densely, zeros included, so that its pattern stays the same.
    """

    def __init__(self) -> None:
        """Begin without a workspace."""
        self._workspace: Any = None

    def __getstate__(self) -> dict[str, Any]:
        """Leave the workspace behind: a copy sets up its own."""
        return {"_workspace": None}

    def solve(self, program: Program) -> Answer:
        """Return the bounds that hold the minimum; near it, if the iterations do not suffice."""
        import osqp
        from scipy.sparse import csc_matrix

        p, q, A, lower, upper = program
        size = -q[-1] / TASK_WEIGHT
        q = q * (_GENTLE / size)
        lower, upper = lower / size, upper / size
        if self._workspace is None:
            self._workspace = osqp.OSQP()
            self._workspace.setup(csc_matrix(np.diag(p)), q, _dense(A), lower, upper, **OSQP_SETTINGS)
        else:
            self._workspace.update(q=q, Ax=A.ravel(order="F"), l=lower, u=upper)
            self._workspace.warm_start(x=np.zeros(len(q)), y=np.zeros(len(A)))
        result = self._workspace.solve(raise_error=False)
        message, iterations = f"osqp: {result.info.status}", int(result.info.iter)
        multipliers = np.array(result.y)
        if not np.isfinite(multipliers).all():
            raise NoSolutionFound(message)
        return Answer(_without_rounding(multipliers), message, iterations)


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
            raise NoSolutionFound(f"{self.name}: no solution")
        side, above, below = np.zeros(len(program.A)), np.isfinite(program.upper), np.isfinite(program.lower)
        count = int(np.count_nonzero(above))
        side[above] += solution.z[:count]
        side[below] -= solution.z[count:]
        return Answer(_without_rounding(side), f"{self.name}: solved", 0)


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


def _without_rounding(multipliers: Array) -> Array:
    return np.where(np.abs(multipliers) > 1e-6 * np.abs(multipliers).max(), multipliers, 0.0)


def _dense(matrix: Array) -> csc_matrix:
    """Return a sparse matrix with every entry stored, zeros too."""
    from scipy.sparse import csc_matrix

    rows, columns = matrix.shape
    indices, starts = np.tile(np.arange(rows), columns), rows * np.arange(columns + 1)
    return csc_matrix((matrix.ravel(order="F"), indices, starts), shape=matrix.shape)
