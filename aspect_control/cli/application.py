"""The application that the commands belong to, and how it ends."""

from __future__ import annotations

import errno
import io
import json
import os
import sys
import warnings
from contextlib import suppress
from typing import Annotated, Any

import typer
from typer.exceptions import TyperException

from .. import __version__
from ..exceptions import AspectControlError

app = typer.Typer(
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def _without_command(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show the version and exit.")] = False,
) -> None:
    """Torque control of redundant arms that stays inside an aspect."""
    if version:
        typer.echo(f"aspect-control {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def run() -> int:
    """Run the command that the arguments ask for and return the exit status; an error is one line on standard error."""
    warnings.showwarning = _show_warning
    if isinstance(sys.stdout, io.TextIOWrapper):
        # Names of files, and Greek letters, where the terminal cannot show them.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        status = int(app(standalone_mode=False) or 0)
        sys.stdout.flush()
    except AspectControlError as error:
        return _failed(str(error))
    except TyperException as error:
        return _failed(error.format_message())
    except OSError as error:
        return _failed_output(error)
    return status


def as_json(document: dict[str, Any]) -> str:
    """Return a document as the text of a JSON file, without NaN."""
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    typer.echo(f"aspect-control: warning: {' '.join(str(message).split())}", err=True)


def _failed(message: str) -> int:
    with suppress(OSError):
        typer.echo(f"aspect-control: error: {' '.join(message.split())}", err=True)
    return 2


def _failed_output(error: OSError) -> int:
    """Say what the system refused; a reader of standard output that has gone, such as `head`, needs no word."""
    # What is still to be written would fail once more when Python ends.
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 1 if error.errno == errno.EPIPE else _failed(f"the system refused: {error}")
