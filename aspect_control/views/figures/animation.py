"""Runs as moving pictures for papers and READMEs."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Mapping
from typing import Any

from ...checks import file_path, known_name, positive
from ...exceptions import OutputError
from ...files import atomic_path
from ...simulation import Run
from ..frames import FRAME_RATE, frame_times, labelled_runs
from ..style import style
from .moving_picture import MovingPicture

RATES = {".gif": 25, ".mp4": int(FRAME_RATE)}
"""Frames a second of each format; GIF counts time in hundredths of a second."""

HOLD = 1.0
"""How long the last frame stands, s."""


def animate(
    runs: Run | Iterable[Run] | Mapping[str, Run],
    path: str | os.PathLike[str],
    *,
    speed: float = 1.0,
    title: str = "",
) -> None:
    """Write runs as a moving picture, side by side and in step.

    Each arm is drawn as links and joints, in its plane or, if it moves in space, above its shadow, with the desired
    path and the trace of its tip, all on the same scales. A panel is tinted when its arm's aspect changes. Below are
    the torques: of one run those of its joints, of several the largest of each, on a logarithmic scale if they explode.
    A run that ended early, or is not finite to its end, stops where it did and says so. The last frame stands for
    `HOLD`.

    Args:
        runs: A run, several, or runs by their labels.
        path: The file to write: `.gif`, 25 frames a second, put together in memory at about 2 MB a frame; or `.mp4`,
            30 frames a second, which needs ffmpeg.
        speed: Seconds of motion shown in a second; 0.5 for slow motion.
        title: Heading; the time is shown beside it.

    Raises:
        ParameterError: If there is no run, something is no run, a run has no samples or `speed` is not above zero.
        NonFiniteError: If the first sample of a run is not finite.
        TooManyMinorsError: If a Jacobian has more minors than can be handled.
        UnknownNameError: If the suffix is none of those that exist.
        OutputError: If the file cannot be written, or ffmpeg is needed and missing.
    """
    from matplotlib.figure import Figure

    speed = positive("speed", speed)
    shown = labelled_runs(runs)
    suffix = file_path("the moving picture", path, OutputError).suffix.lower()
    rate = RATES[known_name(suffix, RATES, "format of a moving picture", context=str(path))]
    writer = _writer(suffix, rate, path)
    with style(), atomic_path(path) as temporary:
        drawing = MovingPicture(shown, speed, title)
        times = frame_times(list(shown.values()), rate, speed)
        picture = Figure(figsize=drawing.figure.get_size_inches(), dpi=drawing.figure.dpi)
        image = picture.figimage(drawing.frame(times[0]))
        try:
            with writer.saving(picture, os.fspath(temporary), picture.dpi):
                for time in times:
                    image.set_data(drawing.frame(time))
                    writer.grab_frame()
                for _ in range(round(HOLD * rate)):
                    writer.grab_frame()
        except subprocess.CalledProcessError as error:
            reason = ((error.stderr or "").strip() or "no reason given").splitlines()[-1]
            raise OutputError(f"cannot write {path}: ffmpeg failed: {reason}") from error


def _writer(suffix: str, rate: int, path: str | os.PathLike[str]) -> Any:
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if suffix == ".gif":
        return PillowWriter(fps=rate)
    if not FFMpegWriter.isAvailable():
        raise OutputError(f"cannot write {path}: the program ffmpeg is missing; install it, or write a .gif")
    return FFMpegWriter(fps=rate)
