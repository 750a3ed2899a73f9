"""Runs as GIF and MP4."""

import shutil
import subprocess
from dataclasses import replace
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image, ImageSequence

from aspect_control import controllers, simulate
from aspect_control.exceptions import OutputError, ParameterError, UnknownNameError
from aspect_control.simulation.events import Diverged
from aspect_control.studies.paper import trajectory_a as paper
from aspect_control.trajectories import StraightLine
from aspect_control.views import animate
from aspect_control.views.figures.animation import HOLD
from aspect_control.views.figures.moving_picture import MovingPicture
from aspect_control.views.frames import labelled_runs
from aspect_control.views.style import style

SPEED = 8.0
"""A quarter of a second for the two seconds of trajectory A: eight frames of a GIF, at 0, 0.32, …, 1.92 and 2 s."""


@pytest.fixture(scope="module")
def runs():
    return [paper.run_law(law, 5e-3) for law in ("null-space-vector", "jmdc")]


@pytest.fixture(scope="module")
def frames(runs, tmp_path_factory):
    """The pixels and the durations (ms) of the frames of a GIF."""
    path = tmp_path_factory.mktemp("animation") / "two.gif"
    animate(runs, path, speed=SPEED)
    assert [file.name for file in path.parent.iterdir()] == ["two.gif"]
    with Image.open(path) as image:
        return [(np.array(f.convert("RGB")), f.info["duration"]) for f in ImageSequence.Iterator(image)]


def picture_of(runs, **settings):
    with style():
        return MovingPicture(labelled_runs(runs), **settings)


def pixel(axes, point, height):
    """Row and column at which axes show a point."""
    column, up = axes.transData.transform(point)
    return height - 1 - int(up), int(column)


def tip(q):
    """The tip of three links of 1 m."""
    angles = np.cumsum(q)
    return np.array([np.cos(angles).sum(), np.sin(angles).sum()])


def test_a_gif_has_a_frame_every_25th_of_a_second_and_holds_the_last_one(frames):
    assert len(frames) == 8
    durations = [duration for _, duration in frames]
    assert durations[:-1] == [40] * (len(frames) - 1)
    assert durations[-1] == 40 + 1000 * HOLD
    height, width, _ = frames[0][0].shape
    assert width == 900
    assert height % 2 == 0


def test_the_arms_move(frames):
    pictures = [picture.astype(int) for picture, _ in frames]
    for before, after in pairwise(pictures):
        moved = np.abs(after - before).max(axis=2) > 60
        assert moved[:, :450].sum() > 200
        assert moved[:, 450:].sum() > 200


def test_the_tips_are_drawn_where_forward_kinematics_puts_them(runs, frames):
    drawing = picture_of(runs, speed=SPEED)
    for run, axes in zip(runs, drawing.panels, strict=True):
        for (picture, _), q, elsewhere in ((frames[0], run.q[0], run.q[-1]), (frames[-1], run.q[-1], run.q[0])):
            row, column = pixel(axes, tip(q), len(picture))
            assert picture[row - 1 : row + 2, column - 1 : column + 2].max() < 60
            row, column = pixel(axes, tip(elsewhere), len(picture))
            assert picture[row - 3 : row + 4, column - 3 : column + 4].max() > 180


def test_arms_side_by_side_are_on_the_same_scales(runs):
    one, other = picture_of(runs).panels
    assert one.get_xlim() == other.get_xlim()
    assert one.get_ylim() == other.get_ylim()
    np.testing.assert_allclose(np.ptp(one.get_window_extent().get_points(), 0), np.ptp(other.get_window_extent(), 0))


def test_torques_that_explode_are_on_a_logarithmic_scale(runs):
    assert picture_of(runs).torques.get_yscale() == "log"
    assert picture_of(runs[1]).torques.get_yscale() == "linear"


