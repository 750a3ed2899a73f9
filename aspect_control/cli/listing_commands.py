"""Commands that list what there is."""

from __future__ import annotations

from inspect import getdoc
from operator import attrgetter

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


def _add_listing(command: str, room: str, noun: str, what: str) -> None:
    """Add the command that lists what is registered of a kind, with parameters and defaults.

    Args:
        command: Its name.
        room: Where the package has the kind's `available`, `find` and `describe_parameters`.
        noun: What one of them is called.
        what: What they are.
    """

    @app.command(command, help=f"List {what} with parameters and defaults.")
    def listing() -> None:
        import aspect_control

        from ..views.screen import show_table

        kind = attrgetter(room)(aspect_control)
        classes = {name: kind.find(name) for name in kind.available()}
        show_table(
            (noun, "parameters", "what it is"),
            [
                (name, kind.describe_parameters(each), (getdoc(each) or "").partition("\n")[0])
                for name, each in classes.items()
            ],
        )


_add_listing("controllers", "controllers", "law", "the torque laws")
_add_listing("criteria", "criteria", "criterion", "the criteria H(q) that resolved-motion and jmdc can climb,")
_add_listing("trajectories", "trajectories", "trajectory", "the trajectories of the task")
_add_listing("events", "simulation.events", "event", "the events that end a run early,")
_add_listing(
    "integrators", "simulation.integrators", "integrator", "the integrators that move a plant on by one sample,"
)
_add_listing("plants", "plants", "plant", "the plants that a torque moves")
