"""Commands about studies: many runs, and the table of what came of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from .application import app

if TYPE_CHECKING:
    from ..studies import Study

Folder = Annotated[Path, typer.Argument(help="The folder of a study.")]
Workers = Annotated[int | None, typer.Option(help="Number of processes; one a processor unless given.")]


class _RunUnlessNamed(TyperGroup):
    """`study FILE` is short for `study run FILE`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `run` before what is no name of a command."""
        named = not args or args[0] in self.commands or args[0] == "--help"
        return super().parse_args(ctx, args if named else ["run", *args])


studies = typer.Typer(
    cls=_RunUnlessNamed,
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Run a study, FILE.toml, or look at what came of one: thousands of runs as a table.",
)
app.add_typer(studies, name="study")


@studies.command("run")
def run_study(
    file: Annotated[Path, typer.Argument(help="A TOML file; see docs/studies.md.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the table; results/studies/NAME unless given.")] = None,
    workers: Workers = None,
    engine: Annotated[str, typer.Option(help="loky: processes of this machine; dask: a Dask cluster.")] = "loky",
    scheduler: Annotated[str | None, typer.Option(help="Address of Dask's scheduler, tcp://HOST:PORT.")] = None,
    shard: Annotated[str | None, typer.Option(help="Part of the chunks for a batch queue, such as 2/8.")] = None,
    resume: Annotated[bool, typer.Option(help="Go on with what the folder holds, or make it anew.")] = True,
    yes: Annotated[bool, typer.Option("--yes", help="Go on even if it takes long.")] = False,
) -> None:
    """Make the runs of a study that are not there yet."""
    from ..studies import Study

    study = Study.load(file)
    folder = out or Path("results") / "studies" / study.name
    table = make_runs(
        study, folder, workers=workers, engine=engine, scheduler=scheduler, shard=shard, resume=resume, yes=yes
    )
    typer.echo(f"{table.num_rows:,} of {study.runs:,} runs are in {folder}: aspect-control study report {folder}")


@studies.command()
def merge(
    folders: Annotated[list[Path], typer.Argument(help="Folders with parts of one study.")],
    out: Annotated[Path, typer.Option(help="Parquet file for the whole table.")],
) -> None:
    """Put the parts of a study, such as those of --shard, into one Parquet file."""
    from ..files import sha256
    from ..studies.shards import merge_folders

    table, missing = merge_folders(folders, out)
    typer.echo(f"{table.num_rows:,} runs written to {out}, SHA-256 {sha256(out)}")
    if missing:
        typer.echo(f"{missing:,} runs are not there yet", err=True)


@studies.command()
def record(
    folder: Folder,
    rows: Annotated[list[int], typer.Argument(help="Numbers of the rows, as in the column 'row'.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the recordings; FOLDER/recordings unless given.")] = None,
) -> None:
    """Make runs of a study again and record them, for `aspect-control replay` for example."""
    from ..files import output_folder
    from ..studies.shards import study_of
    from ..views.progress import progress_bar

    study = study_of(folder)
    places = [study.place(row) for row in rows]
    target = output_folder(out or folder / "recordings")
    with progress_bar() as progress:
        for index, (row, place) in enumerate(zip(rows, places, strict=True)):
            progress(f"row {row}: {place.law} on {place.scenario}", index / len(rows))
            study.record(*place).save(target / f"{row:06d}-{place.scenario}-{place.law}.npz")
    typer.echo(f"{len(rows)} recordings written to {target}")


def make_runs(study: Study, folder: Path, *, workers: int | None = None, yes: bool = False, **how: Any) -> Any:
    """Make the runs of a study that a folder does not hold yet, and show how it goes on.

    Args:
        study: The study.
        folder: Its folder.
        workers: Number of processes; None for one a processor.
        yes: Whether to go on even if it takes long.
        how: As for `Study.run`.

    Raises:
        ParameterError: If it takes long and was not confirmed.
        AspectControlError: As `Study.run` does.
    """
    from ..checks import whole_number
    from ..studies.engine import MOST_WORKERS
    from ..studies.estimate import time_estimate
    from ..studies.shards import ShardFolder
    from ..views.progress import describe_time, study_progress
    from ..views.screen import confirm_long_run, processors

    workers = processors() if workers is None else whole_number("workers", workers, 1, MOST_WORKERS)
    begun = ShardFolder(study, folder)
    missing = 1.0 if how.get("resume") is False else begun.missing(how.get("shard")) / study.runs
    if missing:
        seconds = missing * time_estimate(study, workers)
        typer.echo(f"{study.describe()}; at most {describe_time(seconds)} with {workers} processes", err=True)
        confirm_long_run(f"a study of {study.runs:,} runs", seconds, "fewer motions, laws or grid values", yes)
    with study_progress() as progress:
        return study.run(folder, workers=workers, progress=progress, **how)
