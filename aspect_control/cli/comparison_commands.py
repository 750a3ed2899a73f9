"""Commands that compare laws on many motions."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from ..exceptions import StudyError
from .application import app, as_json


@app.command()
def survey(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path(
        "results/survey"
    ),
    every: Annotated[
        bool, typer.Option("--all", help="Also check every chain of every example robot against the full model.")
    ] = False,
) -> None:
    """Run the laws on every scenario that ships with the package and compare them."""
    from ..files import output_folder, write_text
    from ..resources import scenario_paths
    from ..scenario import load_scenario
    from ..studies.chain_check import check_chains
    from ..studies.survey import SurveyRow
    from ..studies.survey import survey as run_survey
    from ..views import save_figure, survey_figure, survey_report
    from ..views.progress import progress_bar
    from ..views.screen import show_table

    folder = output_folder(out)
    setups = {name: load_scenario(path).build() for name, path in scenario_paths().items()}

    def keep(rows: list[SurveyRow]) -> None:
        write_text(folder / "survey.json", as_json({"runs": [row.to_dict() for row in rows]}))

    with progress_bar() as progress:
        rows = run_survey(setups, keep, progress)
        checks = check_chains(progress) if every else []
        document = {"runs": [row.to_dict() for row in rows], "chains": [check.to_dict() for check in checks]}
        write_text(folder / "survey.json", as_json(document))
        write_text(folder / "survey.md", survey_report(rows, checks))
        figure = survey_figure(rows)
        save_figure(figure, folder / "survey.png")
        save_figure(figure, folder / "survey.svg")
    show_table(
        ("scenario", "law", "peak torque", "ratio", "aspect", "ended"),
        [
            (
                row.scenario,
                row.controller,
                f"{row.peak_torque:,.1f} N m",
                "" if row.peak_ratio is None else f"{row.peak_ratio:,.2f}",
                "kept" if row.aspect_preserved else "left",
                row.status,
            )
            for row in rows
        ],
    )
    if checks:
        failed = [check for check in checks if check.deviation is None]
        typer.echo(f"{len(checks) - len(failed)} chains agree with the full model, {len(failed)} could not be loaded")
    typer.echo(f"written to {folder}: survey.md, survey.json and the figure")


@app.command()
def compare(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path(
        "results/compare"
    ),
) -> None:
    """Run all laws on the planar arm, Panda and Baxter and compare them."""
    from ..files import output_folder, write_text
    from ..studies.comparison import SCENARIOS, compare_laws
    from ..views import comparison_report, save_figure, torque_figure
    from ..views.progress import progress_bar
    from ..views.screen import show_laws

    folder = output_folder(out)
    summaries = {}
    with progress_bar() as progress:
        for name in SCENARIOS:
            runs, summaries[name] = compare_laws(name, progress)
            write_text(folder / "compare.json", as_json({"scenarios": summaries}))
            figure = torque_figure(runs, name)
            save_figure(figure, folder / f"torques-{name}.png")
            save_figure(figure, folder / f"torques-{name}.svg")
        write_text(folder / "compare.md", comparison_report(summaries))
    for name, summary in summaries.items():
        typer.echo(name)
        show_laws(summary)
    typer.echo(f"written to {folder}: compare.md, compare.json and figures")


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
    workers: Annotated[int | None, typer.Option(help="Number of processes; one a processor unless given.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Go on even if it takes long.")] = False,
) -> None:
    """Test on random motions whether keeping the aspect is necessary for a calm torque."""
    from ..files import output_folder
    from ..studies.hypothesis import hypothesis_study
    from .report_commands import report_on_hypothesis
    from .study_commands import make_runs

    study = hypothesis_study(scenario, samples, seed=seed, dt=dt)
    folder = out or Path("results") / "hypothesis" / study.name
    try:
        make_runs(study, folder, workers=workers, yes=yes)
    except KeyboardInterrupt:
        with suppress(StudyError):  # if nothing is there yet
            report_on_hypothesis([folder], folder, check=False)
        raise
    found = report_on_hypothesis([folder], folder)
    examples = output_folder(folder / "counterexamples")
    for each in found["counterexamples"]:
        run = study.record(each["scenario"], each["sample"], each["law"], each["point"])
        run.save(examples / f"{each['law']}-{each['sample']}.npz")
