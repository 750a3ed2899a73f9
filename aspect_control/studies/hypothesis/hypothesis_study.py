"""The study that tests the hypothesis on random motions of one arm."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ...checks import positive, whole_number
from ...exceptions import ParameterError
from ...scenario import load_scenario
from ..motions import SHORTEST
from ..study import Study

ABLATION = "jmdc-without-minor-measure"
"""Label of JMDC with κ = 0, which is run besides JMDC."""

ENDINGS = ("diverged", "workspace-left", "tracking-lost")
"""The events that end a run: a torque that is cut off, or a run that ends at a joint limit, cannot explode."""


def hypothesis_study(scenario: str | Path, samples: int, *, seed: int = 0, dt: float = 1e-3) -> Study:
    """Return the study of a scenario's laws, and JMDC with κ = 0 if JMDC is among them, on random lines.

    Args:
        scenario: Name or file of the scenario whose arm, line and laws are taken; see `studies.motions.RandomLines`.
        samples: Number of random motions.
        seed: Seed of the draws.
        dt: Sampling time, s.

    Raises:
        ParameterError: If a number is out of its range, or no line fits the arm.
        ScenarioError: If the scenario's trajectory is no straight line.
        AspectControlError: If the scenario cannot be read, or does not fit the robot.
    """
    laws: list[dict[str, Any]] = [
        section.model_dump(exclude_unset=True) for section in load_scenario(scenario).controllers
    ]
    if any(law["name"] == "jmdc" for law in laws) and all(law.get("label") != ABLATION for law in laws):
        laws.append({"name": "jmdc", "label": ABLATION, "kappa": 0.0})
    study = Study(
        {
            "scenarios": [str(scenario)],
            "motions": {"random": whole_number("samples", samples, 1), "seed": whole_number("seed", seed, 0)},
            "laws": laws,
            "grid": [{"simulation.dt": [positive("dt", dt, "s")]}],
            "endings": list(ENDINGS),
            "saturation": False,
            "report": "hypothesis",
        },
        Path(scenario).stem,
    )
    study.require_buildable()
    shortest = study.setup(study.name).trajectory.duration * math.sqrt(SHORTEST)
    if dt > shortest:
        raise ParameterError(f"dt must not be longer than the shortest motion of {shortest:.3g} s, got {dt:g} s")
    return study
