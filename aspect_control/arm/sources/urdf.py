"""Reading a URDF into Pinocchio, with errors that say what is wrong with it."""

from __future__ import annotations

import os
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pinocchio as pin

from ...checks import file_path, unicode_text
from ...exceptions import ModelError


def read_urdf(path: str | os.PathLike[str]) -> str:
    """Return the text of a URDF file.

    Raises:
        ModelError: If the file is missing or unreadable, with the URDF files that stand beside it.
    """
    file = file_path("the URDF", path, ModelError)
    try:
        return file.read_text(encoding="utf-8")
    except FileNotFoundError:
        beside = sorted(other.name for other in file.parent.glob("*.urdf")) if file.parent.is_dir() else []
        existing = f"that folder has {', '.join(beside)}" if beside else f"there is no URDF file in {file.parent}"
        raise ModelError(f"no such URDF file: {file}; {existing}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"cannot read URDF file {file}: {error}") from error


def parse_urdf(text: str, name: str) -> Any:
    """Build a `pin.Model` from the text of a URDF.

    Args:
        text: The URDF.
        name: What the URDF is called in errors, usually its path.

    Returns:
        The model, with Pinocchio's standard gravity (0, 0, −9.81) m/s².

    Raises:
        ModelError: If the text is no well-formed XML or no URDF, or a link's inertia cannot be read, with the parser's
            own reason.
    """
    try:
        root = ElementTree.fromstring(unicode_text(name, text, ModelError))
    except ElementTree.ParseError as error:
        raise ModelError(f"{name} is not well-formed XML: {error}") from None
    messages: list[str] = []
    try:
        with _native_stderr(messages):
            model = pin.buildModelFromXML(text)
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{name} is not a valid URDF: {_reason(messages) or error}") from None
    if any("Error" in line and "inertial" in line for line in messages):
        # The parser goes on without the inertia, which would silently change the dynamics.
        raise ModelError(f"{name} is not a valid URDF: {_reason(messages)}")
    _require_masses(root, name)
    sys.stderr.writelines(messages)
    return model


def mimic_joints(text: str) -> tuple[str, ...]:
    """Return the names of the joints of a URDF that follow another joint."""
    joints = ElementTree.fromstring(text).iter("joint")
    return tuple(joint.get("name", "") for joint in joints if joint.find("mimic") is not None)


def _require_masses(root: ElementTree.Element, name: str) -> None:
    """Refuse a negative mass, which Pinocchio adds to that of the links that are fixed to it."""
    for link in root.findall("link"):
        mass = link.find("inertial/mass")
        if mass is not None and mass.get("value", "").strip().startswith("-") and float(mass.get("value", "")) < 0.0:
            raise ModelError(f"link {link.get('name')!r} of {name} has a negative mass of {mass.get('value')} kg")


def _reason(messages: list[str]) -> str:
    """Return the parser's complaints without its own source lines."""
    complaints = (line.removeprefix("Error:").strip() for line in messages if "at line" not in line)
    return "; ".join(line for line in complaints if line)


@contextmanager
def _native_stderr(messages: list[str]) -> Iterator[None]:
    """Collect what native code prints on file descriptor 2: urdfdom explains itself nowhere else."""
    with tempfile.TemporaryFile() as capture:
        sys.stderr.flush()
        saved = os.dup(2)
        os.dup2(capture.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            capture.seek(0)
            messages.extend(capture.read().decode(errors="replace").splitlines(keepends=True))
