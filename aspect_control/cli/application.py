"""The application that the commands belong to, and how it ends."""

from __future__ import annotations

import json
import sys
import warnings
from typing import Any

import typer
from typer.exceptions import TyperException

from ..exceptions import AspectControlError

INTERRUPTED = 130
"""Exit status of a command that was interrupted from the keyboard."""

app = typer.Typer(
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def _help_without_command(context: typer.Context) -> None:
    """Torque control of redundant arms that stays inside an aspect."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main() -> None:
    """Run the command line; bad input ends in one line on standard error and exit status 2."""
    warnings.showwarning = _show_warning
    try:
        status = app(standalone_mode=False)
    except AspectControlError as error:
        _fail(str(error))
    except TyperException as error:
        _fail(error.format_message())
    else:
        if status == INTERRUPTED:
            typer.echo("aspect-control: interrupted; what was written stays", err=True)
        sys.exit(status)


def as_json(document: dict[str, Any]) -> str:
    """Return a document as the text of a JSON file, without NaN."""
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    typer.echo(f"aspect-control: warning: {' '.join(str(message).split())}", err=True)


def _fail(message: str) -> None:
    typer.echo(f"aspect-control: error: {' '.join(message.split())}", err=True)
    sys.exit(2)
