"""The command that tries wrong input on every law, with a guard and without."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .application import app, as_json


@app.command()
def safety(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path(
        "results/safety"
    ),
    sequences: Annotated[int, typer.Option(help="Number of random sequences of faults.")] = 1000,
    seed: Annotated[int, typer.Option(help="Seed of the draws; a sequence depends on it and on its index alone.")] = 0,
) -> None:
    """Try wrong input on every law, with a guard around it and without."""
    from ..checks import whole_number
    from ..files import output_folder, write_text
    from ..studies.safety import hostile_sequences, safety_table
    from ..views import safety_report, sequence_lines
    from ..views.progress import progress_bar
    from ..views.screen import show_table

    whole_number("sequences", sequences, 0)
    whole_number("seed", seed, 0)
    folder = output_folder(out)
    with progress_bar() as progress:
        rows = safety_table(progress)
        found = hostile_sequences(sequences, seed, progress)
    document = {"faults": [row.to_dict() for row in rows], "seed": seed, "random": found.to_dict()}
    write_text(folder / "safety.json", as_json(document))
    write_text(folder / "safety.md", safety_report(rows, found))
    show_table(
        ("fault", "law", "without a guard", "torque", "with", "ends"),
        [
            (row.fault, row.law, row.bare, f"{row.bare_torque:,.1f} N m", f"{row.torque:,.1f} N m", row.state)
            for row in rows
        ],
    )
    for line in sequence_lines(found):
        typer.echo(line)
    typer.echo(f"written to {folder}: safety.md and safety.json")
