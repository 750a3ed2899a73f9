"""The command line: parse, call, print."""

from __future__ import annotations

import json
import sys
import time
import warnings
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.exceptions import TyperException

from .exceptions import AspectControlError, DrawingWarning

if TYPE_CHECKING:
    from .scenario import Scenario
    from .views import LiveView
    from .views.scene.server import LiveServer

INTERRUPTED = 130
"""Exit status of a command that was interrupted from the keyboard."""

SECONDS_BETWEEN_WRITES = 10.0
"""How often a long command writes what it has computed so far, s."""

Host = Annotated[str, typer.Option(help="Address that --live listens on.")]
Port = Annotated[int, typer.Option(help="Port that --live listens on; if it is taken, the next free one.")]

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
    """Run the paper's laws on its trajectory A and hold its claims against the results."""
    from .analysis import summarize
    from .analysis import trajectory_a as paper
    from .analysis.section4 import claims
    from .checks import positive
    from .files import output_folder, write_text
    from .views import comparison_figure, law_name, replay, reproduction_report, run_figure, save_figure
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
        summary = {law: summarize(run) for law, run in result.all_runs.items()}
        verdicts = claims(result)
        document = {
            "trajectory": result.runs["jmdc"].info.trajectory,
            "dt": dt,
            "versions": result.runs["jmdc"].info.versions,
            "controllers": summary,
            "continuous_limit": result.limit.to_dict(),
        }
        write_text(folder / "summary.json", _json(document))
        write_text(folder / "report.md", reproduction_report(result, verdicts))
        for name, (heading, law) in paper.FIGURES.items():
            progress(heading, 1.0)
            figure = run_figure(result.runs[law], f"{heading}: {law_name(law)}, trajectory A")
            save_figure(figure, folder / f"{name}.png")
            save_figure(figure, folder / f"{name}.svg")
        figure = comparison_figure(result.all_runs)
        save_figure(figure, folder / "comparison.png")
        save_figure(figure, folder / "comparison.svg")
        progress("replay", 1.0)
        replay(result.all_runs, folder / "replay.html")
    show_claims(verdicts)
    show_laws(summary)
    typer.echo(f"written to {folder}: report.md, summary.json, replay.html, figures and runs")


@app.command()
def run(
    scenario: Annotated[
        Path, typer.Argument(help="A TOML file, or the name of a scenario that ships with the package.")
    ],
    out: Annotated[Path | None, typer.Option(help="Folder for the results; results/NAME unless given.")] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="Change a field: simulation.dt=5e-4, controller.kp=200, controller.jmdc.kappa=0."),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="Show the arms in a browser, in real time, while they are simulated.")
    ] = False,
    host: Host = "127.0.0.1",
    port: Port = 7000,
) -> None:
    """Run the laws of a scenario; write runs, figures, a replay and a summary; warn of a border of the aspect ahead."""
    from .analysis import summarize, warn_of_border_ahead
    from .controllers import Controller
    from .files import output_folder, write_text
    from .scenario import load_scenario
    from .simulation import Run
    from .views import comparison_figure, law_name, plain_text, replay, run_figure, save_figure
    from .views.screen import progress_bar, show_laws

    described = load_scenario(scenario, settings or [])
    described.require_fits()
    folder = output_folder(out or Path("results") / scenario.stem)
    view = _live_view(described, host, port) if live else None
    runs: dict[str, Run] = {}

    def keep(label: str, finished: Run) -> None:
        runs[label] = finished
        finished.save(folder / f"{label}.npz")

    def look_ahead(label: str, law: Controller) -> None:
        q0, trajectory = described.start_configuration(law.arm), described.trajectory.build()
        dt, v0 = described.simulation.dt, described.start.velocities
        warn_of_border_ahead(law, trajectory, q0=q0, v0=v0, dt=dt, label=label)

    with progress_bar() as progress:
        with view or nullcontext():
            described.run_each(keep, progress, look_ahead, None if view is None else view.watch)
        progress("summary and figures", 1.0)
        summary = {label: summarize(each) for label, each in runs.items()}
        write_text(folder / "summary.json", _json({"scenario": scenario.stem, "controllers": summary}))
        for label, each in runs.items():
            figure = run_figure(each, f"{plain_text(scenario.stem)}: {law_name(label)}")
            save_figure(figure, folder / f"{label}.png")
            save_figure(figure, folder / f"{label}.svg")
        figure = comparison_figure(runs, plain_text(scenario.stem))
        save_figure(figure, folder / "comparison.png")
        save_figure(figure, folder / "comparison.svg")
        progress("replay", 1.0)
        replay(runs, folder / "replay.html")
    show_laws(summary)
    typer.echo(f"written to {folder}: summary.json, replay.html, figures and runs")


