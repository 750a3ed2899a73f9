"""All laws of the package on the same motions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..analysis import summarize
from ..resources import scenario_paths
from ..scenario import Scenario, load_scenario
from ..simulation import Run

SCENARIOS = ("planar3r", "panda-xyz", "panda-pose", "baxter-xyz")
"""The shipped scenarios on which the laws are compared."""

VARIANTS: dict[str, dict[str, Any]] = {
    "pseudoinverse": {"name": "pseudoinverse"},
    "null-space-vector": {"name": "null-space-vector"},
    "modified-hard": {"name": "modified-null-space-vector"},
    "modified-dead-beat": {"name": "modified-null-space-vector", "switching": "dead-beat"},
    "modified-brake": {"name": "modified-null-space-vector", "switching": "brake"},
    "jmdc": {"name": "jmdc"},
    "resolved-motion": {"name": "resolved-motion"},
    "damped-null-space": {"name": "damped-null-space"},
    "inertia-weighted": {"name": "inertia-weighted"},
    "operational-space": {"name": "operational-space"},
    "qp": {"name": "qp"},
    "qp-maciejewski": {"name": "qp", "damping": 0.0, "stability": "maciejewski"},
    "qp-dead-beat": {"name": "qp", "damping": 0.0, "stability": "dead-beat"},
}
"""The laws and their variants by label, each with the keys of its table in a scenario."""


def compare_laws(
    scenario: str, progress: Callable[[str, float], None]
) -> tuple[dict[str, Run], dict[str, dict[str, Any]]]:
    """Run every variant on a shipped scenario.

    Args:
        scenario: Name of the scenario.
        progress: Called with what is being done and the part of the work that is done, 0 to 1.

    Returns:
        The runs, and their summaries with the largest energy of the self-motion, by label.
    """
    setup = with_variants(load_scenario(scenario_paths()[scenario])).build()
    runs = setup.run(lambda label, part: progress(f"{scenario}: {label}", part))
    return runs, {
        label: {**summarize(run), "self_motion_energy_max": float(run.self_motion_energy.max())}
        for label, run in runs.items()
    }


def with_variants(scenario: Scenario) -> Scenario:
    """Return a scenario with all variants as its laws."""
    laws = [{"label": label, **table} for label, table in VARIANTS.items()]
    return Scenario.model_validate({**dict(scenario), "controllers": laws})
