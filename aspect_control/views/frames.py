"""Which runs and which of their samples a moving picture shows, and what it marks on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis import minor_zero_crossings
from ..arm import Arm
from ..checks import positive
from ..exceptions import NonFiniteError, ParameterError
from ..redundancy import Array
from ..simulation import Run
from ..simulation.run_file import ARRAYS
from .style import law_name, plain_text

FRAME_RATE = 30.0
"""Frames a second, whatever the sampling time was."""

MAX_FRAMES = 1_000_000
"""The most frames of a moving picture: at the usual rate more than nine hours of it."""

PLACEHOLDER_LIMIT = 1e5
"""Torque limit from which on a robot's description says none, N m: URDF requires a number, no arm has such a motor."""


def labelled_runs(runs: Run | Iterable[Run] | Mapping[str, Run]) -> dict[str, Run]:
    """Return the runs that a caller wants to see, by their labels.

    Args:
        runs: A run, several, or runs by their labels, which may be registry names of laws. Runs without labels go by
            the names of their laws, those of one law by the parameters that tell them apart as well.

    Raises:
        ParameterError: If there is no run, or something is no run.
    """
    if isinstance(runs, Mapping):
        labels, listed = [law_name(str(label)) for label in runs], list(runs.values())
    elif isinstance(runs, Run):
        labels, listed = [], [runs]
    elif isinstance(runs, Iterable) and not isinstance(runs, str):
        labels, listed = [], list(runs)
    else:
        raise ParameterError(f"expected a Run, several, or runs by their labels, got {runs!r}")
    if not listed:
        raise ParameterError("there are no runs to show; give one Run at least")
    for run in listed:
        if not isinstance(run, Run):
            raise ParameterError(f"expected a Run, got {run!r}; Run.load(path) reads a recorded one")
    return dict(zip(_numbered(labels or _labels(listed)), listed, strict=True))


def finite_samples(run: Run) -> int:
    """Return the number of samples before the first whose q, v or τ is not finite."""
    finite = np.ones(len(run.t), dtype=np.bool_)
    for array in (run.q, run.v, run.tau):
        finite &= np.isfinite(array).all(axis=1)
    return len(finite) if finite.all() else int(finite.argmin())


def finite_part(run: Run) -> Run:
    """Return the run up to its last finite sample.

    Raises:
        ParameterError: If the run has no samples.
        NonFiniteError: If its first sample is not finite.
    """
    samples = finite_samples(run)
    if len(run.t) == 0:
        raise ParameterError(f"{run!r} has no samples; there is nothing to show")
    if samples == 0:
        raise NonFiniteError(f"{run!r} is not finite at its first sample; there is nothing to show")
    if samples == len(run.t):
        return run
    return replace(run, **{name: getattr(run, name)[:samples] for name in ARRAYS})


def frame_times(runs: Sequence[Run], rate: float = FRAME_RATE, speed: float = 1.0) -> Array:
    """Return the times at which runs are shown in step, from the first finite sample to the last of the longest.

    Args:
        runs: The runs, one at least.
        rate: Frames a second of the moving picture, Hz.
        speed: Seconds of motion shown in a second; 0.5 for slow motion.

    Returns:
        Times, shape (any,), s, `speed / rate` apart; the last step is shorter if the motion ends between two frames.

    Raises:
        ParameterError: If `rate` or `speed` is not above zero or makes too many frames, or a run has no samples.
        NonFiniteError: If the first sample of a run is not finite.
    """
    speed, rate = positive("speed", speed), positive("rate", rate, "Hz")
    parts = [finite_part(run) for run in runs]
    start, end = min(float(part.t[0]) for part in parts), max(float(part.t[-1]) for part in parts)
    frames = (end - start) * rate / speed
    if frames > MAX_FRAMES:
        raise ParameterError(
            f"a motion of {end - start:g} s at speed {speed:g} and {rate:g} Hz would have {frames:.3g} frames; "
            f"at most {MAX_FRAMES:,} can be shown"
        )
    steps = int(np.ceil(frames - 1e-6))
    times: Array = np.minimum(start + min(speed / rate, end) * np.arange(steps + 1), end)
    return times