@app.command("replay")
def replay_runs(
    files: Annotated[list[Path], typer.Argument(help="Recorded runs, shown side by side.", metavar="RUN.npz...")],
    out: Annotated[Path, typer.Option(help="The page to write.")] = Path("replay.html"),
    speed: Annotated[float, typer.Option(help="Seconds of motion shown in a second.")] = 1.0,
    live: Annotated[
        bool, typer.Option("--live", help="Serve the runs and play them in real time; write nothing.")
    ] = False,
    host: Host = "127.0.0.1",
    port: Port = 7000,
) -> None:
    """Show recorded runs moving: as one HTML file that plays offline, or live in a browser."""
    from .simulation import Run
    from .views import LiveReplay, replay

    runs = [Run.load(file) for file in files]
    if not live:
        page = replay(runs, out, speed=speed)
        typer.echo(f"written to {out}: {len(page.page) / 1e6:.1f} MB; open it in a browser")
        return
    with LiveReplay(runs, speed=speed, host=host, port=port) as view:
        for note in view.notes:
            warnings.warn(note, DrawingWarning, stacklevel=1)
        _say_where(view, port)
        try:
            view.wait_for_viewer()
            while True:
                view.play()
        except KeyboardInterrupt:
            typer.echo("stopped")


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
    from .analysis.chain_check import check_chains
    from .analysis.survey import SurveyRow
    from .analysis.survey import survey as run_survey
    from .files import output_folder, write_text
    from .resources import scenario_paths
    from .scenario import load_scenario
    from .views import save_figure, survey_figure, survey_report
    from .views.screen import progress_bar, show_table

    folder = output_folder(out)
    scenarios = {name: load_scenario(path) for name, path in scenario_paths().items()}

    def keep(rows: list[SurveyRow]) -> None:
        write_text(folder / "survey.json", _json({"runs": [row.to_dict() for row in rows]}))

    with progress_bar() as progress:
        rows = run_survey(scenarios, keep, progress)
        checks = check_chains(progress) if every else []
        document = {"runs": [row.to_dict() for row in rows], "chains": [check.to_dict() for check in checks]}
        write_text(folder / "survey.json", _json(document))
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
    from .analysis.comparison import SCENARIOS, compare_laws
    from .files import output_folder, write_text
    from .views import comparison_report, save_figure, torque_figure
    from .views.screen import progress_bar, show_laws

    folder = output_folder(out)
    summaries = {}
    with progress_bar() as progress:
        for name in SCENARIOS:
            runs, summaries[name] = compare_laws(name, progress)
            write_text(folder / "compare.json", _json({"scenarios": summaries}))
            figure = torque_figure(runs, name)
            save_figure(figure, folder / f"torques-{name}.png")
            save_figure(figure, folder / f"torques-{name}.svg")
        write_text(folder / "compare.md", comparison_report(summaries))
    for name, summary in summaries.items():
        typer.echo(name)
        show_laws(summary)
    typer.echo(f"written to {folder}: compare.md, compare.json and figures")


