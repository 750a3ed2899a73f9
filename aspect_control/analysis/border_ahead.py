"""A look ahead before a run: does the motion come near the border of its aspect, and when?"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..controllers import Controller
from ..exceptions import AspectBorderWarning, AspectControlError, UndefinedCriterionWarning
from ..simulation import Run, completed, simulate
from ..simulation.metrics import minor_zero_crossings, signed_at_start
from ..trajectories import Trajectory

NEAR = 0.01
"""Part of its own scale below which a minor counts as near zero."""

SAMPLES = 100
"""The fewest steps of a look ahead."""

STEPS_PER_TIME_CONSTANT = 5
"""How finely the feedback is sampled, so that the coarse loop is as stable as the fine one."""


@dataclass(frozen=True)
class BorderAhead:
    """Where a motion leaves its aspect, or comes near its border.

    Attributes:
        minor: Which minor, counted from 1 in the order of `arm.minor_columns`.
        joints: Its number and its joints in words.
        time: When it changes sign, or is smallest, s.
        crossed: Whether it changes sign.
        distance: |δ| / scale there, dimensionless; 0 if it changes sign.
    """

    minor: int
    joints: str
    time: float
    crossed: bool
    distance: float

    def __str__(self) -> str:
        """Say what happens in words."""
        if self.crossed:
            return f"leaves its aspect at t = {self.time:.2f} s, where minor {self.joints} changes sign"
        return (
            f"comes near the border of its aspect at t = {self.time:.2f} s, where minor {self.joints} falls to "
            f"{100.0 * self.distance:.2g} % of its scale"
        )


def preview(
    controller: Controller,
    trajectory: Trajectory,
    *,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    dt: float = 1e-3,
) -> Run:
    """Predict a motion: simulate it with a step that is as coarse as the feedback allows, about a tenth of the work.

    The step is the smaller of duration / `SAMPLES` and a fifth of the time constant of the feedback, 10 ms with the
    gains' defaults. The law itself is evaluated, so that the self-motion which it builds up is part of the prediction;
    integrating θ̇ = J⁺ẋ_d would leave that out. The law is reset; warnings about the start are left to the run itself.

    Args:
        controller: The law, with its arm.
        trajectory: What the task is to do.
        q0: Joint configuration at the start, shape (nq,), rad.
        v0: Joint velocity at the start, shape (nv,), rad/s; None for rest.
        dt: Sampling time of the run to come, s; the step is not shorter.

    Returns:
        The predicted run, with `border_distance`, `minor_measure` and `time_to_border` along it.

    Raises:
        AspectControlError: As `simulate` does.
    """
    feedback = max(np.linalg.norm(controller.kv, 2), np.sqrt(np.linalg.norm(controller.kp, 2)))
    steps_per_second = max(SAMPLES / trajectory.duration, STEPS_PER_TIME_CONSTANT * float(feedback))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AspectBorderWarning)
        warnings.simplefilter("ignore", UndefinedCriterionWarning)
        return completed(simulate(controller, trajectory, q0=q0, v0=v0, dt=max(1.0 / steps_per_second, dt)))


def border_ahead(run: Run, near: float = NEAR) -> BorderAhead | None:
    """Return where a run, predicted or recorded, first leaves its aspect, or else comes nearest to the border.

    Minors that are zero at the start have no sign to keep and are left out.

    Args:
        run: The run.
        near: |δ| / scale from which on a minor is not near zero.

    Returns:
        The first sign change of a minor; if there is none, the smallest minor if it falls below `near`; else None.
    """
    crossings = minor_zero_crossings(run)
    if crossings:
        minor, time = crossings[0]
        return BorderAhead(minor, run.arm.minors.describe([minor - 1]), time, crossed=True, distance=0.0)
    signed = signed_at_start(run)
    distances = np.abs(run.minors[:, signed]) / run.arm.minor_scales[signed]
    if distances.size == 0 or distances.min() >= near:
        return None
    sample, column = np.unravel_index(distances.argmin(), distances.shape)
    index = int(signed[column])
    return BorderAhead(
        index + 1,
        run.arm.minors.describe([index]),
        float(run.t[sample]),
        crossed=False,
        distance=float(distances.min()),
    )


def warn_of_border_ahead(
    controller: Controller,
    trajectory: Trajectory,
    *,
    q0: ArrayLike,
    v0: ArrayLike | None = None,
    dt: float = 1e-3,
    label: str = "",
) -> BorderAhead | None:
    """Predict a motion and issue an `AspectBorderWarning` if it leaves its aspect or comes near its border.

    A prediction that fails gives no warning: the run itself will say why.

    Args:
        controller: As for `preview`.
        trajectory: As for `preview`.
        q0: As for `preview`.
        v0: As for `preview`.
        dt: As for `preview`.
        label: What the law is called in the warning; its registry name unless given.

    Returns:
        What was found, or None.
    """
    try:
        ahead = border_ahead(preview(controller, trajectory, q0=q0, v0=v0, dt=dt))
    except AspectControlError:
        return None
    if ahead is not None:
        warnings.warn(f"{label or controller.name} {ahead}, by a coarse prediction", AspectBorderWarning, stacklevel=2)
    return ahead
