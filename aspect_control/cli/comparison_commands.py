"""Commands that compare laws on random motions."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated

import typer

from .application import app, as_json

SECONDS_BETWEEN_WRITES = 10.0
"""How often a long command writes what it has computed so far, s."""


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
    from ..files import output_folder, write_text
    from ..scenario import load_scenario
    from ..studies.hypothesis import Experiment, HypothesisResult, examine_hypothesis, time_estimate
    from ..views import hypothesis_figure, hypothesis_report, hypothesis_rows, hypothesis_verdict, save_figure
    from ..views.progress import progress_bar
    from ..views.screen import confirm_long_run, processors, show_table

    experiment = Experiment.of(scenario.stem, load_scenario(scenario), seed=seed, dt=dt)
    workers = processors() if workers is None else workers
    seconds = time_estimate(experiment, samples, workers)
    confirm_long_run(f"a run of {samples:,} samples", seconds, "fewer --samples", yes)
    folder = output_folder(out or Path("results") / "hypothesis" / scenario.stem)
    latest = HypothesisResult(experiment, samples, ())
    written = float("-inf")

    def write_samples(result: HypothesisResult) -> None:
        document = {"scenario": scenario.stem, "seed": seed, "dt": dt, "samples": [s.to_dict() for s in result.samples]}
        write_text(folder / "samples.json", json.dumps(document, ensure_ascii=False, allow_nan=False) + "\n")

    def keep(result: HypothesisResult) -> None:
        nonlocal latest, written
        latest = result
        if time.monotonic() - written > SECONDS_BETWEEN_WRITES:
            write_samples(result)
            written = time.monotonic()

    try:
        with progress_bar() as progress:
            examine_hypothesis(experiment, samples, workers=workers, keep=keep, progress=progress)
    finally:
        if latest.samples:
            write_samples(latest)
            write_text(folder / "hypothesis.json", as_json(latest.to_dict()))
            write_text(folder / "hypothesis.md", hypothesis_report(latest))
            figure = hypothesis_figure(latest)
            save_figure(figure, folder / "hypothesis.png")
            save_figure(figure, folder / "hypothesis.svg")
    examples = output_folder(folder / "counterexamples")
    for each in latest.counterexamples:
        experiment.run(each.index, each.outcome.law).save(examples / f"{each.outcome.law}-{each.index}.npz")
    show_table(
        ("law", "kept: calm", "exploded", "left: calm", "exploded", "calm if left"),
        hypothesis_rows(latest),
    )
    for line in hypothesis_verdict(latest):
        typer.echo(line)
    typer.echo(f"written to {folder}: hypothesis.md, hypothesis.json, samples.json, the figure and counterexamples")
