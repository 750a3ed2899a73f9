"""The laws as the paper prints them, with `numpy.linalg.pinv` for every pseudoinverse.

The tests hold the results against them, and the benchmark the speed.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from aspect_control import Arm, ArmState, Target
from aspect_control.arm.tasks import AXES
from aspect_control.redundancy import Array

KP, KV, KAPPA, DT, DAMPING = 100.0, 20.0, 0.001, 1e-3, 10.0
"""The defaults of the laws, and a sampling time."""

pinv = np.linalg.pinv


def commanded(arm: Arm, s: ArmState, target: Target, kp: Any = KP, kv: Any = KV) -> Array:
    """ẍ_d + K_v ė + K_p e − J̇θ̇, for gains that are numbers or matrices."""
    if isinstance(s.x, pin.SE3):
        rotation = pin.log3(target.x.rotation @ s.x.rotation.T)
        error = np.concatenate([target.x.translation - s.x.translation, rotation])[[AXES.index(a) for a in arm.task]]
    else:
        error = target.x - s.x
    b: Array = target.ddx + np.dot(kv, target.dx - s.J @ s.v) + np.dot(kp, error) - s.drift
    return b


def least_acceleration_torque(s: ArmState, b: Array) -> Array:
    """τ̃ of Eq. (7) for the task acceleration b, less J̇θ̇."""
    return s.M @ pinv(s.J) @ b + s.nle


def null_space_terms(s: ArmState, b: Array) -> tuple[Array, Array, Array]:
    """τ̃ of Eq. (7), θ̇_H of Eq. (15) and θ̈_H of Eq. (16).

    M(I − J⁺J) has rank n − m: its other singular values are rounding, above `pinv`'s own threshold; those that count
    are at least 1/cond M > 1e-3 of the largest.
    """
    J_pinv = pinv(s.J)
    P = np.eye(len(s.v)) - J_pinv @ s.J
    tau_tilde = s.M @ J_pinv @ b + s.nle
    return tau_tilde, P @ s.v, -pinv(s.M @ P, rcond=1e-9) @ tau_tilde


def pseudoinverse(arm: Arm, s: ArmState, target: Target) -> Array:
    """Eq. (7)."""
    return least_acceleration_torque(s, commanded(arm, s, target))


def null_space_vector(arm: Arm, s: ArmState, target: Target) -> Array:
    """Eq. (11)."""
    tau_tilde, _, theta_ddot_H = null_space_terms(s, commanded(arm, s, target))
    return tau_tilde + s.M @ theta_ddot_H


def modified_null_space_vector(arm: Arm, s: ArmState, target: Target) -> Array:
    """Eqs. (12) to (16)."""
    tau_tilde, theta_dot_H, theta_ddot_H = null_space_terms(s, commanded(arm, s, target))
    return tau_tilde + s.M @ theta_ddot_H if theta_dot_H @ theta_ddot_H < 0.0 else tau_tilde


def jmdc(arm: Arm, s: ArmState, target: Target) -> Array:
    """Eqs. (17) to (21) at a start: every minor by itself, its gradient by its inverse."""
    J_pinv, identity = pinv(s.J), np.eye(arm.nv)
    gradient = minor_measure_gradient(s.J, arm.jacobian_derivative(s.q), arm.minor_columns)
    v_d = J_pinv @ target.dx + KAPPA * (identity - J_pinv @ s.J) @ gradient
    tau: Array = s.M @ ((v_d - s.v) / DT + KV * (v_d - s.v)) + s.nle
    return tau


def damped_null_space(arm: Arm, s: ArmState, target: Target) -> Array:
    """Eq. (7) with the self-motion of Eq. (15) damped."""
    J_pinv = pinv(s.J)
    theta_dot_H = (np.eye(arm.nv) - J_pinv @ s.J) @ s.v
    tau: Array = s.M @ J_pinv @ commanded(arm, s, target) + s.nle - DAMPING * s.M @ theta_dot_H
    return tau


def inertia_weighted(arm: Arm, s: ArmState, target: Target) -> Array:
    """The inertia-weighted pseudoinverse."""
    tau: Array = s.J.T @ pinv(s.J @ np.linalg.inv(s.M) @ s.J.T) @ commanded(arm, s, target) + s.nle
    return tau


def operational_space(arm: Arm, s: ArmState, target: Target) -> Array:
    """Operational-space control with a damping torque in the dynamically consistent null space."""
    M_inv = np.linalg.inv(s.M)
    Lambda = pinv(s.J @ M_inv @ s.J.T)
    J_bar = M_inv @ s.J.T @ Lambda
    null_space = np.eye(arm.nv) - s.J.T @ J_bar.T
    tau: Array = s.J.T @ Lambda @ commanded(arm, s, target) + s.nle + null_space @ (-DAMPING * s.M @ s.v)
    return tau


def minors(J: Array, columns: Any) -> Array:
    """Every minor of some columns, one determinant after the other."""
    return np.array([np.linalg.det(J[:, each]) for each in columns])


def minor_measure_gradient(J: Array, dJ: Array, columns: Any) -> Array:
    """∇H by ∂ ln|δ_S| / ∂q_k = tr(J_S⁻¹ ∂J_S/∂q_k), one inverse a minor."""
    logarithm, gradient = 0.0, np.zeros(J.shape[1])
    for each in columns:
        logarithm += np.log(abs(np.linalg.det(J[:, each])))
        gradient += np.einsum("ji,ijk->k", np.linalg.inv(J[:, each]), dJ[:, each])
    result: Array = np.exp(logarithm / len(columns)) / len(columns) * gradient
    return result


def all_minors(n: int, m: int) -> NDArray[np.intp]:
    """Columns of all minors in lexicographic order, shape (p, m)."""
    return np.array(list(combinations(range(n), m)))


LAWS: dict[str, tuple[Callable[[Arm, ArmState, Target], Array], int, int]] = {
    "pseudoinverse": (pseudoinverse, 1, 1),
    "null-space-vector": (null_space_vector, 2, 1),
    "modified-null-space-vector": (modified_null_space_vector, 2, 2),
    "jmdc": (jmdc, 1, 1),
    "damped-null-space": (damped_null_space, 1, 1),
    "inertia-weighted": (inertia_weighted, 1, 1),
    "operational-space": (operational_space, 1, 1),
}
"""The literal laws, the pseudoinverses that a tick of each takes, and those that the project's tick takes."""


class Printed:
    """The matrices and torques of the paper's and the textbook's equations at one state."""

    def __init__(self, arm: Arm, q: Array, v: Array, target: Target, kp: Any = KP, kv: Any = KV) -> None:
        s = arm.state(q, v)
        self.M, self.N, self.J, self.v = s.M, s.nle, s.J, v
        self.b = commanded(arm, s, target, kp, kv)
        self.J_pinv = pinv(s.J)
        self.P = np.eye(arm.nv) - self.J_pinv @ s.J
        self.M_inv = np.linalg.inv(s.M)
        self.Lambda = np.linalg.inv(s.J @ self.M_inv @ s.J.T)
        self.J_bar = self.M_inv @ s.J.T @ self.Lambda
        self.tau_tilde, self.theta_dot_H, self.theta_ddot_H = null_space_terms(s, self.b)
        self.tau_minimum = self.tau_tilde + s.M @ self.theta_ddot_H
        self.product = self.theta_dot_H @ self.theta_ddot_H

    def task_acceleration(self, tau: Array) -> Array:
        """Jθ̈, the task acceleration less J̇θ̇, under a torque."""
        return self.J @ self.M_inv @ (tau - self.N)
