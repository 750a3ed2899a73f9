"""The recording of a closed-loop run, and what follows from it for every law alike."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..arm import Arm
from ..arm.state_samples import StateSamples
from ..criteria import Criterion
from ..redundancy import (
    Array,
    border_distance,
    border_tolerance,
    geometric_mean,
    maciejewski_product,
    minor_rates,
    minor_signs,
    minors,
    null_space_part,
    null_space_rows,
    time_to_border,
)
from .metrics import Metric, metrics_of
from .run_file import ARRAYS, RunInfo, read_run, write_run
from .run_frame import frame_of

if TYPE_CHECKING:
    import pandas as pd


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

    @property
    def x(self) -> Array:
        """Task values, shape (k, m), m; for a task with rotations (k, 7), position and quaternion."""
        return self._samples.x

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

    @property
    def jacobians(self) -> Array:
        """Jacobians of the task coordinates, shape (k, m, nv)."""
        return self._samples.J

    @cached_property
    def minors(self) -> Array:
        """Minors in the order of `arm.minor_columns`, which leaves structurally zero ones out, shape (k, p)."""
        return minors(self.jacobians, self.arm.minor_columns)

    @cached_property
    def minor_measure(self) -> Array:
        """H of Eq. (18) of the minors in `minors`, shape (k,), in their unit; zero on a border."""
        return geometric_mean(self.minors)

    @cached_property
    def manipulability(self) -> Array:
        """W of Eq. (25), shape (k,), in the unit of the minors: by Cauchy and Binet the norm of all minors."""
        w: Array = np.linalg.norm(self.minors, axis=1)
        return w

    @cached_property
    def minor_rates(self) -> Array:
        """Rates δ̇_i of the minors in `minors` at the recorded velocity, shape (k, p), in their unit per s."""
        return minor_rates(self.jacobians, self._samples.dJ, self.arm.minor_columns)

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
        return minor_signs(self.minors, border_tolerance(self.jacobians))

    def values_of(self, criterion: Criterion) -> Array:
        """Return H of a criterion at every sample, shape (k,), in its own unit.

        Args:
            criterion: A criterion of the arm, such as `criteria.create("joint-range", run.arm)`.
        """
        pairs = zip(self.q, self.v, strict=True)
        return self._stack((np.array(criterion.value(self.arm.state(q, v))) for q, v in pairs), ())

    @cached_property
    def homogeneous_velocity(self) -> Array:
        """Self-motion θ̇_H = (I − J⁺J)θ̇, Eq. (15), shape (k, nv), rad/s."""
        return null_space_part(self._null_space, self.v)

    @cached_property
    def self_motion_energy(self) -> Array:
        """Kinetic energy of the self-motion, ½ θ̇_Hᵀ M θ̇_H, shape (k,), J."""
        velocity = self.homogeneous_velocity
        energy: Array = np.einsum("ki,kij,kj->k", velocity, self._samples.M, velocity) / 2.0
        return energy

    @cached_property
    def pseudoinverse_torque(self) -> Array:
        """τ̃ of Eq. (7) for the task acceleration that the recorded torque brings about, shape (k, nv), N m."""
        torque: Array = self.tau - np.einsum("kij,kj->ki", self._samples.M, self.homogeneous_acceleration)
        return torque

    @cached_property
    def homogeneous_acceleration(self) -> Array:
        """(I − J⁺J)θ̈ = M⁻¹(τ − τ̃), the null-space acceleration that the torque brings about, shape (k, nv), rad/s²."""
        return null_space_part(self._null_space, self._acceleration)

    @cached_property
    def maciejewski_product(self) -> Array:
        """θ̇_H·θ̈_H of Eq. (12), with Eqs. (15) and (16), shape (k,), rad²/s³.

        θ̈_H is the null-space acceleration that minimum torque would add at that state, whatever the law: positive
        where it would feed the self-motion. τ̃ in Eq. (16) is the one that gives the task acceleration which the
        recorded torque brings about; for a law of the form of Eq. (5) that is Eq. (7) itself.
        """
        return maciejewski_product(self._null_space, self._samples.M, self.v, self.tau, self._acceleration)

    @cached_property
    def null_space_term_on(self) -> NDArray[np.bool_]:
        """Whether the recorded torque differs from τ̃ of Eq. (7), so that a null-space term acts, shape (k,)."""
        difference = np.linalg.norm(self.tau - self.pseudoinverse_torque, axis=1)
        on: NDArray[np.bool_] = difference > 1e-8 * (1.0 + np.linalg.norm(self.tau, axis=1))
        return on

    def metrics(self) -> dict[str, Metric]:
        """Return the figures of merit of the run, flat: one finite number, word or None each.

        What overflows, as after a divergence, and what does not apply is None.

        Returns:
            In this order: `end` (s, time of the last sample); `samples`; `peak_torque` (largest |τ| of any joint, N m),
            `peak_torque_time` (s) and `peak_torque_joint`; `peak_torque_inside` (the same before the first minor
            changes sign, N m); `torque_squared_integral` (∫‖τ‖²dt, N² m² s); `torque_total_variation` (sum over the
            joints, N m); `peak_speed` (largest |θ̇| of any joint, rad/s); `self_motion_max` (largest ‖θ̇_H‖, rad/s);
            `self_motion_energy_max` (largest ½θ̇_HᵀMθ̇_H, J); `aspect_preserved`; `sign_changes` of minors; `left_at` (s,
            when the first one changes sign); `margin` (least of sign(δ_i(0)) δ_i / scale_i over the minors that have a
            sign at the start, dimensionless: below zero once the aspect is left); `minors_on_border_at_start` (how
            many have none); `minor_measure_min` and `manipulability_min` (in the unit of the minors);
            `border_distance_min` (dimensionless) and `border_distance_min_time` (s); `time_to_border_min` (s);
            `maciejewski_product_max` (rad²/s³) and `maciejewski_product_max_time` (s); `tracking_error_max`,
            `tracking_error_rms` and `tracking_error_end` (m); `orientation_error_max` (rad).

        Raises:
            ParameterError: If the run has no samples.
        """
        return metrics_of(self)

    def to_frame(self) -> pd.DataFrame:
        """Return the run as a tidy pandas `DataFrame`, one row a sample.

        Returns:
            Columns, with JOINT for the names of the joints, AXIS for the task coordinates and NUMBER for the minors,
            counted from 1: `t` (s); `q.JOINT` (rad; m for prismatic joints; in (−π, π] for continuous ones), `v.JOINT`
            (rad/s), `tau.JOINT` (N m); `x.AXIS` and `x_desired.AXIS` (m), for a task with rotations x, y, z and the
            quaternion qx, qy, qz, qw; `dx_desired.AXIS` and `ddx_desired.AXIS` (m/s, rad/s and m/s², rad/s²);
            `minor.NUMBER`, `tracking_error` (m), `orientation_error` (rad), `minor_measure` and `manipulability`
            (in the unit of the minors), `border_distance` (dimensionless), `time_to_border` (s; may be infinite),
            `self_motion` (‖θ̇_H‖, rad/s), `self_motion_energy` (J) and `maciejewski_product` (rad²/s³).
        """
        return frame_of(self)

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
    def _samples(self) -> StateSamples:
        return self.arm.kinematics.state_samples(self.q, self.v)

    @cached_property
    def _null_space(self) -> Array:
        return null_space_rows(self.jacobians)

    @cached_property
    def _acceleration(self) -> Array:
        """Joint acceleration θ̈ = M⁻¹(τ − N) that the torque brings about, shape (k, nv), rad/s²."""
        M, nle = self._samples.M, self._samples.nle
        return np.asarray(np.linalg.solve(M, (self.tau - nle)[..., np.newaxis])[..., 0], dtype=np.float64)

    def _stack(self, rows: Iterator[Array], shape: tuple[int, ...]) -> Array:
        return np.array(list(rows)).reshape(len(self.t), *shape)


def _identical(one: Run, other: Run, name: str) -> bool:
    a, b = getattr(one, name), getattr(other, name)
    return bool(a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes())
