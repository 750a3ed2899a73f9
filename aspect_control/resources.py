"""Where the robot descriptions that ship with the package are found."""

from __future__ import annotations

from pathlib import Path

from .exceptions import ModelError

_PACKAGE = Path(__file__).resolve().parent
_FOLDERS = (_PACKAGE / "models", _PACKAGE.parent / "models")


def model_path(name: str) -> Path:
    """Return the path of a URDF of this package.

    Args:
        name: The file's name, such as `"planar3r.urdf"`.

    Returns:
        Its path: inside the installed package, or in `models/` of a checkout.

    Raises:
        ModelError: If no URDF of that name ships with the package.
    """
    for folder in _FOLDERS:
        if (folder / name).is_file():
            return folder / name
    existing = sorted(path.name for folder in _FOLDERS for path in folder.glob("*.urdf"))
    raise ModelError(f"no robot description {name!r} ships with aspect_control; there are: {', '.join(existing)}")
