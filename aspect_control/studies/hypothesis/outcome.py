"""What a random run came to, and the definitions that the hypothesis is tested with.

Aspect kept: no minor that has a sign at the start changes it (`analysis.aspect_preserved`).

Reference of a sample: the smallest peak torque among the laws that finish it.

Exploded: the run ended early, by divergence or a lost target, or the largest |τ| of any joint is more than a threshold
times the reference; calm is everything else. A sample that no law finishes has no reference and is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...analysis import aspect_preserved, exploded, minor_zero_crossings
from ...redundancy import Array, manipulability
from ...simulation import Run
from ...simulation.metrics import signed_at_start
from .experiment import Draw, Experiment

THRESHOLDS = (2.0, 3.0, 10.0, 30.0, 100.0)
"""Peak torques over the reference beyond which a run counts as exploded; 2 is also the survey's."""

THRESHOLD = 10.0
"""The threshold that is used where only one is."""


@dataclass(frozen=True)
class Outcome:
    """One law on one sample.

    Attributes:
        law: Label of the law.
        status: How the run ended.
        end: When, s.
        peak_torque: Largest |τ| of any joint, N m.
        peak_ratio: The same over the reference of the sample; None without one.
        aspect_preserved: Whether every minor kept its sign.
        sign_changes: How often a minor changed sign.
        left_at: When the first minor did, s; None if none did.
        margin: Smallest normalised minor, counted positive inside the aspect of the start: the least of
            sign(δ_i(0)) δ_i / scale_i; how near the border came if the aspect was kept, and below zero, how far the arm
            went beyond it, if it was left.
        exploded_at: For each of `THRESHOLDS`, when the torque first passed it, or when the run ended early; None if it
            stayed calm, s.
        manipulability: Smallest w of Eq. (25), in the unit of the minors.
        self_motion: Largest ‖θ̇_H‖, rad/s.
    """

    law: str
    status: str
    end: float
    peak_torque: float
    peak_ratio: float | None
    aspect_preserved: bool
    sign_changes: int
    left_at: float | None
    margin: float
    exploded_at: tuple[float | None, ...]
    manipulability: float
    self_motion: float

    def exploded(self, threshold: float) -> bool:
        """Tell whether the torque exploded.

        Args:
            threshold: Peak torque over the reference beyond which it did.

        Raises:
            ValueError: If the sample has no reference.
        """
        if self.peak_ratio is None:
            raise ValueError("no law finished this sample, so that nothing can be said about its torque")
        return exploded(self.status, self.peak_ratio, threshold)


@dataclass(frozen=True)
class SampleOutcome:
    """All laws on one sample.

    Attributes:
        index: Its number.
        positions: Joint positions at the start, rad (m).
        displacement: From the start of the line to its end, m and rad.
        duration: Duration of the motion, s.
        on_border: Draws that were repeated since the start lay on a border.
        wrong_length: Draws that were repeated since the line was too short or too long.
        reference: Smallest peak torque of the laws that finished, N m; None if none did.
        outcomes: What each law came to.
    """

    index: int
    positions: tuple[float, ...]
    displacement: tuple[float, ...]
    duration: float
    on_border: int
    wrong_length: int
    reference: float | None
    outcomes: tuple[Outcome, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the sample as plain numbers, strings and lists, for JSON."""
        return asdict(self)


def sample_outcome(experiment: Experiment, index: int) -> SampleOutcome:
    """Run every law of an experiment on one sample.

    Args:
        experiment: The experiment.
        index: Number of the sample.
    """
    draw = experiment.draw(index)
    runs = {law: experiment.run(index, law) for law in experiment.laws}
    return describe_sample(experiment, index, draw, runs)


def describe_sample(experiment: Experiment, index: int, draw: Draw, runs: Mapping[str, Run]) -> SampleOutcome:
    """Return what the runs of a sample came to."""
    reference = min((_largest(run).max() for run in runs.values() if run.status == "finished"), default=None)
    return SampleOutcome(
        index=index,
        positions=tuple(experiment.arm.positions(draw.q0).tolist()),
        displacement=tuple(draw.line.displacement.tolist()),
        duration=draw.line.duration,
        on_border=draw.on_border,
        wrong_length=draw.wrong_length,
        reference=None if reference is None else float(reference),
        outcomes=tuple(outcome(law, run, reference) for law, run in runs.items()),
    )


def outcome(law: str, run: Run, reference: float | None) -> Outcome:
    """Return what a run came to.

    Args:
        law: Label of its law.
        run: The run.
        reference: Reference of its sample, N m; None without one.
    """
    peak, crossings, signed = float(_largest(run).max()), minor_zero_crossings(run), signed_at_start(run)
    inside = np.sign(run.minors[0, signed]) * run.minors[:, signed] / run.arm.minor_scales[signed]
    return Outcome(
        law=law,
        status=run.status,
        end=float(run.t[-1]),
        peak_torque=peak,
        peak_ratio=None if reference is None else peak / reference,
        aspect_preserved=aspect_preserved(run),
        sign_changes=len(crossings),
        left_at=crossings[0].time if crossings else None,
        margin=float(inside.min()),
        exploded_at=tuple(_exploded_at(run, reference, threshold) for threshold in THRESHOLDS),
        manipulability=float(manipulability(run.jacobians).min()),
        self_motion=float(np.linalg.norm(run.homogeneous_velocity, axis=1).max()),
    )


def _largest(run: Run) -> Array:
    """Return the largest |τ| of any joint at every sample, shape (k,), N m."""
    largest: Array = np.abs(run.tau).max(axis=1)
    return largest


def _exploded_at(run: Run, reference: float | None, threshold: float) -> float | None:
    if reference is None:
        return None
    beyond = np.flatnonzero(_largest(run) > threshold * reference)
    if len(beyond):
        return float(run.t[beyond[0]])
    return None if run.status == "finished" else float(run.t[-1])
