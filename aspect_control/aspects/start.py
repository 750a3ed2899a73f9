"""Choosing the posture from which a motion starts."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import BORDER_TOLERANCE, Arm
from ..arm.postures import jacobian, task_error, wrap_angles, wrap_into_limits
from ..arm.tasks import TaskValue
from ..exceptions import ParameterError, RankLossError
from ..redundancy import Array, minors
from .objective import Criterion, Objective
from .sampling import SelfMotionSample, sample_self_motion, search_box
from .self_motion import SelfMotion, self_motion

_CURVE_SEEDS = 150
"""Random postures from which the curves of one redundant degree of freedom are looked for."""

_SAMPLES = 300
"""Postures that are sampled for several redundant degrees of freedom."""

_SPACING = 0.02
"""Arc length between the samples of a curve, rad."""

_REFERENCE_ERROR = 1e-6
"""How far the reference may be from the task value, m and rad."""

_APART = 0.5
"""How far some joint of two postures must be apart for both to be improved, rad."""

_EQUAL = 1e-6
"""Relative difference up to which two values of the criterion count as equally good."""

_CLIMBS = 25
"""How many of the best postures are improved by constrained optimisation."""


@dataclass(frozen=True, eq=False)
class Start:
    """A posture to start from, and what it is better than.

    Attributes:
        arm: The arm.
        x: The task value.
        criterion: Name of the criterion.
        q: The posture, shape (nq,), rad.
        value: Value of the criterion there.
        reference_q: The posture that it is compared with, shape (nq,), rad.
        reference_value: Value of the criterion there.
        change: How far each joint has to move from the reference, shape (nv,), rad; angles modulo a turn.
        signature: Sign of each minor at q, −1, 0 or 1, shape (p,).
        smallest_minor: The smallest |δ_i| at q as a part of the minor's own scale, `arm.minor_scales`.
        reference_smallest_minor: The same at the reference.
        found: How it was found, in words.
        curves: The self-motion curves that were followed, for one redundant degree of freedom.
        sample: The postures that were sampled, for other arms.
    """

    arm: Arm
    x: TaskValue
    criterion: str
    q: Array
    value: float
    reference_q: Array
    reference_value: float
    change: Array
    signature: tuple[int, ...]
    smallest_minor: float
    reference_smallest_minor: float
    found: str
    curves: tuple[SelfMotion, ...] = ()
    sample: SelfMotionSample | None = None

    @property
    def improvement(self) -> float:
        """By how much the criterion is larger than at the reference, in its own unit."""
        return self.value - self.reference_value

    def to_dict(self) -> dict[str, Any]:
        """Return the choice as plain numbers, strings and lists, for JSON; minors are counted from 1."""
        arm = self.arm
        return {
            "joints": list(arm.joint_names),
            "positions": arm.positions(self.q).tolist(),
            "reference_positions": arm.positions(self.reference_q).tolist(),
            "change": self.change.tolist(),
            "criterion": self.criterion,
            "value": self.value,
            "reference_value": self.reference_value,
            "smallest_minor": self.smallest_minor,
            "reference_smallest_minor": self.reference_smallest_minor,
            "signature": list(self.signature),
            "minors_on_border": (arm.minors_on_border(self.q) + 1).tolist(),
            "minors_on_border_at_reference": (arm.minors_on_border(self.reference_q) + 1).tolist(),
            "found": self.found,
            "self_motions": [curve.to_dict() for curve in self.curves],
            "sampled_signatures": None if self.sample is None else len(self.sample.signatures),
        }


def choose_start(
    arm: Arm,
    x: TaskValue,
    *,
    criterion: Criterion = "minor-measure",
    reference: ArrayLike | None = None,
    within: float = np.inf,
    count: int | None = None,
    seed: int = 0,
) -> Start:
    """Return the posture with a task value that is best by a criterion inside the joint limits.

    With one redundant degree of freedom, all self-motion curves that random postures lead to are followed; with
    several, the postures are sampled. From the best ones SciPy's SLSQP climbs on, with the task value as a constraint
    and the joint limits as bounds.

    Args:
        arm: The arm.
        x: Task value: shape (m,), m, or a `pin.SE3` for a task with rotations.
        criterion: What is to be large: a criterion's name, or a mapping with its `name` and parameters, see `criteria`;
            an object with `value(state)`, and `gradient(state)` if it has one; or a function of the state, which is one
            at rest.
        reference: Joint configuration to compare with, shape (nq,), rad, of the same task value and inside the joint
            limits; None for the first posture found.
        within: How far each joint may be from `reference`, rad; infinite for any distance.
        count: How many random postures to find; None for 150 with one redundant degree of freedom, else 300.
        seed: Seed of the random numbers: the same seed gives the same posture.

    Raises:
        CriterionNotFoundError: If there is no criterion of that name.
        UnreachableError: If no posture has this task value; the message says how near the task frame came.
        ParameterError: If the criterion is none or is nowhere finite, the reference is beyond a joint limit or has
            another task value, or `within`, `count` or `seed` is out of range.
        ShapeError: If x or the reference has the wrong shape.
        NonFiniteError: If x or the reference is not finite.
    """
    x = arm.coordinates.checked("x", x)
    objective = Objective(arm, criterion)
    if reference is None and within != np.inf:
        raise ParameterError("'within' is a distance from 'reference': give both")
    if count is None:
        count = _CURVE_SEEDS if arm.redundancy == 1 else _SAMPLES
    centre = None if reference is None else _reference_positions(arm, x, reference)
    sample = sample_self_motion(arm, x, count=count, seed=seed, near=centre, within=within)
    if centre is None:
        centre = sample.positions[0]
    curves: tuple[SelfMotion, ...] = ()
    postures, found = sample.positions, f"best of {len(sample.positions)} sampled postures"
    if arm.redundancy == 1:
        curves = _curves(arm, x, np.vstack([centre, postures]), min(_SPACING, within / 10.0))
        postures = np.vstack([curve.positions[curve.within_limits] for curve in curves])
        found = f"best of {len(curves)} self-motion curve{'s' * (len(curves) != 1)}"
    postures = np.vstack([centre, _nearest_turns(arm, postures, centre)])
    postures = postures[(np.abs(postures - centre) <= within).all(axis=1)]
    values = np.array([objective.value(each) for each in postures])
    if not np.isfinite(values).any():
        raise ParameterError(f"the criterion is not finite at any of {len(values)} postures with this task value")
    box = search_box(arm, centre, within)
    peaks = [(postures[values.argmax()], float(values.max()))]
    peaks += [objective.climb(each, x, box) for each in _best(postures, values, min(_APART, within / 2.0))]
    best, value = _nearest_of_best(peaks, centre)
    signs = np.where(minor_shares(arm, best) <= BORDER_TOLERANCE, 0.0, np.sign(_minors(arm, best)))
    return Start(
        arm=arm,
        x=x,
        criterion=objective.name,
        q=arm.configuration(best),
        value=value,
        reference_q=arm.configuration(centre),
        reference_value=objective.value(centre),
        change=best - centre,
        signature=tuple(signs.astype(int).tolist()),
        smallest_minor=float(minor_shares(arm, best).min(initial=np.inf)),
        reference_smallest_minor=float(minor_shares(arm, centre).min(initial=np.inf)),
        found=found,
        curves=curves,
        sample=None if curves else sample,
    )


def minor_shares(arm: Arm, positions: Array) -> Array:
    """Return |δ_i| as parts of the minors' own scales, shape (p,).

    Args:
        arm: The arm.
        positions: Joint positions, shape (nv,), rad.
    """
    shares: Array = np.abs(_minors(arm, positions)) / arm.minor_scales
    return shares


def _minors(arm: Arm, positions: Array) -> Array:
    return minors(jacobian(arm, positions), arm.minor_columns)


def _reference_positions(arm: Arm, x: TaskValue, reference: ArrayLike) -> Array:
    q = arm.joints.checked_configuration(reference)
    arm.require_within_limits(q)
    positions = arm.positions(q)
    error = float(np.linalg.norm(task_error(arm, positions, x)))
    if error > _REFERENCE_ERROR:
        raise ParameterError(
            f"the reference posture is {error:.3g} (m, rad) away from the task value: compare with one that has it"
        )
    return positions


def _curves(arm: Arm, x: TaskValue, seeds: Array, spacing: float) -> tuple[SelfMotion, ...]:
    """Return the distinct self-motion curves through postures of one task value."""
    curves: list[SelfMotion] = []
    for seed in seeds:
        if any(_passes(curve, seed) for curve in curves):
            continue
        with suppress(RankLossError):
            curves.append(self_motion(arm, arm.configuration(seed), x=x, spacing=spacing))
    if not curves:
        raise RankLossError("the Jacobian has lost rank at every posture found with this task value")
    return tuple(curves)


def _passes(curve: SelfMotion, positions: Array) -> bool:
    distances = np.linalg.norm(wrap_angles(curve.arm, curve.positions - positions), axis=1)
    return bool(distances.min() < curve.length / (len(curve.s) - 1))


def _nearest_turns(arm: Arm, postures: Array, centre: Array) -> Array:
    """Return the same postures with every angle turned to where it is nearest to `centre`, if the limits allow it."""
    lower, upper = arm.position_limits
    nearest = centre + wrap_angles(arm, postures - centre)
    return np.where((lower <= nearest) & (nearest <= upper), nearest, wrap_into_limits(arm, postures))


def _nearest_of_best(peaks: list[tuple[Array, float]], centre: Array) -> tuple[Array, float]:
    """Return the best peak; of several that are equally good, as mirror images are, the one nearest to `centre`."""
    highest = max(value for _, value in peaks)
    equal = [peak for peak in peaks if peak[1] >= highest - _EQUAL * abs(highest)]
    return min(equal, key=lambda peak: float(np.linalg.norm(peak[0] - centre)))


def _best(postures: Array, values: Array, apart: float) -> list[Array]:
    """Return the best postures of which some joint is `apart`, rad, from every better one, best first."""
    chosen: list[Array] = []
    for index in np.argsort(-values, kind="stable"):
        if len(chosen) == _CLIMBS or not np.isfinite(values[index]):
            break
        if all(np.abs(postures[index] - other).max() > apart for other in chosen):
            chosen.append(postures[index])
    return chosen
