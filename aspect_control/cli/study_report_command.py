"""The command that says what came of a study."""

from __future__ import annotations

import typer

from .study_commands import Folder, studies


@studies.command()
def report(folder: Folder) -> None:
    """Write the report of a study, and its figures, from the runs that are there.

    It is the report that the study file names: 'summary', which fits every study, unless it says otherwise.
    """
    from ..studies.shards import read_folder, study_of
    from ..views.progress import progress_bar
    from ..views.reports.report_files import write_report

    study, table = study_of(folder), read_folder(folder)
    with progress_bar() as progress:
        written = write_report(study, table, folder, progress)
    there = "" if table.num_rows == study.runs else f" of {study.runs:,}"
    typer.echo(f"{table.num_rows:,}{there} runs; written to {folder}: {', '.join(written)}")
