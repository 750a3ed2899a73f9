"""The minors of an arm's task: which of them say something about the aspect, and how large they get."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..checks import read_only
from ..exceptions import TooManyMinorsError
from ..redundancy import MAX_MINORS, Array, minors, structural_minor_columns
from .joint_coordinates import JointCoordinates
from .kinematics import Kinematics

BORDER_TOLERANCE = 1e-6
"""Part of its own scale up to which a minor counts as zero at the start of a motion."""

_SAMPLED_POSTURES = 32
"""Random postures in which a minor must vanish to count as structurally zero."""


class TaskMinors:
    """The minors of the Jacobian that are not structurally zero, and their scales."""

    def __init__(self, joints: JointCoordinates, kinematics: Kinematics, task_dim: int) -> None:
        """Set the joint coordinates, what gives the Jacobian, and the number m of its rows."""
        self._joints = joints
        self._kinematics = kinematics
        self._task_dim = task_dim

    @property
    def columns(self) -> NDArray[np.intp]:
        """Columns of the minors that are not structurally zero, shape (p, m).

        A minor is structurally zero if it vanishes in every posture, as one does that uses a joint which cannot move
        the task at all. Such minors say nothing about the aspect.

        Raises:
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        return self._sample[0]

    @property
    def scales(self) -> Array:
        """Largest magnitude of each minor of `columns` in a sample of random postures, shape (p,).

        Raises:
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        return self._sample[1]

    @cached_property
    def _sample(self) -> tuple[NDArray[np.intp], Array]:
        nv = self._joints.nv
        number = math.comb(nv, self._task_dim)
        if number > MAX_MINORS:
            raise TooManyMinorsError(
                f"a task of {self._task_dim} coordinates on {nv} joints has "
                f"{number:,} minors; at most {MAX_MINORS:,} are computed, for each is a "
                f"determinant at every sample: lock joints or take a task of fewer coordinates"
            )
        postures = np.random.default_rng(0).uniform(-np.pi, np.pi, (_SAMPLED_POSTURES, nv))
        jacobians = np.array([self._kinematics.jacobian(self._joints.configuration(each)) for each in postures])
        columns = structural_minor_columns(jacobians)
        return read_only(columns), read_only(np.abs(minors(jacobians, columns)).max(axis=0))

    def on_border(self, q: ArrayLike) -> NDArray[np.intp]:
        """Return which minors of `columns` are zero at q for practical purposes, as indices, shape (any,).

        Zero is `BORDER_TOLERANCE` times the minor's own scale, or less: at the start of a motion such a minor has no
        sign to keep.

        Args:
            q: Joint configuration, shape (nq,), rad.

        Raises:
            ShapeError: If q has the wrong shape.
            NonFiniteError: If q holds NaN or infinity.
            TooManyMinorsError: If the Jacobian has more minors than can be handled.
        """
        values = minors(self._kinematics.jacobian(q), self.columns)
        return np.flatnonzero(np.abs(values) <= BORDER_TOLERANCE * self.scales)

    def describe(self, indices: Sequence[int] | NDArray[np.intp]) -> str:
        """Name minors of `columns` by their number, counted from 1, and by their joints."""
        columns = [[self._joints.joint_names[column] for column in sorted(self.columns[i])] for i in indices]
        return "; ".join(f"{i + 1} ({', '.join(names)})" for i, names in zip(indices, columns, strict=True))