@app.command()
def start(
    scenario: Annotated[
        Path, typer.Argument(help="A TOML file, or the name of a scenario that ships with the package.")
    ],
    criterion: Annotated[
        str, typer.Option(help="What is to be large; `aspect-control criteria` lists the names.")
    ] = "minor-measure",
    within: Annotated[
        float | None, typer.Option(help="How far each joint may move, rad (m for prismatic joints); any unless given.")
    ] = None,
    count: Annotated[int | None, typer.Option(help="How many random postures to find.")] = None,
    seed: Annotated[int, typer.Option(help="Seed of the random numbers.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Folder for start.json and a figure; none unless given.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="Change a field of the scenario: robot.task=pose.")
    ] = None,
) -> None:
    """Choose the posture that is best by a criterion, the minor measure unless given, for the start of a scenario."""
    from .aspects import choose_start
    from .files import output_folder, write_text
    from .scenario import load_scenario
    from .views import plain_text, save_figure, self_motion_figure
    from .views.screen import show_start

    described = load_scenario(scenario, settings or [])
    arm = described.arm()
    q = described.start_configuration(arm)
    folder = None if out is None else output_folder(out)
    chosen = choose_start(
        arm,
        arm.task_position(q),
        criterion=criterion,
        reference=q,
        within=float("inf") if within is None else within,
        count=count,
        seed=seed,
    )
    show_start(chosen)
    if folder is not None:
        write_text(folder / "start.json", _json({"scenario": scenario.stem, **chosen.to_dict()}))
        if chosen.curves:
            figure = self_motion_figure(chosen.curves[0], plain_text(f"{scenario.stem}: self-motion through the start"))
            save_figure(figure, folder / "self-motion.png")
            save_figure(figure, folder / "self-motion.svg")
        typer.echo(f"written to {folder}: start.json" + (" and self-motion figure" if chosen.curves else ""))


@app.command()
def atlas(
    scenario: Annotated[
        Path, typer.Argument(help="A TOML file, or the name of a scenario that ships with the package.")
    ] = Path("planar3r"),
    joints: Annotated[
        tuple[str, str] | None,
        typer.Option(help="The two joints of the slice; those that change most signs of minors unless given."),
    ] = None,
    self_motion: Annotated[
        str | None, typer.Option(help="Slice along the self-motion and away from it by this joint, instead.")
    ] = None,
    resolution: Annotated[int, typer.Option(help="Number of cells along each side.")] = 240,
    out: Annotated[Path | None, typer.Option(help="Folder for the results; results/atlas/NAME unless given.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Go on even if it takes long.")] = False,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="Change a field of the scenario: robot.task=pose.")
    ] = None,
) -> None:
    """Draw aspects, borders and minor measure over a slice of configurations, and the laws' paths over them."""
    from .analysis.atlas import atlas_record
    from .aspects import JointSlice, SelfMotionSlice, compute_atlas, describe_time, estimated_time
    from .aspects.atlas import LONG
    from .exceptions import ParameterError
    from .files import output_folder, write_text
    from .scenario import load_scenario
    from .views import atlas_figure, plain_text, save_figure, stability_figure
    from .views.screen import progress_bar, show_atlas

    if joints is not None and self_motion is not None:
        raise ParameterError("give either --joints or --self-motion, not both")
    described = load_scenario(scenario, settings or [])
    described.require_fits()
    arm = described.arm()
    q = described.start_configuration(arm)
    slice_ = JointSlice(arm, q, joints) if self_motion is None else SelfMotionSlice(arm, q, self_motion)
    seconds = estimated_time(slice_, resolution)
    if seconds > LONG and not yes:
        raise ParameterError(
            f"a resolution of {resolution} takes about {describe_time(seconds)}: "
            "give --yes to go on, or a lower --resolution"
        )
    folder = output_folder(out or Path("results") / "atlas" / scenario.stem)
    with progress_bar() as progress:
        computed = compute_atlas(slice_, resolution, lambda part: progress("slice", part))
        runs = described.run(progress)
        progress("figures", 1.0)
        record = atlas_record(computed, runs)
        write_text(folder / "atlas.json", _json({"scenario": scenario.stem, **record}))
        title = plain_text(scenario.stem)
        figures = {"atlas": atlas_figure(computed, runs, f"{title}: aspects and minor measure")}
        if computed.stability is not None:
            figures["stability"] = stability_figure(computed, runs, f"{title}: where the self-motion feeds itself")
        for name, figure in figures.items():
            save_figure(figure, folder / f"{name}.png")
            save_figure(figure, folder / f"{name}.svg")
    show_atlas(record)
    typer.echo(f"written to {folder}: atlas.json and figures")


