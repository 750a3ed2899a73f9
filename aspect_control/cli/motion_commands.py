"""Commands that make runs or show them."""

from __future__ import annotations

import warnings
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..exceptions import DrawingWarning
from .application import app, as_json

if TYPE_CHECKING:
    from ..scenario import Setup
    from ..views import LiveView
    from ..views.replays.scene.server import LiveServer

Host = Annotated[str, typer.Option(help="Address that --live listens on.")]
Port = Annotated[int, typer.Option(help="Port that --live listens on; if it is taken, the next free one.")]


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it is not there.")] = Path("results"),
    dt: Annotated[float, typer.Option(help="Sampling time, s.")] = 1e-3,
) -> None:
    """Run the paper's laws on its trajectory A and hold its claims against the results."""
    from ..analysis import summarize
    from ..checks import positive
    from ..files import output_folder, write_text
    from ..studies.paper import claims
    from ..studies.paper import trajectory_a as paper
    from ..views import comparison_figure, law_name, replay, reproduction_report, run_figure, save_figure
    from ..views.progress import progress_bar
    from ..views.screen import show_claims, show_laws

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
        write_text(folder / "summary.json", as_json(document))
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
    """Run the laws of a scenario; write runs, figures, a replay and a summary; warn of a border of the aspect ahead.

    Ctrl-C ends it: the runs so far are kept, the last one up to then, with a summary.
    """
    from ..analysis import summarize, warn_of_border_ahead
    from ..controllers import Controller
    from ..files import output_folder, write_text
    from ..scenario import load_scenario
    from ..simulation import Run
    from ..views import comparison_figure, law_name, plain_text, replay, run_figure, save_figure
    from ..views.progress import progress_bar
    from ..views.screen import show_laws

    setup = load_scenario(scenario, settings or []).build()
    folder = output_folder(out or Path("results") / scenario.stem)
    view = _live_view(setup, host, port) if live else None
    runs: dict[str, Run] = {}

    def keep(label: str, finished: Run) -> None:
        runs[label] = finished
        finished.save(folder / f"{label}.npz")

    def summarised() -> dict[str, Any]:
        summary = {label: summarize(each) for label, each in runs.items()}
        write_text(folder / "summary.json", as_json({"scenario": scenario.stem, "controllers": summary}))
        return summary

    def look_ahead(label: str, law: Controller) -> None:
        warn_of_border_ahead(law, setup.trajectory, q0=setup.q0, v0=setup.v0, dt=setup.dt, label=label)

    with progress_bar() as progress:
        try:
            with view or nullcontext():
                setup.run_each(keep, progress, look_ahead, None if view is None else view.watch)
        except KeyboardInterrupt:
            if runs:
                summarised()
            raise
        progress("summary and figures", 1.0)
        summary = summarised()
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
    from ..simulation import Run
    from ..views import LiveReplay, replay

    runs = [Run.load(file) for file in files]
    if not live:
        page = replay(runs, out, speed=speed)
        typer.echo(f"written to {out}: {len(page.page) / 1e6:.1f} MB; open it in a browser")
        return
    with LiveReplay(runs, speed=speed, host=host, port=port) as view:
        for note in view.notes:
            warnings.warn(note, DrawingWarning, stacklevel=1)
        try:
            _say_where(view, port)
            view.wait_for_viewer()
            while True:
                view.play()
        except KeyboardInterrupt:
            typer.echo("stopped")


def _live_view(setup: Setup, host: str, port: int) -> LiveView:
    """Serve the arms of a scenario at their start and wait until a browser shows them."""
    from ..views import LiveView

    view = LiveView(setup.arm, list(setup.laws), setup.q0, setup.trajectory, host=host, port=port)
    for note in view.notes:
        warnings.warn(note, DrawingWarning, stacklevel=1)
    _say_where(view, port)
    view.wait_for_viewer()
    return view


def _say_where(view: LiveServer, port: int) -> None:
    taken = f"port {port} is taken; " if port not in (0, view.port) else ""
    typer.echo(f"{taken}open {view.url} in a browser; Ctrl-C stops")