def test_a_panel_is_tinted_when_its_arm_leaves_an_aspect(runs):
    drawing = picture_of(runs)
    corners = [(axes.get_xlim()[1] - 0.03, axes.get_ylim()[0] + 0.03) for axes in drawing.panels]

    def white(time):
        picture = drawing.frame(time)
        rows = [pixel(axes, corner, len(picture)) for axes, corner in zip(drawing.panels, corners, strict=True)]
        return [bool(picture[row, column].min() == 255) for row, column in rows]

    assert white(0.5) == [True, True]
    assert white(1.2) == [False, True]
    assert [axes.texts[0].get_text() for axes in drawing.panels] == ["aspect changes: 2", "aspect changes: 0"]


def test_a_run_that_ended_early_waits_and_says_so(runs):
    whipping = runs[0]
    law = controllers.NullSpaceVector(whipping.arm)
    diverged = simulate(law, paper.TRAJECTORY, q0=paper.Q0, dt=5e-3, events=[Diverged(speed=5.0)])
    assert diverged.status == "diverged"
    spoilt = replace(runs[1], q=np.where(runs[1].t[:, np.newaxis] > 1.5, np.nan, runs[1].q))
    drawing = picture_of([diverged, spoilt])
    assert drawing.torques.get_xlim() == (0.0, 1.5)
    drawing.frame(1.5)
    notes = [axes.texts[0].get_text().splitlines()[-1] for axes in drawing.panels]
    assert notes == [f"diverged at t = {diverged.t[-1]:.3f} s", "not finite after t = 1.500 s"]
    drawing.frame(0.5)
    assert "diverged" not in drawing.panels[0].texts[0].get_text()


def test_an_arm_that_moves_in_space_is_drawn_in_space(seven):
    line = StraightLine([0.05, 0.0, 0.05], duration=0.1)
    run = simulate(controllers.Pseudoinverse(seven), line, q0=[0.3, -0.4, 0.5, 0.8, -0.2, 0.6, 0.1], dt=5e-3)
    drawing = picture_of(run)
    assert drawing.panels[0].name == "3d"
    moved = (drawing.frame(0.0) != drawing.frame(0.1)).any(axis=2)
    assert moved[: len(moved) // 2].sum() > 200


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_an_mp4_is_a_film(runs, tmp_path):
    animate(runs, tmp_path / "two.mp4", speed=SPEED)
    command = [shutil.which("ffmpeg"), "-i", tmp_path / "two.mp4", "-f", "framecrc", "-"]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    shown = [line.split(",")[-1] for line in lines if not line.startswith("#")]
    assert len(shown) == 9 + round(30 * HOLD)
    assert len(set(shown)) >= 9


def test_without_ffmpeg_an_mp4_is_refused_and_a_gif_is_proposed(runs, tmp_path):
    with (
        mpl.rc_context({"animation.ffmpeg_path": "no-such-ffmpeg"}),
        pytest.raises(OutputError, match=r"ffmpeg is missing.*\.gif"),
    ):
        animate(runs, tmp_path / "two.mp4")
    assert not list(tmp_path.iterdir())


def test_bad_input_is_one_error_and_leaves_no_file(runs, tmp_path):
    with pytest.raises(UnknownNameError, match=r"'\.avi'.*'\.gif', '\.mp4'"):
        animate(runs, tmp_path / "arm.avi")
    with pytest.raises(OutputError, match="missing"):
        animate(runs, tmp_path / "missing" / "arm.gif")
    with pytest.raises(ParameterError, match="no runs"):
        animate([], tmp_path / "arm.gif")
    with pytest.raises(ParameterError, match="expected a Run"):
        animate("run.npz", tmp_path / "arm.gif")
    for speed in (0.0, -1.0, float("inf"), None):
        with pytest.raises(ParameterError, match="speed"):
            animate(runs, tmp_path / "arm.gif", speed=speed)
    empty = replace(runs[1], t=runs[1].t[:0], q=runs[1].q[:0], v=runs[1].v[:0], tau=runs[1].tau[:0])
    with pytest.raises(ParameterError, match="no samples"):
        animate(empty, tmp_path / "arm.gif")
    assert not list(tmp_path.iterdir())
