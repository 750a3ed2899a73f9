"""All laws of the package on the same motions."""

from __future__ import annotations

from typing import Any

from .study import Study

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


def comparison_study() -> Study:
    """Return the study: every variant on the motions of the scenarios."""
    laws = [{"label": label, **table} for label, table in VARIANTS.items()]
    return Study({"scenarios": list(SCENARIOS), "laws": laws, "report": "comparison"}, "compare")
