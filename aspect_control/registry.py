"""Classes by name, this package's and anybody's, through entry points."""

from __future__ import annotations

import inspect
from importlib.metadata import entry_points
from typing import Any, Generic, TypeVar

from .arm import Arm
from .checks import known_name
from .exceptions import AspectControlError, ParameterError, UnknownNameError, shown

T = TypeVar("T")


class Registry(Generic[T]):
    """What an entry-point group offers: classes that are constructed with an arm and parameters of their own.

    Attributes:
        group: The group; a package adds a class by an entry point of it: name = "module:Class".
    """

    def __init__(
        self, group: str, noun: str, not_found: type[UnknownNameError], load_error: type[AspectControlError]
    ) -> None:
        """Set the group.

        Args:
            group: Name of the entry-point group.
            noun: What one of its classes is called in errors.
            not_found: The error for a name that does not exist.
            load_error: The error for a class that cannot be imported.
        """
        self.group = group
        self._noun = noun
        self._not_found = not_found
        self._load_error = load_error

    def available(self) -> tuple[str, ...]:
        """Return the names of all that is installed, sorted."""
        return tuple(sorted(entry_points(group=self.group).names))

    def find(self, name: str) -> type[T]:
        """Return the class of a name.

        Args:
            name: Its name.

        Raises:
            UnknownNameError: If there is none of that name; the message lists those that exist.
            AspectControlError: If it cannot be imported.
        """
        known_name(name, self.available(), error=self._not_found)
        entry_point = next(iter(entry_points(group=self.group, name=name)))
        try:
            found: type[T] = entry_point.load()
        except Exception as error:
            # Somebody else's package can fail to import in any way.
            raise self._load_error(
                f"the {self._noun} {name!r} of {entry_point.value} cannot be loaded: {error}"
            ) from error
        return found

    def create(self, name: str, arm: Arm, /, **parameters: Any) -> T:
        """Construct by name.

        Args:
            name: The name.
            arm: The arm.
            **parameters: The class's own parameters, such as `kp=100.0`.

        Raises:
            UnknownNameError: If there is none of that name, or it has no such parameter; the message lists those that
                it has.
            AspectControlError: If a parameter without a default is missing, or as the constructor does.
        """
        found = self.find(name)
        if not isinstance(arm, Arm):
            raise ParameterError(f"{name!r} is made for an Arm, got {shown(arm)}")
        allowed = parameter_names(found)
        for parameter in parameters:
            known_name(parameter, allowed, "parameter", context=repr(name))
        missing = [each for each in _required(found) if each not in parameters]
        if missing:
            raise ParameterError(
                f"{name!r} needs {', '.join(map(repr, missing))}; its parameters: {describe_parameters(found)}"
            )
        made: T = found(arm, **parameters)  # type: ignore[call-arg]
        return made


def parameter_names(cls: type[Any]) -> tuple[str, ...]:
    """Return the names of the parameters that a class takes besides the arm."""
    return tuple(name for name in inspect.signature(cls).parameters if name != "arm")


def _required(cls: type[Any]) -> list[str]:
    """Return the names of the parameters besides the arm that have no default."""
    signature = inspect.signature(cls).parameters
    single = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [
        name
        for name in parameter_names(cls)
        if signature[name].default is inspect.Parameter.empty and signature[name].kind in single
    ]


def describe_parameters(cls: type[Any]) -> str:
    """Return the parameters of a class with their defaults, in words."""
    parameters = [each for each in inspect.signature(cls).parameters.values() if each.name != "arm"]
    return ", ".join(
        each.name if each.default is inspect.Parameter.empty else f"{each.name} = {each.default}" for each in parameters
    )
