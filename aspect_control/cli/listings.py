"""Commands that list what there is."""

from __future__ import annotations

from .application import app


@app.command()
def robots() -> None:
    """List the example robots: joints, and the frames that end a chain."""
    from ..arm.sources.examples import example_names, example_overview
    from ..views.screen import show_table

    rows = [example_overview(name) for name in example_names()]
    show_table(
        ("robot", "joints", "frames that end a chain"),
        [(row.name, str(row.joints), row.problem or " ".join(row.end_frames) or "none") for row in rows],
    )


@app.command("controllers")
def list_controllers() -> None:
    """List the laws with their parameters and defaults."""
    from .. import controllers
    from ..views.screen import show_table

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
    from .. import criteria
    from ..views.screen import show_table

    show_table(
        ("criterion", "parameters", "what it is"),
        [
            (name, criteria.describe_parameters(each), next(iter((each.__doc__ or "").strip().splitlines()), ""))
            for name in criteria.available()
            for each in [criteria.find(name)]
        ],
    )
