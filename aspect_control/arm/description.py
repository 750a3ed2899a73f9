"""What an arm is made from: enough to make it again, in a recording or in another process."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from numpy.typing import ArrayLike

from ..checks import file_path, finite_number, finite_vector, unicode_text
from ..exceptions import ModelError, ParameterError, shown
from .sources.pinocchio_model import ChainRecord, build_chain
from .sources.urdf import parse_urdf
from .tasks import Task, TaskChoice

LockedJoints: TypeAlias = Mapping[str, float] | None
"""Positions of joints to lock, rad or m, by name; None for none."""


@dataclass(frozen=True)
class ArmDescription:
    """The robot, the frame, the task and what was set besides.

    Attributes:
        frame: Name of the task frame.
        task: The task coordinates.
        gravity: Gravitational acceleration in the world frame, m/s².
        locked: Positions of locked joints, rad or m, by name.
        urdf: Text of the URDF; None for an arm made of a `pin.Model`.
        package_dirs: Folders in which the URDF's `package://` meshes are found.
        chain: The reduced chain as numbers; None for an arm made of a URDF.
    """

    frame: str
    task: tuple[str, ...]
    gravity: tuple[float, float, float]
    locked: dict[str, float]
    urdf: str | None = None
    package_dirs: tuple[str, ...] = ()
    chain: ChainRecord | None = None

    @classmethod
    def of(
        cls,
        model: Any,
        *,
        frame: str,
        task: TaskChoice,
        gravity: ArrayLike | None,
        locked: LockedJoints,
        urdf: str | None = None,
        package_dirs: Sequence[str | os.PathLike[str]] | None = None,
    ) -> ArmDescription:
        """Describe an arm of a model, as `Arm.from_urdf` takes it; gravity None is the model's own.

        Raises:
            TaskError: If `task` is unknown.
            ParameterError: If `locked` is no mapping of names to finite numbers, or `package_dirs` no list of folders.
            ShapeError: If `gravity` has not three entries.
            NonFiniteError: If `gravity` is not finite.
        """
        locked = {} if locked is None else locked
        if not isinstance(locked, Mapping):
            raise ParameterError(f"locked must be a mapping of joint names to positions, got {shown(locked)}")
        folders = () if package_dirs is None else package_dirs
        if not isinstance(folders, Sequence) or isinstance(folders, (str, bytes)):
            raise ParameterError(f"package_dirs must be a list of folders, got {shown(folders)}")
        vector = model.gravity.linear if gravity is None else finite_vector("gravity", gravity, 3)
        return cls(
            frame=frame,
            task=Task.parse(task).axes,
            gravity=(float(vector[0]), float(vector[1]), float(vector[2])),
            locked={name: finite_number(f"locked[{shown(name)}]", position) for name, position in locked.items()},
            urdf=urdf,
            package_dirs=tuple(unicode_text("a folder", str(file_path("a folder", each))) for each in folders),
        )

    def model(self) -> Any:
        """Return the robot as a `pin.Model`: the whole one of a URDF, the chain of a recorded model.

        Raises:
            AspectControlError: If the description is not that of an arm.
        """
        Task.parse(self.task)
        finite_vector("gravity", self.gravity, 3)
        if self.urdf is not None:
            return parse_urdf(self.urdf, "the recorded URDF")
        if self.chain is None:
            raise ModelError("the description has neither a URDF nor a chain")
        return build_chain(self.chain, self.frame)
