"""Compare the cost of pseudoinverses, control ticks and runs with other libraries and bare Pinocchio.

`python benchmarks/pseudoinverse_cost.py --help`, from a checkout with the extra `bench` installed.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

# The literal laws are those that the tests hold the results against.
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from aspect_control.exceptions import AspectControlError
from aspect_control.files import output_folder, write_text
from aspect_control.views import save_figure
from aspect_control.views.progress import progress_bar
from benchmark import benchmark, machine, verdicts
from benchmark.figure import benchmark_figure
from benchmark.report import benchmark_report, show_benchmark


def bench(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path("results/bench"),
    rounds: Annotated[int, typer.Option(min=3, help="Rounds in which what is compared takes turns.")] = 30,
    placo_python: Annotated[
        Path | None, typer.Option(help="A Python that has PlaCo, if its versions clash with those of this one.")
    ] = None,
) -> None:
    """Compare the cost of ticks, pieces and runs, as plain NumPy and compiled, with other libraries and Pinocchio."""
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
    write_text(folder / "bench.json", json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    write_text(folder / "bench.md", benchmark_report(rows, judged, missing, document["machine"]))
    figure = benchmark_figure(rows)
    save_figure(figure, folder / "bench.png")
    save_figure(figure, folder / "bench.svg")
    show_benchmark(rows, judged, missing)
    typer.echo(f"written to {folder}: bench.md, bench.json and the figure")


def main() -> None:
    """Run the benchmark; bad input ends in one line on standard error and exit status 2."""
    try:
        typer.run(bench)
    except AspectControlError as error:
        typer.echo(f"pseudoinverse_cost: error: {error}", err=True)
        sys.exit(2)


if __name__ == "__main__":
    main()
