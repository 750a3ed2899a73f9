"""The command line: parse, call, print."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer
from typer.exceptions import TyperException

from .exceptions import AspectControlError

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


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path("results"),
    dt: Annotated[float, typer.Option(help="Sampling time, s.")] = 1e-3,
) -> None:
    """Run four laws on the paper's trajectory A and hold its claims against the results."""
    from .analysis import summarize
    from .analysis import trajectory_a as paper
    from .analysis.section4 import claims
    from .checks import positive
    from .files import output_folder, write_text
    from .views import comparison_figure, law_name, reproduction_report, run_figure, save_figure
    from .views.screen import progress_bar, show_claims, show_laws

    dt = positive("--dt", dt, "s")
    folder = output_folder(out)
    with progress_bar() as progress:
        result = paper.reproduce(
            dt,
            keep=lambda law, run: run.save(folder / f"{law}.npz"),
            progress=lambda label, part: progress(label, part),
        )
        progress("summary and report", 1.0)
        summary = {law: summarize(run) for law, run in result.runs.items()}
        verdicts = claims(result)
        document = {
            "trajectory": result.runs["jmdc"].info.trajectory,
            "dt": dt,
            "versions": result.runs["jmdc"].info.versions,
            "controllers": summary,
            "continuous_limit": result.limit.to_dict(),
        }
        write_text(folder / "summary.json", json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
        write_text(folder / "report.md", reproduction_report(result, verdicts))
        for name, (heading, law) in paper.FIGURES.items():
            progress(heading, 1.0)
            figure = run_figure(result.runs[law], f"{heading}: {law_name(law)}, trajectory A")
            save_figure(figure, folder / f"{name}.png")
            save_figure(figure, folder / f"{name}.svg")
        figure = comparison_figure(result.runs)
        save_figure(figure, folder / "comparison.png")
        save_figure(figure, folder / "comparison.svg")
    show_claims(verdicts)
    show_laws(summary)
    typer.echo(f"written to {folder}: report.md, summary.json, figures and runs")


def main() -> None:
    """Run the command line; bad input ends in one line on standard error and exit status 2."""
    try:
        status = app(standalone_mode=False)
    except AspectControlError as error:
        _fail(str(error))
    except TyperException as error:
        _fail(error.format_message())
    except (KeyboardInterrupt, typer.Abort):
        typer.echo("aspect-control: interrupted; what was written stays", err=True)
        sys.exit(130)
    else:
        sys.exit(status)


def _fail(message: str) -> None:
    typer.echo(f"aspect-control: error: {' '.join(message.split())}", err=True)
    sys.exit(2)
