"""Recorded runs as files: NumPy archives without pickle, checked when they are read."""

from __future__ import annotations

import json
import math
import os
import platform
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any
from zipfile import ZipFile

import numpy as np

from ..arm import Arm
from ..arm.description import ArmDescription
from ..checks import file_path, positive
from ..exceptions import AspectControlError, OutputError, RunFileError, shown
from ..files import atomic_path
from ..redundancy import Array

FORMAT = "aspect-control run 1"
"""What the file says of itself; the number changes when old versions could not read it."""

ARRAYS = ("t", "q", "v", "tau", "x_desired", "dx_desired", "ddx_desired")
"""The recorded arrays."""

MAX_SAMPLES = 20_000_000
"""The longest recording, in samples: about 5 GB for a 7-axis arm."""

MAX_HEADER = 2**26
"""The largest header of a recording, in bytes of four a character: URDF files are far below it."""


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
        plant: What moved: the name of the plant, or the class of the robot.
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
    plant: str = "rigid-body"


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
    if 4 * len(header) > MAX_HEADER:
        raise OutputError(f"cannot write {path}: the robot's description has {len(header):,} characters, too many")
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
    file = file_path("the run", path, RunFileError)
    try:
        with ZipFile(file) as archive:
            header = _read_header(archive)
            arm = _arm(header)
            return _read_arrays(archive, arm), arm, header.info
    except AspectControlError as error:
        raise RunFileError(f"{path} is damaged: {error}") from error
    except OSError as error:
        raise RunFileError(f"cannot read run {path}: {error.strerror or error}") from error
    except Exception as error:
        # A damaged archive can fail anywhere between the zip directory and the last array.
        raise RunFileError(f"{path} is not a recorded run (.npz written by Run.save): {error}") from error


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


def _read_header(archive: ZipFile) -> _Header:
    from pydantic import TypeAdapter

    with _Member(archive, "header") as member:
        if member.dtype.kind != "U" or member.shape != () or member.dtype.itemsize > MAX_HEADER:
            raise RunFileError(f"header must be one text of at most {MAX_HEADER:,} bytes, found {member}")
        text = str(member.read())
    found = json.loads(text)["format"]
    if found != FORMAT:
        raise RunFileError(f"its format is {shown(found)}, this version reads {FORMAT!r}")
    return TypeAdapter(_Header).validate_json(text, strict=True)


def _arm(header: _Header) -> Arm:
    """Return the arm of a header, after checking what else it says."""
    positive("dt", header.info.dt, "s")
    return Arm.from_description(header.arm)


def _read_arrays(archive: ZipFile, arm: Arm) -> dict[str, Array]:
    """Return the arrays of `ARRAYS`; the times first, for they say how large the others may be."""
    m = arm.task_dim
    columns = {"q": arm.nq, "v": arm.nv, "tau": arm.nv, "x_desired": arm.coordinates.encoded_size}
    times = _read_array(archive, "t", None)
    if not (np.diff(times) > 0.0).all():
        raise RunFileError("t must increase from sample to sample")
    return {"t": times} | {name: _read_array(archive, name, (len(times), columns.get(name, m))) for name in ARRAYS[1:]}


def _read_array(archive: ZipFile, name: str, shape: tuple[int, ...] | None) -> Array:
    """Return an array of a shape, by default a vector of at most `MAX_SAMPLES` entries; nothing else is unpacked."""
    with _Member(archive, name) as member:
        if shape is None:
            if len(member.shape) != 1 or member.shape[0] > MAX_SAMPLES:
                raise RunFileError(f"{name} must have one entry a sample, at most {MAX_SAMPLES:,}, found {member}")
            shape = member.shape
        if member.shape != shape or member.dtype != np.float64:
            raise RunFileError(f"{name} must be float64 of shape {shape}, found {member}")
        array: Array = member.read()
    if not np.isfinite(array).all():
        raise RunFileError(f"{name} must be finite")
    return array


class _Member:
    """One array of an archive, whose type and size are known before it is unpacked.

    Attributes:
        dtype: Its type.
        shape: Its shape.
    """

    def __init__(self, archive: ZipFile, name: str) -> None:
        """Read the header of an array.

        Raises:
            RunFileError: If it is larger or smaller than its header says.
            ValueError: If there is no such array, or its header cannot be read.
        """
        try:
            packed = archive.getinfo(f"{name}.npy")
        except KeyError:
            raise ValueError(f"it has no {name}") from None
        self._file = archive.open(packed)
        version = np.lib.format.read_magic(self._file)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        self.shape, _, self.dtype = read(self._file)
        size = self._file.tell() + math.prod(self.shape) * self.dtype.itemsize
        if self.dtype.hasobject or packed.file_size != size:
            raise RunFileError(f"{name} is {packed.file_size:,} bytes, not the {size:,} of {self}")

    def read(self) -> Any:
        """Return the array."""
        self._file.seek(0)
        return np.lib.format.read_array(self._file, allow_pickle=False)

    def __enter__(self) -> _Member:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __str__(self) -> str:
        return f"{self.dtype} of shape {self.shape}"
