"""Commands about postures, whatever the motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .application import app, as_json


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
    from ..aspects import choose_start
    from ..files import output_folder, write_text
    from ..scenario import load_scenario
    from ..views import plain_text, save_figure, self_motion_figure
    from ..views.screen import show_start

    setup = load_scenario(scenario, settings or []).build(laws=())
    arm, q = setup.arm, setup.q0
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
        write_text(folder / "start.json", as_json({"scenario": scenario.stem, **chosen.to_dict()}))
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
    from ..analysis.atlas_record import atlas_record
    from ..aspects import JointSlice, SelfMotionSlice, compute_atlas, estimated_time
    from ..exceptions import ParameterError
    from ..files import output_folder, write_text
    from ..scenario import load_scenario
    from ..views import atlas_figure, plain_text, save_figure, stability_figure
    from ..views.progress import progress_bar
    from ..views.screen import confirm_long_run, show_atlas

    if joints is not None and self_motion is not None:
        raise ParameterError("give either --joints or --self-motion, not both")
    setup = load_scenario(scenario, settings or []).build()
    arm, q = setup.arm, setup.q0
    slice_ = JointSlice(arm, q, joints) if self_motion is None else SelfMotionSlice(arm, q, self_motion)
    seconds = estimated_time(slice_, resolution)
    confirm_long_run(f"a resolution of {resolution}", seconds, "a lower --resolution", yes)
    folder = output_folder(out or Path("results") / "atlas" / scenario.stem)
    with progress_bar() as progress:
        computed = compute_atlas(slice_, resolution, lambda part: progress("slice", part))
        runs = setup.run(progress)
        progress("figures", 1.0)
        record = atlas_record(computed, runs)
        write_text(folder / "atlas.json", as_json({"scenario": scenario.stem, **record}))
        title = plain_text(scenario.stem)
        figures = {"atlas": atlas_figure(computed, runs, f"{title}: aspects and minor measure")}
        if computed.stability is not None:
            figures["stability"] = stability_figure(computed, runs, f"{title}: where the self-motion feeds itself")
        for name, figure in figures.items():
            save_figure(figure, folder / f"{name}.png")
            save_figure(figure, folder / f"{name}.svg")
    show_atlas(record)
    typer.echo(f"written to {folder}: atlas.json and figures")