def samples_at(run: Run, times: Array) -> NDArray[np.intp]:
    """Return the sample that holds at each time: the last one not after it, among the finite ones.

    Args:
        run: The run.
        times: Times, shape (f,), s; before the first sample the first one holds, after the last one the last.

    Returns:
        Indices of samples, shape (f,).

    Raises:
        ParameterError: If the run has no samples.
        NonFiniteError: If its first sample is not finite.
    """
    t = finite_part(run).t
    # A frame that is due at a sample shows that sample, however i·dt was rounded.
    indices: NDArray[np.intp] = np.searchsorted(t, times + 1e-6 * run.info.dt, side="right") - 1
    return np.clip(indices, 0, len(t) - 1)


def frame_samples(run: Run, rate: float = FRAME_RATE, speed: float = 1.0) -> NDArray[np.intp]:
    """Return which samples the frames of a run show, uniform in time, from the first to the last finite one.

    A frame shows the sample that holds at its time, so that samples farther apart than frames are shown repeatedly.

    Args:
        run: The run.
        rate: Frames a second of the moving picture, Hz.
        speed: Seconds of motion shown in a second; 0.5 for slow motion.

    Returns:
        Indices of samples, shape (f,), never decreasing.

    Raises:
        ParameterError: If `rate` or `speed` is not above zero, or the run has no samples.
        NonFiniteError: If its first sample is not finite.
    """
    return samples_at(run, frame_times([run], rate, speed))


def aspect_changes(run: Run) -> Array:
    """Return when the aspect signature changes: the times at which minors change sign, shape (j,), s, increasing.

    Minors that have no sign at the start are left out, as in `analysis.minor_zero_crossings`.

    Raises:
        ParameterError: If the run has no samples.
        NonFiniteError: If its first sample is not finite.
        TooManyMinorsError: If the Jacobian has more minors than can be handled.
    """
    return np.unique([crossing.time for crossing in minor_zero_crossings(finite_part(run))])


def torque_ratio(run: Run, reference: Array | None = None) -> Array:
    """Return |τ|/τ_max, shape (k, nv): τ_max is the torque limit of a joint that has one, else the reference.

    Args:
        run: The run.
        reference: What the torques of joints without a limit are compared with, shape (n,), N m, above zero; None for
            `torque_reference` of this run alone.
    """
    reference = torque_reference([run]) if reference is None else reference
    ratio: Array = np.abs(run.tau) / torque_limits(run.arm, reference)
    return ratio


def torque_limits(arm: Arm, reference: Array) -> Array:
    """Return what torques are compared with, shape (nv,), N m: the limit of a joint that has one, else the reference.

    Args:
        arm: The arm; a limit from `PLACEHOLDER_LIMIT` on counts as none.
        reference: For joints without a limit, shape (nv,), N m; see `torque_reference`.
    """
    limits: Array = np.where(_limited(arm), arm.torque_limit, reference)
    return limits


def torque_reference(runs: Sequence[Run]) -> Array:
    """Return what the torques of joints without a limit are compared with, shape (nv,), N m.

    It is the largest |τ| of the calmest run at any joint without a limit, the same for all joints: a calm law stays
    within it, and one whose torque explodes is seen to pass it. A limit from `PLACEHOLDER_LIMIT` on counts as none.

    Args:
        runs: Runs of one arm, one at least.
    """
    free = ~_limited(runs[0].arm)
    peaks = [float(np.abs(run.tau[: finite_samples(run), free]).max(initial=0.0)) for run in runs]
    return np.full(runs[0].arm.nv, min(peaks) or 1.0)


def _limited(arm: Arm) -> NDArray[np.bool_]:
    """Tell which joints have a torque limit, shape (nv,)."""
    limited: NDArray[np.bool_] = arm.torque_limit < PLACEHOLDER_LIMIT
    return limited


def _labels(runs: Sequence[Run]) -> list[str]:
    """Return what runs are called beside one another."""
    return [", ".join([law_name(run.info.controller), *_telling_parameters(run, runs)]) for run in runs]


def _numbered(labels: Sequence[str]) -> list[str]:
    """Return labels with a number where one occurs more than once."""
    return [
        f"{label} ({labels[: i + 1].count(label)})" if labels.count(label) > 1 else label
        for i, label in enumerate(labels)
    ]


def _telling_parameters(run: Run, runs: Sequence[Run]) -> list[str]:
    """Return the parameters that tell a run from others of its law."""
    alike = [other.info.parameters for other in runs if other.info.controller == run.info.controller]
    return [
        plain_text(f"{name} = {_short(value)}")
        for name, value in run.info.parameters.items()
        if any(parameters.get(name) != value for parameters in alike)
    ]


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
