"""Recorded runs as files: NumPy archives without pickle, checked when they are read."""

from __future__ import annotations

import json
import os
import platform
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..arm import Arm
from ..checks import positive
from ..description import ArmDescription
from ..exceptions import AspectControlError, RunFileError
from ..files import atomic_path
from ..redundancy import Array

FORMAT = "aspect-control run 1"
"""What the file says of itself; the number changes when old versions could not read it."""

ARRAYS = ("t", "q", "v", "tau", "x_desired", "dx_desired", "ddx_desired")
"""The recorded arrays."""


@dataclass(frozen=True)
class RunInfo:
    """How a run came about.

    Attributes:
        controller: Registry name of the law.
        parameters: Its parameters, as plain numbers, strings and lists.
        switches: Whether the law turns its null-space term on and off.
        trajectory: The trajectory as it was constructed.
        dt: Sampling time, s.
        integrator: Name of the integrator.
        status: How the run ended: `"finished"`, or the status of the event that ended it.
        message: The status in words, with the time.
        versions: Versions of Python and of the packages that computed the run.
    """

    controller: str
    parameters: dict[str, Any]
    switches: bool
    trajectory: str
    dt: float
    integrator: str
    status: str
    message: str
    versions: dict[str, str]


def write_run(path: str | os.PathLike[str], arrays: dict[str, Array], arm: Arm, info: RunInfo) -> None:
    """Write a recording.

    Args:
        path: The file.
        arrays: The arrays of `ARRAYS`.
        arm: The arm; its description goes into the file.
        info: How the run came about.

    Raises:
        OutputError: If it cannot be written.
    """
    header = json.dumps(asdict(_Header(FORMAT, arm.description, info)))
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, header=np.array(header), **arrays)  # type: ignore[arg-type]


def read_run(path: str | os.PathLike[str]) -> tuple[dict[str, Array], Arm, RunInfo]:
    """Read a recording and check that it is whole.

    Args:
        path: The file.

    Returns:
        The arrays of `ARRAYS`, the arm and how the run came about.

    Raises:
        RunFileError: If the file is missing, is no recorded run or is damaged.
    """
    try:
        with Path(path).open("rb") as file:
            header, arrays = _read(file)
    except OSError as error:
        raise RunFileError(f"cannot read run {path}: {error.strerror or error}") from error
    except Exception as error:
        # A damaged archive can fail anywhere between the zip directory and the last array.
        # NumPy's advice to load such a file unsafely is not ours.
        reason = "" if "pickle" in str(error) else f": {error}"
        raise RunFileError(f"{path} is not a recorded run (.npz written by Run.save){reason}") from error
    try:
        positive("dt", header.info.dt, "s")
        arm = Arm.from_description(header.arm)
    except AspectControlError as error:
        raise RunFileError(f"{path} does not describe a run: {error}") from error
    _require_consistent(path, arrays, arm)
    return arrays, arm, header.info


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that a run depends on."""
    packages = ("aspect-control", "pin", "numpy")
    return {"python": platform.python_version(), **{package: version(package) for package in packages}}


@dataclass(frozen=True)
class _Header:
    """What a file holds besides the arrays."""

    format: str
    arm: ArmDescription
    info: RunInfo


def _read(file: BinaryIO) -> tuple[_Header, dict[str, Array]]:
    from pydantic import TypeAdapter

    with np.load(file, allow_pickle=False) as archive:
        text = str(archive["header"])
        found = json.loads(text)["format"]
        if found != FORMAT:
            raise ValueError(f"its format is {found!r}, this version reads {FORMAT!r}")
        return TypeAdapter(_Header).validate_json(text, strict=True), {name: archive[name] for name in ARRAYS}


def _require_consistent(path: str | os.PathLike[str], arrays: dict[str, Array], arm: Arm) -> None:
    samples = arrays["t"].shape[:1]
    columns = {"t": (), "q": (arm.nq,), "v": (arm.nv,), "tau": (arm.nv,), "x_desired": (arm.coordinates.encoded_size,)}
    for name, array in arrays.items():
        expected = samples + columns.get(name, (arm.task_dim,))
        if array.shape != expected or array.dtype != np.float64:
            found = f"{array.dtype} of shape {array.shape}"
            raise RunFileError(f"{path} is damaged: {name} must be float64 of shape {expected}, found {found}")
        if not np.isfinite(array).all():
            raise RunFileError(f"{path} is damaged: {name} must be finite")
