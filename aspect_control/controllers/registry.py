"""Control laws by name, this package's and anybody's, through the entry points `aspect_control.controllers`."""

from __future__ import annotations

import inspect
from importlib.metadata import entry_points
from typing import Any

from ..arm import Arm
from ..exceptions import ControllerLoadError, ControllerNotFoundError, UnknownNameError
from .base import Controller

ENTRY_POINT_GROUP = "aspect_control.controllers"
"""A package adds a law by an entry point of this group: registry name = "module:Class"."""


def available() -> tuple[str, ...]:
    """Return the registry names of all installed laws, sorted."""
    return tuple(sorted(entry_points(group=ENTRY_POINT_GROUP).names))


def find(name: str) -> type[Controller]:
    """Return the class of a law.

    Args:
        name: Its registry name.

    Raises:
        ControllerNotFoundError: If there is none of that name; the message lists those that exist.
        ControllerLoadError: If it cannot be imported.
    """
    matches = entry_points(group=ENTRY_POINT_GROUP, name=name)
    if not matches:
        raise ControllerNotFoundError(name, available())
    entry_point = next(iter(matches))
    try:
        law: type[Controller] = entry_point.load()
    except Exception as error:
        # Somebody else's package can fail to import in any way.
        raise ControllerLoadError(f"the law {name!r} of {entry_point.value} cannot be loaded: {error}") from error
    return law


def parameter_names(law: type[Controller]) -> tuple[str, ...]:
    """Return the names of the parameters that a law takes besides the arm."""
    return tuple(name for name in inspect.signature(law).parameters if name != "arm")


def describe_parameters(law: type[Controller]) -> str:
    """Return a law's parameters with their defaults, in words."""
    parameters = [each for each in inspect.signature(law).parameters.values() if each.name != "arm"]
    return ", ".join(
        each.name if each.default is inspect.Parameter.empty else f"{each.name} = {each.default}" for each in parameters
    )


def create(name: str, arm: Arm, /, **parameters: Any) -> Controller:
    """Construct a law by name.

    Args:
        name: Registry name of the law.
        arm: The arm.
        **parameters: The law's own parameters, such as `kp=100.0`.

    Raises:
        ControllerNotFoundError: If there is no such law.
        UnknownNameError: If the law has no such parameter; the message lists those that it has.
        AspectControlError: As the law's constructor does.
    """
    law = find(name)
    allowed = parameter_names(law)
    for parameter in parameters:
        if parameter not in allowed:
            raise UnknownNameError(parameter, allowed, context=repr(name), kind="parameter")
    return law(arm, **parameters)
