"""The recording of a closed-loop run, and what follows from it for every law alike."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..arm import Arm, ArmState
from ..criteria import Criterion
from ..redundancy import (
    Array,
    aspect_signature,
    border_distance,
    homogeneous_acceleration,
    homogeneous_velocity,
    minimum_torque,
    minor_measure,
    minor_rates,
    minors,
    pseudoinverse_torque,
    task_acceleration,
    time_to_border,
)
from .run_file import ARRAYS, RunInfo, read_run, write_run


@dataclass(frozen=True, eq=False)
class Run:
    """A recorded run of k samples; the torque of a sample is held until the next.

    Everything else is computed from the recording and the arm when it is asked for.

    Attributes:
        t: Times, shape (k,), s.
        q: Joint configurations, shape (k, nq), rad.
        v: Joint velocities, shape (k, nv), rad/s.
        tau: Joint torques, shape (k, nv), N m.
        x_desired: Desired task values, shape (k, m), m; for a task with rotations (k, 7), position and quaternion.
        dx_desired: Desired task velocities, shape (k, m), m/s.
        ddx_desired: Desired task accelerations, shape (k, m), m/s².
        arm: The arm.
        info: How the run came about.
        error: What ended the run as `"interrupted"` or `"failed"`, such as what `watch` raised; None otherwise, and for
            a run from a file.
    """

    t: Array
    q: Array
    v: Array
    tau: Array
    x_desired: Array
    dx_desired: Array
    ddx_desired: Array
    arm: Arm
    info: RunInfo
    error: BaseException | None = None

    @property
    def status(self) -> str:
        """How the run ended: `"finished"`, `"diverged"`, `"interrupted"`, `"failed"` or the status of an event."""
        return self.info.status

    @property
    def message(self) -> str:
        """The status in words, with the time."""
        return self.info.message

    @cached_property
    def x(self) -> Array:
        """Task values, shape (k, m), m; for a task with rotations (k, 7), position and quaternion."""
        coordinates = self.arm.coordinates
        return self._stack((coordinates.encode(self.arm.task_position(q)) for q in self.q), (coordinates.encoded_size,))

    @cached_property
    def task_error(self) -> Array:
        """Task error e = x_d − x as the laws feed it back, shape (k, m), m and rad."""
        task = self.arm.coordinates
        pairs = zip(self.x_desired, self.x, strict=True)
        return self._stack((task.error(task.decode(d), task.decode(x)) for d, x in pairs), (self.arm.task_dim,))

    @cached_property
    def tracking_error(self) -> Array:
        """Distance between the desired and the actual task coordinates: the norm of the position rows of e, (k,), m."""
        error: Array = np.linalg.norm(self.task_error[:, self.arm.coordinates.position_rows], axis=1)
        return error

    @cached_property
    def orientation_error(self) -> Array:
        """Norm of the rotation rows of e, shape (k,), rad; zero for a task of positions."""
        error: Array = np.linalg.norm(self.task_error[:, self.arm.coordinates.rotation_rows], axis=1)
        return error

    @cached_property
    def jacobians(self) -> Array:
        """Jacobians of the task coordinates, shape (k, m, nv)."""
        return self._stack((self.arm.jacobian(q) for q in self.q), (self.arm.task_dim, self.arm.nv))

    @cached_property
    def minors(self) -> Array:
        """Minors in the order of `arm.minor_columns`, which leaves structurally zero ones out, shape (k, p)."""
        return minors(self.jacobians, self.arm.minor_columns)

    @cached_property
    def minor_measure(self) -> Array:
        """H of Eq. (18) of the minors in `minors`, shape (k,), in their unit; zero on a border."""
        return minor_measure(self.jacobians, self.arm.minor_columns)

    @cached_property
    def minor_rates(self) -> Array:
        """Rates δ̇_i of the minors in `minors` at the recorded velocity, shape (k, p), in their unit per s."""
        J_dot = self._stack(
            (self.arm.jacobian_derivative(q) @ v for q, v in zip(self.q, self.v, strict=True)), self.jacobians.shape[1:]
        )
        return minor_rates(self.jacobians, J_dot, self.arm.minor_columns)

    @cached_property
    def border_distance(self) -> Array:
        """Distance to the nearest border of the aspect, min_i |δ_i| / scale_i with `arm.minor_scales`, shape (k,).

        Dimensionless: 0 on a border, of the order of 1 far from all of them.
        """
        return border_distance(self.minors, self.arm.minor_scales)

    @cached_property
    def time_to_border(self) -> Array:
        """Time to the nearest border at the present velocity, the least of −δ_i/δ̇_i where positive, shape (k,), s.

        To first order; 0 on a border, infinite where the arm moves away from all of them.
        """
        return time_to_border(self.minors, self.minor_rates)

    @cached_property
    def aspect_signatures(self) -> NDArray[np.int8]:
        """Sign of each minor: −1, 0 on a border, or 1, shape (k, p)."""
        return aspect_signature(self.jacobians, self.arm.minor_columns)

    def values_of(self, criterion: Criterion) -> Array:
        """Return H of a criterion at every sample, shape (k,), in its own unit.

        Args:
            criterion: A criterion of the arm, such as `criteria.create("joint-range", run.arm)`.
        """
        return self._stack((np.array(criterion.value(state)) for state in self._states), ())

    @cached_property
    def homogeneous_velocity(self) -> Array:
        """Self-motion θ̇_H = (I − J⁺J)θ̇, Eq. (15), shape (k, nv), rad/s."""
        return homogeneous_velocity(self.jacobians, self.v)

    @cached_property
    def pseudoinverse_torque(self) -> Array:
        """τ̃ of Eq. (7) for the task acceleration that the recorded torque brings about, shape (k, nv), N m."""
        return self._stack(
            (pseudoinverse_torque(s.M, s.nle, s.J, b) for s, b in self._states_and_accelerations()), (self.arm.nv,)
        )

    @cached_property
    def homogeneous_acceleration(self) -> Array:
        """(I − J⁺J)θ̈ = M⁻¹(τ − τ̃), the null-space acceleration that the torque brings about, shape (k, nv), rad/s²."""
        rows = zip(self._states, self.tau, self.pseudoinverse_torque, strict=True)
        return self._stack((homogeneous_acceleration(s.M, tau, tilde) for s, tau, tilde in rows), (self.arm.nv,))

    @cached_property
    def maciejewski_product(self) -> Array:
        """θ̇_H·θ̈_H of Eq. (12), with Eqs. (15) and (16), shape (k,), rad²/s³.

        θ̈_H is the null-space acceleration that minimum torque would add at that state, whatever the law: positive
        where it would feed the self-motion. τ̃ in Eq. (16) is the one that gives the task acceleration which the
        recorded torque brings about; for a law of the form of Eq. (5) that is Eq. (7) itself.
        """
        pairs = zip(self._states_and_accelerations(), self.pseudoinverse_torque, strict=True)
        theta_ddot_H = self._stack(
            (
                homogeneous_acceleration(s.M, minimum_torque(s.M, s.nle, s.J, b), tau_tilde)
                for (s, b), tau_tilde in pairs
            ),
            (self.arm.nv,),
        )
        product: Array = np.einsum("ki,ki->k", self.homogeneous_velocity, theta_ddot_H)
        return product

    @cached_property
    def null_space_term_on(self) -> NDArray[np.bool_]:
        """Whether the recorded torque differs from τ̃ of Eq. (7), so that a null-space term acts, shape (k,)."""
        difference = np.linalg.norm(self.tau - self.pseudoinverse_torque, axis=1)
        on: NDArray[np.bool_] = difference > 1e-8 * (1.0 + np.linalg.norm(self.tau, axis=1))
        return on

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the run to a NumPy archive, with the arm, the law, its parameters and the versions used.

        Args:
            path: The file to write, usually ending in `.npz`. No pickle is involved, here or in `load`.

        Raises:
            OutputError: If it cannot be written.
        """
        write_run(path, {name: getattr(self, name) for name in ARRAYS}, self.arm, self.info)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Run:
        """Read a run that `save` wrote; its arrays come back bit for bit.

        Args:
            path: The file.

        Raises:
            RunFileError: If the file is missing, is no recorded run or is damaged.
        """
        arrays, arm, info = read_run(path)
        return cls(**arrays, arm=arm, info=info)  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        """Tell whether two runs hold the same recording, bit for bit, of the same arm and law."""
        if not isinstance(other, Run):
            return NotImplemented
        same = self.arm.description == other.arm.description and self.info == other.info
        return same and all(_identical(self, other, name) for name in ARRAYS)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Name the law, the arm and how the run ended."""
        return f"Run({self.info.controller!r} on {self.arm.name!r}, {len(self.t)} samples, {self.info.message})"

    @cached_property
    def _states(self) -> list[ArmState]:
        return [self.arm.state(q, v) for q, v in zip(self.q, self.v, strict=True)]

    def _states_and_accelerations(self) -> Iterator[tuple[ArmState, Array]]:
        for state, tau in zip(self._states, self.tau, strict=True):
            yield state, task_acceleration(state.M, state.nle, state.J, tau)

    def _stack(self, rows: Iterator[Array], shape: tuple[int, ...]) -> Array:
        return np.array(list(rows)).reshape(len(self.t), *shape)


def _identical(one: Run, other: Run, name: str) -> bool:
    a, b = getattr(one, name), getattr(other, name)
    return bool(a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes())
