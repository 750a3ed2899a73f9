"""The command that tests the hypothesis on random motions."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from ..exceptions import StudyError
from .application import app
from .study_commands import Workers, make_runs


@app.command()
def hypothesis(
    scenario: Annotated[
        Path, typer.Argument(help="A TOML file, or the name of a scenario, whose arm, line and laws are taken.")
    ] = Path("planar3r"),
    samples: Annotated[int, typer.Option(help="Number of random motions.")] = 300,
    seed: Annotated[int, typer.Option(help="Seed of the draws; a motion depends on it and on its index alone.")] = 0,
    dt: Annotated[float, typer.Option(help="Sampling time, s.")] = 1e-3,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; results/hypothesis/NAME unless given.")
    ] = None,
    workers: Workers = None,
    yes: Annotated[bool, typer.Option("--yes", help="Go on even if it takes long.")] = False,
) -> None:
    """Test on random motions whether keeping the aspect is necessary for a calm torque."""
    from ..files import output_folder
    from ..studies.hypothesis import hypothesis_study
    from ..studies.shards import read_folder
    from ..views import hypothesis_rows, hypothesis_verdict
    from ..views.progress import progress_bar
    from ..views.reports.hypothesis_files import write_hypothesis
    from ..views.screen import show_table

    study = hypothesis_study(scenario, samples, seed=seed, dt=dt)
    folder = out or Path("results") / "hypothesis" / study.name
    try:
        table = make_runs(study, folder, workers=workers, yes=yes)
    except KeyboardInterrupt:
        with suppress(StudyError):  # if nothing is there yet
            write_hypothesis(study, read_folder(folder), folder, lambda label, part: None, check=False)
        raise
    with progress_bar() as progress:
        written = write_hypothesis(study, table, folder, progress)
    found = json.loads((folder / "hypothesis.json").read_text(encoding="utf-8"))
    examples = output_folder(folder / "counterexamples")
    for each in found["counterexamples"]:
        run = study.record(each["scenario"], each["sample"], each["law"], each["point"])
        run.save(examples / f"{each['law']}-{each['sample']}.npz")
    rows = hypothesis_rows(found["conditions"][0])
    show_table(("law", "kept: calm", "exploded", "left: calm", "exploded", "calm if left"), rows)
    for line in hypothesis_verdict(found["conditions"]):
        typer.echo(line)
    typer.echo(f"written to {folder}: {', '.join(written)} and counterexamples")
