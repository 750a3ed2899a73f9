"""The self-motion of a run, and what it does by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arm.postures import require_one_redundant_degree
from ..aspects import stability
from ..redundancy import Array, null_vector
from ..simulation import Run


@dataclass(frozen=True, eq=False)
class SelfMotionOfRun:
    """The self-motion of a recorded run, with its direction.

    Attributes:
        speed: ṡ = z·θ̇, shape (k,), rad/s; its sign is the direction of travel with respect to `null_vector`.
        c: The coefficient in the direction of `null_vector`, shape (k,), 1/rad.
        own_product: −c ṡ³, shape (k,), rad²/s³: the part of θ̇_H·θ̈_H that the self-motion brings about by itself; the
            rest comes with the motion of the task and with gravity.
        own_logarithm: −∫c ṡ dt, shape (k,): by how much ln |ṡ| would have grown since the start by itself.
    """

    speed: Array
    c: Array
    own_product: Array
    own_logarithm: Array


def self_motion_of_run(run: Run) -> SelfMotionOfRun:
    """Return the self-motion of a run of one redundant degree of freedom.

    Args:
        run: The run.

    Raises:
        ParameterError: If there is not exactly one redundant degree of freedom.
    """
    require_one_redundant_degree(run.arm)
    speed: Array = np.einsum("ki,ki->k", null_vector(run.jacobians), run.v)
    c = np.array([stability(run.arm, q) for q in run.q])
    rate = -c * speed
    grown = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2.0 * np.diff(run.t))])
    return SelfMotionOfRun(speed, c, rate * speed**2, grown)
