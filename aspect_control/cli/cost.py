"""The command about cost."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .application import app, as_json


@app.command()
def bench(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path("results/bench"),
    rounds: Annotated[int, typer.Option(min=3, help="Rounds in which what is compared takes turns.")] = 30,
    placo_python: Annotated[
        Path | None, typer.Option(help="A Python that has PlaCo, if its versions clash with those of this one.")
    ] = None,
) -> None:
    """Compare the cost of ticks, pieces and runs, as plain NumPy and compiled, with other libraries and Pinocchio."""
    from ..benchmark import benchmark, machine, verdicts
    from ..files import output_folder, write_text
    from ..views import benchmark_figure, benchmark_report, save_figure
    from ..views.screen import progress_bar, show_benchmark

    folder = output_folder(out)
    with progress_bar() as progress:
        rows, missing = benchmark(rounds, placo_python, progress)
    judged = verdicts(rows)
    document: dict[str, Any] = {
        "machine": machine(),
        "rounds": rounds,
        "not_installed": missing,
        "targets": [each.to_dict() for each in judged],
        "rows": [row.to_dict() for row in rows],
    }
    write_text(folder / "bench.json", as_json(document))
    write_text(folder / "bench.md", benchmark_report(rows, judged, missing, document["machine"]))
    figure = benchmark_figure(rows)
    save_figure(figure, folder / "bench.png")
    save_figure(figure, folder / "bench.svg")
    show_benchmark(rows, judged, missing)
    typer.echo(f"written to {folder}: bench.md, bench.json and the figure")
