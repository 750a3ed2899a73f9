"""Criteria by name, this package's and anybody's, through the entry points `aspect_control.criteria`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..arm import Arm
from ..exceptions import CriterionLoadError, CriterionNotFoundError, ParameterError
from ..registry import Registry, describe_parameters, parameter_names
from .criterion import Criterion

__all__ = [
    "CRITERIA",
    "available",
    "create",
    "describe_parameters",
    "find",
    "make",
    "parameter_names",
    "specification",
]

CRITERIA: Registry[Criterion] = Registry(
    "aspect_control.criteria", Criterion, not_found=CriterionNotFoundError, load_error=CriterionLoadError
)
"""All installed criteria."""

available = CRITERIA.available
"""Return the names of all installed criteria, sorted; see `Registry.available`."""

find = CRITERIA.find
"""Return the class of a criterion by its name; see `Registry.find`."""

create = CRITERIA.create
"""Construct a criterion by its name, on an arm, with parameters; see `Registry.create`."""


def make(arm: Arm, criterion: str | Mapping[str, Any] | Criterion) -> Criterion:
    """Return a criterion from what a law or a scenario names it by.

    Args:
        arm: The arm.
        criterion: A name; a mapping with a `name` and the parameters; or a criterion of the arm, which is returned.

    Raises:
        CriterionNotFoundError: If there is no criterion of that name.
        ParameterError: If a mapping has no name, a parameter is missing, or the criterion is one of another arm.
        AspectControlError: As `create` does.
    """
    made = CRITERIA.make(criterion, arm)
    if made.arm is not arm and made.arm.description != arm.description:
        raise ParameterError(f"the criterion {made.name!r} is one of {made.arm}, not of {arm}")
    return made


def specification(criterion: Criterion) -> str | dict[str, Any]:
    """Return what `make` makes the same criterion of: its name, with its parameters if it has any, as plain data."""
    return {"name": criterion.name, **criterion.parameters} if criterion.parameters else criterion.name
