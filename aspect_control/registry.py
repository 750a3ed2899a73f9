"""Classes by name, this package's and anybody's, through entry points."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from .arm import Arm
from .checks import known_name
from .exceptions import EntryPointError, ParameterError, UnknownNameError, shown

T = TypeVar("T")


@cache
def _installed(group: str, path: tuple[str, ...]) -> dict[str, EntryPoint]:
    """Return the entry points of a group by name; looked up once for each `sys.path`, for it reads files."""
    return {entry_point.name: entry_point for entry_point in reversed(tuple(entry_points(group=group)))}


class Registry(Generic[T]):
    """What an entry-point group offers: classes of one kind, each with a name and parameters of its own.

    A class whose first parameter is called `arm` is made for an arm; one without is made of its parameters alone.

    Attributes:
        group: The group; a package adds a class by an entry point of it: name = "module:Class".
        base: The abstract base of the classes.
    """

    def __init__(
        self,
        group: str,
        base: type[T],
        *,
        not_found: type[UnknownNameError] = UnknownNameError,
        load_error: type[EntryPointError] = EntryPointError,
    ) -> None:
        """Set the group.

        Args:
            group: Name of the entry-point group.
            base: The abstract base of its classes; its name in small letters is what errors call one.
            not_found: The error for a name that does not exist.
            load_error: The error for a class that cannot be imported, or is none of the kind.
        """
        self.group = group
        self.base = base
        self._kind = base.__name__.lower()
        self._not_found = not_found
        self._load_error = load_error

    def available(self) -> tuple[str, ...]:
        """Return the names of all that is installed, sorted."""
        return tuple(sorted(_installed(self.group, tuple(sys.path))))

    def find(self, name: str) -> type[T]:
        """Return the class of a name.

        Args:
            name: Its name.

        Raises:
            UnknownNameError: If there is none of that name; the message lists those that exist.
            EntryPointError: If it cannot be imported, or is no class of the kind.
        """
        known_name(name, self.available(), self._kind, error=self._not_found)
        entry_point = _installed(self.group, tuple(sys.path))[name]
        try:
            found = entry_point.load()
        except Exception as error:
            # Somebody else's package can fail to import in any way.
            raise self._load_error(
                f"the {self._kind} {name!r} of {entry_point.value} cannot be loaded: {error}"
            ) from error
        if not (isinstance(found, type) and issubclass(found, self.base)):
            raise self._load_error(
                f"the {self._kind} {name!r} of {entry_point.value} must be a class derived from "
                f"{self.base.__name__}, got {shown(found)}"
            )
        return found

    def create(self, name: str, arm: Arm | None = None, /, **parameters: Any) -> T:
        """Construct by name.

        Args:
            name: The name.
            arm: The arm; handed on to a class that is made for one.
            **parameters: The class's own parameters, such as `kp=100.0`.

        Raises:
            UnknownNameError: If there is none of that name, or it has no such parameter; the message lists those that
                it has.
            ParameterError: If a parameter without a default is missing, or the arm, or it is no arm.
            AspectControlError: As the constructor does.
        """
        found = self.require_parameters(name, parameters)
        for_arm = _is_made_for_an_arm(found)
        if not isinstance(arm, Arm) and (for_arm or arm is not None):
            expected = "is made for an Arm" if for_arm else "is made of parameters by name"
            raise ParameterError(f"{name!r} {expected}, got {shown(arm)}")
        made: T = found(arm, **parameters) if for_arm else found(**parameters)  # type: ignore[call-arg]
        return made

    def make(self, given: str | Mapping[str, Any] | T, arm: Arm | None = None) -> T:
        """Return what is meant by a name, alone or with parameters, or by the object itself.

        Args:
            given: A name; a mapping with a `name` and the parameters; or an object of the kind, which is returned.
            arm: The arm; handed on to a class that is made for one.

        Raises:
            UnknownNameError: If there is none of that name, or it has no such parameter.
            ParameterError: If a mapping has no name, or as `create` does.
            AspectControlError: As the constructor does.
        """
        if isinstance(given, self.base):
            return given
        if isinstance(given, str):
            return self.create(given, arm)
        if not isinstance(given, Mapping):
            also = f"or {_article(self._kind)} {self.base.__name__} itself"
            raise self._not_found(given, self.available(), kind=self._kind, also=also)
        parameters = dict(given)
        if "name" not in parameters or not all(isinstance(key, str) for key in parameters):
            raise ParameterError(
                f"{_article(self._kind)} {self._kind} with parameters needs a 'name' among them and names alone as "
                f"keys, got {shown(parameters)}"
            )
        return self.create(parameters.pop("name"), arm, **parameters)

    def require_parameters(self, name: str, parameters: Mapping[str, Any]) -> type[T]:
        """Make sure that the class of a name takes the parameters, whatever their values, and return the class.

        Args:
            name: The name.
            parameters: The parameters by name.

        Raises:
            UnknownNameError: If there is none of that name, or it has no such parameter.
            ParameterError: If a parameter without a default is missing.
        """
        found = self.find(name)
        allowed = parameter_names(found)
        for parameter in parameters:
            known_name(parameter, allowed, "parameter", context=repr(name))
        missing = [each for each in _required(found) if each not in parameters]
        if missing:
            raise ParameterError(
                f"{name!r} needs {', '.join(map(repr, missing))}; its parameters: {describe_parameters(found)}"
            )
        return found


def parameter_names(cls: type[Any]) -> tuple[str, ...]:
    """Return the names of the parameters that a class takes besides the arm."""
    return tuple(each.name for each in _parameters(cls))


def describe_parameters(cls: type[Any]) -> str:
    """Return the parameters of a class with their defaults, in words."""
    return ", ".join(
        each.name if each.default is inspect.Parameter.empty else f"{each.name} = {each.default}"
        for each in _parameters(cls)
    )


def _article(noun: str) -> str:
    return "an" if noun[0] in "aeiou" else "a"


def _is_made_for_an_arm(cls: Callable[..., Any]) -> bool:
    return [each.name for each in _all_parameters(cls)[:1]] == ["arm"]


def _parameters(cls: Callable[..., Any]) -> tuple[inspect.Parameter, ...]:
    """Return the parameters of a class besides the arm."""
    return _all_parameters(cls)[1 if _is_made_for_an_arm(cls) else 0 :]


@cache
def _all_parameters(cls: Callable[..., Any]) -> tuple[inspect.Parameter, ...]:
    """Return the parameters of a class; kept, for to read a signature takes as long as some samples of a run."""
    return tuple(inspect.signature(cls).parameters.values())


def _required(cls: Callable[..., Any]) -> list[str]:
    """Return the names of the parameters besides the arm that have no default."""
    single = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [each.name for each in _parameters(cls) if each.default is inspect.Parameter.empty and each.kind in single]
