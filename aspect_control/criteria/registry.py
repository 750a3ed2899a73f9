"""Criteria by name, this package's and anybody's, through the entry points `aspect_control.criteria`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..arm import Arm
from ..exceptions import CriterionLoadError, CriterionNotFoundError, ParameterError, shown
from ..registry import Registry, describe_parameters, parameter_names
from .criterion import Criterion

__all__ = [
    "ENTRY_POINT_GROUP",
    "available",
    "create",
    "describe_parameters",
    "find",
    "make",
    "parameter_names",
    "specification",
]

ENTRY_POINT_GROUP = "aspect_control.criteria"
"""A package adds a criterion by an entry point of this group: registry name = "module:Class"."""

_CRITERIA: Registry[Criterion] = Registry(ENTRY_POINT_GROUP, "criterion", CriterionNotFoundError, CriterionLoadError)

available = _CRITERIA.available
"""Return the names of all installed criteria, sorted; see `Registry.available`."""

find = _CRITERIA.find
"""Return the class of a criterion by its name; see `Registry.find`."""

create = _CRITERIA.create
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
    if isinstance(criterion, Criterion):
        if criterion.arm is not arm and criterion.arm.description != arm.description:
            raise ParameterError(f"the criterion {criterion.name!r} is one of {criterion.arm}, not of {arm}")
        return criterion
    if not isinstance(criterion, Mapping):
        return create(criterion, arm)
    parameters = dict(criterion)
    if "name" not in parameters or not all(isinstance(key, str) for key in parameters):
        raise ParameterError(
            f"a criterion with parameters needs a 'name' among them and names alone as keys, got {shown(parameters)}"
        )
    return create(parameters.pop("name"), arm, **parameters)


def specification(criterion: Criterion) -> str | dict[str, Any]:
    """Return what `make` makes the same criterion of: its name, with its parameters if it has any, as plain data."""
    return {"name": criterion.name, **criterion.parameters} if criterion.parameters else criterion.name
