"""Runs as a moving scene in one HTML file: meshcat's viewer with everything in it."""

from __future__ import annotations

import html
import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from ...exceptions import DrawingWarning
from ...files import write_text
from ...simulation import Run
from ..frames import labelled_runs
from .scene.page import build_page
from .scene.replay_scene import build_scene


@dataclass(frozen=True)
class Replay:
    """A page that shows runs; in a notebook it shows itself.

    Attributes:
        page: The whole HTML page.
        notes: What could not be drawn as it should, one sentence each.
    """

    page: str = field(repr=False)
    notes: tuple[str, ...] = ()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page, which plays offline in any browser.

        Args:
            path: The file to write, usually ending in `.html`.

        Raises:
            OutputError: If it cannot be written.
        """
        write_text(path, self.page)

    def _repr_html_(self) -> str:
        """Return the page in a frame, for notebooks."""
        frame = '<iframe srcdoc="{}" style="width: 100%; height: 640px; border: 1px solid #d4d9e0"></iframe>'
        return frame.format(html.escape(self.page))


def replay(
    runs: Run | Iterable[Run] | Mapping[str, Run], path: str | os.PathLike[str] | None = None, *, speed: float = 1.0
) -> Replay:
    """Show runs side by side and in step, with the robots' own meshes, in a page of meshcat's viewer.

    Each arm is drawn with its desired path and the trace of its tip; its links take on colour as their torque nears
    and passes the limit, and bars show the torque of each joint. A ring marks where a minor changes sign, that is,
    where the arm leaves its aspect. A run that ended early, or is not finite to its end, stops where it did and says
    so. An arm whose URDF or meshes are gone is drawn as a stick figure, with a `DrawingWarning`.

    Args:
        runs: A run, several, or runs by their labels.
        path: The HTML file to write; None to write nothing. It needs no network and no other file.
        speed: Seconds of motion shown in a second; 0.5 for slow motion.

    Returns:
        The page, which a notebook shows inline.

    Raises:
        ParameterError: If there is no run, something is no run, a run has no samples or `speed` is not above zero.
        NonFiniteError: If the first sample of a run is not finite.
        TooManyMinorsError: If a Jacobian has more minors than can be handled.
        OutputError: If the file cannot be written.
    """
    shown = labelled_runs(runs)
    scene = build_scene(shown, speed)
    for note in scene.notes:
        warnings.warn(note, DrawingWarning, stacklevel=2)
    page = Replay(build_page(" and ".join(shown), scene.commands, scene.data), tuple(scene.notes))
    if path is not None:
        page.save(path)
    return page
