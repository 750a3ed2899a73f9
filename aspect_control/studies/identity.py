"""What makes two studies the same."""

from __future__ import annotations

import hashlib
import json
import socket
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..exceptions import StudyError
from ..scenario import Scenario

if TYPE_CHECKING:
    from .study import Study


def identity(study: Study) -> dict[str, Any]:
    """Return all that decides what the runs of a study come to, as plain data.

    Descriptions, the report and the folders that files were found in are no part of it; what the robots' files say is.
    Nor are sections that a scenario does not have, so that a kind of section that is added later changes nothing.
    """
    return {
        **study.definition.model_dump(mode="json", include={"motions", "endings"}),
        "points": study.points,
        "scenarios": {name: _sections(scenario) for name, scenario in study.scenarios.items()},
        "robots": {name: _robot(scenario) for name, scenario in study.scenarios.items()},
    }


def require_identity(study: Study) -> None:
    """Make sure that a study that came from another machine is the same here, with the robots that this one has.

    Raises:
        StudyError: If it is not.
    """
    if digest(identity(study)) != study.hash:
        raise StudyError(
            f"{socket.gethostname()} has other robot files than the machine that started the study {study.name!r}"
        )


def digest(content: Any) -> str:
    """Return the SHA-256 of plain data, in hexadecimal digits."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _sections(scenario: Scenario) -> dict[str, Any]:
    dumped = scenario.model_dump(mode="json", exclude={"description", "folder"})
    return {name: section for name, section in dumped.items() if section is not None}


def _robot(scenario: Scenario) -> str:
    described = asdict(scenario.build(laws=()).arm.description)
    described.pop("package_dirs")  # where the meshes are
    return digest(described)
