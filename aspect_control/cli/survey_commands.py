"""Commands for the studies that ship with the package."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .application import app
from .study_commands import Workers, make_runs


@app.command()
def survey(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path(
        "results/survey"
    ),
    workers: Workers = None,
    every: Annotated[
        bool, typer.Option("--all", help="Also check every chain of every example robot against the full model.")
    ] = False,
) -> None:
    """Run the laws on every scenario that ships with the package and compare them.

    Runs that the folder holds already are not made again.
    """
    from ..studies.chain_check import check_chains
    from ..studies.survey import survey_rows, survey_study
    from ..views.progress import progress_bar
    from ..views.reports.report_files import write_survey
    from ..views.screen import show_table

    study = survey_study()
    table = make_runs(study, out, workers=workers)
    with progress_bar() as progress:
        checks = check_chains(progress) if every else []
        written = write_survey(study, table, out, progress, checks)
    show_table(
        ("scenario", "law", "peak torque", "ratio", "aspect", "ended"),
        [
            (
                row.scenario,
                row.controller,
                "" if row.peak_torque is None else f"{row.peak_torque:,.1f} N m",
                "" if row.peak_ratio is None else f"{row.peak_ratio:,.2f}",
                {True: "kept", False: "left", None: ""}[row.aspect_preserved],
                row.status,
            )
            for row in survey_rows(table)
        ],
    )
    if checks:
        failed = [check for check in checks if check.deviation is None]
        typer.echo(f"{len(checks) - len(failed)} chains agree with the full model, {len(failed)} could not be loaded")
    typer.echo(f"written to {out}: {', '.join(written)}")


@app.command()
def compare(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path(
        "results/compare"
    ),
    workers: Workers = None,
) -> None:
    """Run all laws on the planar arm, Panda and Baxter and compare them.

    Runs that the folder holds already are not made again, but for the figures of their torques.
    """
    from ..studies.comparison import comparison_study
    from ..views.progress import progress_bar
    from ..views.reports.report_files import write_report
    from ..views.screen import quantity, show_table

    study = comparison_study()
    table = make_runs(study, out, workers=workers)
    with progress_bar() as progress:
        written = write_report(study, table, out, progress)
    show_table(
        ("scenario", "law", "peak torque", "sign changes", "tracking error", "ended"),
        [
            (
                run["scenario"],
                run["law"],
                "" if run["peak_torque"] is None else f"{quantity(run['peak_torque'])} N m",
                "" if run["sign_changes"] is None else str(run["sign_changes"]),
                "" if run["tracking_error_max"] is None else f"{1e3 * run['tracking_error_max']:.2g} mm",
                run["status"],
            )
            for run in table.to_pylist()
        ],
    )
    typer.echo(f"written to {out}: {', '.join(written)}")
