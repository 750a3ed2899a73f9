"""The paper's case: trajectory A on the planar arm, the start, the laws and their settings (Section 4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ... import controllers
from ...analysis.limit import ContinuousLimit, continuous_limit
from ...arm import Arm
from ...resources import model_path
from ...simulation import Run, completed, simulate
from ...trajectories import StraightLine

LAWS = ("pseudoinverse", "null-space-vector", "modified-null-space-vector", "jmdc")
"""The laws that are compared, by registry name."""

DEAD_BEAT = "modified-null-space-vector-dead-beat"
"""What the run of the modified method without chatter is called, which the paper does not have."""

FIGURES = {
    "fig2": ("Fig. 2", "null-space-vector"),
    "fig3": ("Fig. 3", "modified-null-space-vector"),
    "fig4": ("Fig. 4", "jmdc"),
}
"""The paper's figures: file name, heading, and the law shown."""

Q0 = np.deg2rad([-50.0, 140.0, -140.0])
"""The initial configuration, rad."""

TRAJECTORY = StraightLine([1.5, 1.0], duration=2.0, profile="bang-bang")
"""Trajectory A: accelerations ±[1.5, 1.0] m/s² over 1 s each."""

SAMPLING_TIMES = (1e-3, 5e-4, 2.5e-4, 1.25e-4)
"""Sampling times at which the null space vector method is run to see where it converges, s."""


class Reproduction(NamedTuple):
    """The runs of the paper's case.

    Attributes:
        dt: Sampling time, s.
        runs: The run of each law of `LAWS`.
        dead_beat: The modified method with dead-beat switching.
        without_minor_measure: JMDC with κ = 0.
        refined: Null space vector runs at `SAMPLING_TIMES`.
        limit: The null space vector method in continuous time, to which `refined` converges.
    """

    dt: float
    runs: dict[str, Run]
    dead_beat: Run
    without_minor_measure: Run
    refined: list[Run]
    limit: ContinuousLimit

    @property
    def all_runs(self) -> dict[str, Run]:
        """The runs of the paper's laws and of the modified method without chatter, by label."""
        return {**self.runs, DEAD_BEAT: self.dead_beat}


def planar_arm() -> Arm:
    """Return the paper's arm, moving in a horizontal plane: no gravity."""
    return Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0.0, 0.0, 0.0))


def run_law(
    law: str,
    dt: float,
    progress: Callable[[float], None] | None = None,
    *,
    planar: Arm | None = None,
    **parameters: Any,
) -> Run:
    """Run one law on trajectory A.

    Args:
        law: Registry name of the law.
        dt: Sampling time, s.
        progress: As for `simulate`.
        planar: The paper's arm; `planar_arm()` unless given.
        **parameters: The law's parameters, where they are not the defaults.
    """
    controller = controllers.create(law, planar_arm() if planar is None else planar, **parameters)
    return completed(simulate(controller, TRAJECTORY, q0=Q0, dt=dt, progress=progress))


def reproduce(
    dt: float,
    *,
    keep: Callable[[str, Run], None],
    progress: Callable[[str, float], None],
) -> Reproduction:
    """Run everything that the report on the paper's Section 4 needs.

    Args:
        dt: Sampling time of the laws' runs, s.
        keep: Called with the name and the run of each law as soon as it is there.
        progress: Called with what is being done and the part of all work that is done, 0 to 1.
    """
    planar = planar_arm()
    total = 2.0 / dt * (len(LAWS) + 2) + sum(2.0 / finer for finer in SAMPLING_TIMES)
    done = 0.0

    def run(label: str, law: str, dt: float, **parameters: Any) -> Run:
        nonlocal done
        samples = 2.0 / dt
        result = run_law(
            law, dt, lambda part: progress(label, (done + part * samples) / total), planar=planar, **parameters
        )
        done += samples
        return result

    runs = {}
    for law in LAWS:
        runs[law] = run(law, law, dt)
        keep(law, runs[law])
    dead_beat = run(DEAD_BEAT, "modified-null-space-vector", dt, switching="dead-beat")
    keep(DEAD_BEAT, dead_beat)
    without = run("jmdc with κ = 0", "jmdc", dt, kappa=0.0)
    refined = [run(f"null-space-vector at {finer:g} s", "null-space-vector", finer) for finer in SAMPLING_TIMES]
    progress("null-space-vector in continuous time", 1.0)
    limit = continuous_limit(controllers.NullSpaceVector(planar), TRAJECTORY, Q0)
    return Reproduction(dt, runs, dead_beat, without, refined, limit)
