"""Files are written whole or not at all."""

from __future__ import annotations

import hashlib
import os
import secrets
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .checks import file_path, unicode_text
from .exceptions import OutputError


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`, which replaces `path` when the block ends well.

    Args:
        path: The file to write. An existing one is replaced in one step and its permissions stay; a symbolic link is
            followed.

    Yields:
        A path of the same suffix in the same folder, for the block to write to.

    Raises:
        OutputError: If `path` cannot be one, is something other than a file (a folder, a device, a pipe, a socket), is
            read-only, or its folder does not exist or cannot be written to.
    """
    given = file_path("the file to write", path, OutputError)
    temporary = None
    try:
        target = given.resolve()
        mode = _mode_of_existing(target)
        # Named before it is made, so that an interruption at any time finds it.
        temporary = target.with_name(f".{secrets.token_hex(8)}{target.suffix}")
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666 if mode is None else 0o600))
        yield temporary
        if mode is not None:
            temporary.chmod(mode)
        temporary.replace(target)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    except RuntimeError as error:
        if temporary is not None:
            raise
        raise OutputError(f"cannot write {path}: {error}") from None  # symbolic links in a circle, before Python 3.13
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write `text` to `path` as UTF-8, atomically.

    Raises:
        OutputError: If it cannot be written.
    """
    content = unicode_text(f"what is written to {path}", text, OutputError)
    with atomic_path(path) as temporary:
        temporary.write_text(content, encoding="utf-8")


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file, in hexadecimal digits.

    Raises:
        OSError: If it cannot be read.
    """
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def output_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder for results, with its parents, and make sure that it can be written to.

    Raises:
        OutputError: If it cannot be made, is no folder or cannot be written to.
    """
    folder = file_path("the output folder", path, OutputError)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(f"cannot write to folder {folder}: {error.strerror}") from error
    return folder


def _mode_of_existing(target: Path) -> int | None:
    """Return the permissions of a file that may be replaced; None if there is no such file."""
    try:
        found = target.stat().st_mode
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(found):
        raise OSError(None, "it is no file that could be replaced")
    mode = stat.S_IMODE(found)
    # Root may write to any file, but the owner of this one wants it to stay.
    if not mode & 0o222 or not os.access(target, os.W_OK):
        raise OSError(None, "it is read-only")
    return mode
