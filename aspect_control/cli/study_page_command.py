"""The command that fills a page with what studies came to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .study_commands import studies


@studies.command()
def page(
    template: Annotated[Path, typer.Argument(help="A text with fields such as ${verdict}; see docs/studies.md.")],
    folders: Annotated[list[Path], typer.Argument(help="Folders of studies whose report is 'hypothesis'.")],
    out: Annotated[Path, typer.Option(help="Folder for the page, its numbers and its figures.")],
) -> None:
    """Fill a page with what studies say about the hypothesis."""
    from ..studies.hypothesis import stored
    from ..studies.shards import read_folder, study_of
    from ..views.progress import progress_bar
    from ..views.reports.hypothesis_files import read_template, write_page

    text = read_template(template)
    parts = [stored(study_of(folder), read_folder(folder), folder) for folder in folders]
    with progress_bar() as progress:
        written = write_page(text, parts, out, progress)
    typer.echo(f"written to {out}: {', '.join(written)}")
