"""The pieces of the laws, by several libraries, and how their cost grows."""

from __future__ import annotations

import eigenpy
import numpy as np

from aspect_control.arm import Arm
from aspect_control.redundancy import Array, minimum_torque, minors, null_space_projector, pseudoinverse
from aspect_control.redundancy.gradients import expanded_gradient
from aspect_control.redundancy.laplace import laplace_expansion
from oracles import literal

from . import arms
from .timing import Call, Row, around, interleaved


def arms_timed() -> dict[str, Arm]:
    """Return the arms of this group by name."""
    return {
        "planar 3R, xy": arms.planar(),
        "Panda, xyz": arms.panda(),
        "Panda, pose": arms.panda("pose"),
        "chain of 10, xyz": arms.chain(10),
        "chain of 20, xyz": arms.chain(20),
        "chain of 30, xyz": arms.chain(30),
    }


def _eigenpy_pinv(A: Array) -> Array:
    decomposition = eigenpy.CompleteOrthogonalDecomposition(*A.shape)
    decomposition.setThreshold(1e-9)
    decomposition.compute(A)
    result: Array = decomposition.pseudoInverse().reshape(A.shape[::-1])
    return result


def _cholesky_pinv(J: Array) -> Array:
    from scipy.linalg import cho_factor, cho_solve

    result: Array = cho_solve(cho_factor(J @ J.T), J).T
    return result


def pieces(name: str, arm: Arm, rounds: int) -> list[Row]:
    """Time the pieces on one arm."""
    import scipy.linalg

    states = [sample.state for sample in arms.samples(arm)]
    jacobians = [state.J for state in states]
    identity = np.eye(arm.nv)
    projected = [(state.M @ (identity - np.linalg.pinv(state.J) @ state.J), state) for state in states]
    derivatives = [(state.J, arm.jacobian_derivative(state.q)) for state in states]
    columns = arm.minor_columns
    terms, count = laplace_expansion(columns), len(columns)
    b = np.ones(arm.task_dim)
    groups: dict[str, dict[str, Call]] = {
        "J⁺": {
            "numpy pinv": around(np.linalg.pinv, jacobians),
            "scipy pinv": around(scipy.linalg.pinv, jacobians),
            "eigenpy complete orthogonal": around(_eigenpy_pinv, jacobians),
            "scipy Cholesky solve": around(_cholesky_pinv, jacobians),
            "aspect-control": around(pseudoinverse, jacobians),
        },
        "projector": {
            "numpy pinv": around(lambda J: identity - np.linalg.pinv(J) @ J, jacobians),
            "eigenpy complete orthogonal": around(lambda J: identity - _eigenpy_pinv(J) @ J, jacobians),
            "aspect-control": around(null_space_projector, jacobians),
        },
        "[M(I − J⁺J)]⁺": {
            "numpy pinv": around(lambda pair: np.linalg.pinv(pair[0], rcond=1e-9), projected),
            "scipy pinv": around(lambda pair: scipy.linalg.pinv(pair[0], rtol=1e-9), projected),
            "eigenpy complete orthogonal": around(lambda pair: _eigenpy_pinv(pair[0]), projected),
            "aspect-control, minimum torque without it": around(
                lambda pair: minimum_torque(pair[1].M, pair[1].nle, pair[1].J, b), projected
            ),
        },
        f"all {count:,} minors": {
            "numpy det, one by one": around(lambda J: literal.minors(J, columns), jacobians),
            "aspect-control": around(lambda J: minors(J, columns), jacobians),
        },
        f"∇H of {count:,} minors": {
            "numpy inv, one by one": around(
                lambda pair: literal.minor_measure_gradient(pair[0], pair[1], columns), derivatives
            ),
            "aspect-control": around(lambda pair: expanded_gradient(pair[0], pair[1], terms), derivatives),
        },
    }
    rows = []
    for piece, calls in groups.items():
        seconds = interleaved(calls, rounds)
        first = next(iter(calls))
        rows += [Row(f"{name}: {piece}", each, seconds[each], seconds[first], first) for each in calls]
    return rows