@app.command()
def bench(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path("results/bench"),
    rounds: Annotated[int, typer.Option(min=3, help="Rounds in which what is compared takes turns.")] = 30,
    placo_python: Annotated[
        Path | None, typer.Option(help="A Python that has PlaCo, if its versions clash with those of this one.")
    ] = None,
) -> None:
    """Compare the cost of pseudoinverses, control ticks and runs with other libraries and bare Pinocchio."""
    from .benchmark import benchmark, machine, verdicts
    from .files import output_folder, write_text
    from .views import benchmark_figure, benchmark_report, save_figure
    from .views.screen import progress_bar, show_benchmark

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
    write_text(folder / "bench.json", _json(document))
    write_text(folder / "bench.md", benchmark_report(rows, judged, missing, document["machine"]))
    figure = benchmark_figure(rows)
    save_figure(figure, folder / "bench.png")
    save_figure(figure, folder / "bench.svg")
    show_benchmark(rows, judged, missing)
    typer.echo(f"written to {folder}: bench.md, bench.json and the figure")


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
    from .analysis.hypothesis import Experiment, HypothesisResult, examine_hypothesis, time_estimate
    from .exceptions import ParameterError
    from .files import output_folder, write_text
    from .scenario import load_scenario
    from .views import hypothesis_figure, hypothesis_report, hypothesis_rows, hypothesis_verdict, save_figure
    from .views.screen import LONG, describe_time, processors, progress_bar, show_table

    experiment = Experiment.of(scenario.stem, load_scenario(scenario), seed=seed, dt=dt)
    workers = processors() if workers is None else workers
    seconds = time_estimate(experiment, samples, workers)
    if seconds > LONG and not yes:
        raise ParameterError(
            f"{samples:,} samples take about {describe_time(seconds)}: give --yes to go on, or fewer --samples"
        )
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
            write_text(folder / "hypothesis.json", _json(latest.to_dict()))
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


@app.command()
def robots() -> None:
    """List the example robots: joints, and the frames that end a chain."""
    from .examples import example_names, example_overview
    from .views.screen import show_table

    rows = [example_overview(name) for name in example_names()]
    show_table(
        ("robot", "joints", "frames that end a chain"),
        [(row.name, str(row.joints), row.problem or " ".join(row.end_frames) or "none") for row in rows],
    )


@app.command("controllers")
def list_controllers() -> None:
    """List the laws with their parameters and defaults."""
    from . import controllers
    from .views.screen import show_table

    show_table(
        ("law", "parameters", "what it is"),
        [
            (name, controllers.describe_parameters(law), next(iter((law.__doc__ or "").strip().splitlines()), ""))
            for name in controllers.available()
            for law in [controllers.find(name)]
        ],
    )


@app.command("criteria")
def list_criteria() -> None:
    """List the criteria H(q) that resolved-motion and jmdc can climb, with their parameters and defaults."""
    from . import criteria
    from .views.screen import show_table

    show_table(
        ("criterion", "parameters", "what it is"),
        [
            (name, criteria.describe_parameters(each), next(iter((each.__doc__ or "").strip().splitlines()), ""))
            for name in criteria.available()
            for each in [criteria.find(name)]
        ],
    )


def main() -> None:
    """Run the command line; bad input ends in one line on standard error and exit status 2."""
    warnings.showwarning = _show_warning
    try:
        status = app(standalone_mode=False)
    except AspectControlError as error:
        _fail(str(error))
    except TyperException as error:
        _fail(error.format_message())
    else:
        if status == INTERRUPTED:
            typer.echo("aspect-control: interrupted; what was written stays", err=True)
        sys.exit(status)


def _live_view(described: Scenario, host: str, port: int) -> LiveView:
    """Serve the arms of a scenario at their start and wait until a browser shows them."""
    from .views import LiveView

    arm = described.arm()
    view = LiveView(
        arm,
        list(described.laws(arm)),
        described.start_configuration(arm),
        described.trajectory.build(),
        host=host,
        port=port,
    )
    for note in view.notes:
        warnings.warn(note, DrawingWarning, stacklevel=1)
    _say_where(view, port)
    view.wait_for_viewer()
    return view


def _say_where(view: LiveServer, port: int) -> None:
    taken = f"port {port} is taken; " if port not in (0, view.port) else ""
    typer.echo(f"{taken}open {view.url} in a browser; Ctrl-C stops")


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    typer.echo(f"aspect-control: warning: {' '.join(str(message).split())}", err=True)


def _json(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _fail(message: str) -> None:
    typer.echo(f"aspect-control: error: {' '.join(message.split())}", err=True)
    sys.exit(2)
