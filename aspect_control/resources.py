"""Where the robot descriptions and scenarios that ship with the package are found."""

from __future__ import annotations

from pathlib import Path

from .exceptions import ModelError, shown

_PACKAGE = Path(__file__).resolve().parent


def model_path(name: str) -> Path:
    """Return the path of a URDF of this package.

    Args:
        name: The file's name, such as `"planar3r.urdf"`.

    Returns:
        Its path: inside the installed package, or in `models/` of a checkout.

    Raises:
        ModelError: If no URDF of that name ships with the package.
    """
    shipped = {path.name: path for path in _shipped("models", ".urdf").values()}
    if not isinstance(name, str) or name not in shipped:
        existing = ", ".join(sorted(shipped))
        raise ModelError(f"no robot description {shown(name)} ships with aspect_control; there are: {existing}")
    return shipped[name]


def scenario_paths() -> dict[str, Path]:
    """Return the scenarios of this package: their paths by name, sorted."""
    return _shipped("scenarios", ".toml")


def _shipped(folder: str, suffix: str) -> dict[str, Path]:
    """Return the data files of an installed package, or of a checkout, where they stand beside the package."""
    for place in (_PACKAGE / folder, _PACKAGE.parent / folder):
        if place.is_dir():
            return {path.stem: path for path in sorted(place.glob(f"*{suffix}"))}
    return {}
