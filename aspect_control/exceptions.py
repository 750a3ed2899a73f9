"""Errors of the package: every one says what was given, what was expected and, for names, what exists."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_LONGEST_SHOWN = 200


def shown(value: object) -> str:
    """Return a value as an error shows it: what `repr` says, cut short where it is long, whatever the value is."""
    try:
        text = repr(value)
    except Exception:
        # Such as an integer of more digits than Python prints, or lists nested deeper than it follows.
        return f"a value of type {type(value).__name__}"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."


class AspectControlError(Exception):
    """Base class of every error that this package raises on purpose."""


class ModelError(AspectControlError):
    """A robot description cannot be read, or does not describe an arm."""


class NotRedundantError(AspectControlError):
    """The task takes up every joint, so that there is no redundancy to resolve."""


class ParameterError(AspectControlError, ValueError):
    """A parameter has a value outside its range, or is no parameter at all."""


class ShapeError(AspectControlError, ValueError):
    """An array has the wrong number of dimensions or entries."""


class NonFiniteError(AspectControlError, ValueError):
    """An array holds NaN or infinity, or a computation would have produced one."""


class TooManyMinorsError(AspectControlError):
    """A Jacobian has more minors than can be handled."""


class UnreachableError(AspectControlError):
    """No posture inside the joint limits puts the task frame where it is to be."""


class RankLossError(AspectControlError):
    """The Jacobian has lost rank, so that the self-motion has no direction of its own."""


class AspectBorderWarning(UserWarning):
    """A motion starts on the border of an aspect, or is about to come near one."""


class WorkspaceWarning(UserWarning):
    """A path leaves what an arm can reach inside its joint limits."""


class UndefinedCriterionWarning(UserWarning):
    """A criterion has no definite gradient where a motion starts."""


class UndefinedCriterionError(AspectControlError):
    """A criterion is not defined where a motion starts."""


class DamagedShardWarning(UserWarning):
    """A file of a study's table cannot be read, so that its runs are made again."""


class DrawingWarning(UserWarning):
    """Something cannot be drawn as it looks, such as a robot whose meshes are gone."""


class EntryPointError(AspectControlError):
    """What an installed package offers by an entry point cannot be imported, or is not of its kind."""


class ControllerLoadError(EntryPointError):
    """An installed law cannot be imported."""


class CriterionLoadError(EntryPointError):
    """An installed criterion cannot be imported."""


class NotResetError(AspectControlError):
    """A law with memory was asked for a torque before `reset(q, v, dt)`."""


class RunFileError(AspectControlError):
    """A file is not a recorded run, or not one that this version can read."""


class ScenarioError(AspectControlError):
    """A scenario file is missing or does not describe a scenario."""


class StudyError(AspectControlError):
    """A study file is missing or does not describe a study, or a folder holds something else than its results."""


class WorkerError(AspectControlError):
    """A process that shared the work ended by itself."""


class RobotError(AspectControlError):
    """A robot does not answer, or says something that cannot be."""


class OutputError(AspectControlError):
    """A result cannot be written where it was asked for."""


class UnknownNameError(AspectControlError, LookupError):
    """A name is not among those that exist.

    Attributes:
        name: The name that was given.
        available: The names that exist.
    """

    kind = "name"

    def __init__(
        self, name: object, available: Iterable[str], *, context: str = "", kind: str = "", also: str = ""
    ) -> None:
        """Build the message.

        Args:
            name: The name that was given.
            available: The names that exist.
            context: Where it was looked for, such as `"planar3r.urdf"`; empty for nowhere in particular.
            kind: What the name stands for; empty for the class's own kind.
            also: What may be given instead of a name.
        """
        self.name = name
        self.available = tuple(available)
        where = f" in {context}" if context else ""
        given = name if isinstance(name, str) else shown(name)
        nearest = difflib.get_close_matches(given, self.available, n=3, cutoff=0.5)
        hint = f"did you mean {_quoted(nearest)}? " if nearest else ""
        existing = _quoted(self.available) if self.available else "none"
        more = f"; {also}" if also else ""
        super().__init__(f"unknown {kind or self.kind} {shown(name)}{where}: {hint}available: {existing}{more}")


class FrameNotFoundError(UnknownNameError):
    """The model has no frame of that name."""

    kind = "frame"


class JointNotFoundError(UnknownNameError):
    """The model has no joint of that name."""

    kind = "joint"


class TaskError(UnknownNameError):
    """The task is no known name and no set of task coordinates."""

    kind = "task"


class ControllerNotFoundError(UnknownNameError):
    """No control law is registered under that name."""

    kind = "controller"


class CriterionNotFoundError(UnknownNameError):
    """No criterion is registered under that name."""

    kind = "criterion"


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(repr(name) for name in names)
