"""Figures and the report."""

import json
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.image import imread

from aspect_control.exceptions import OutputError
from aspect_control.studies.paper import trajectory_a as paper
from aspect_control.views import comparison_figure, run_figure, save_figure


@pytest.fixture(scope="module")
def runs():
    return {law: paper.run_law(law, 5e-3) for law in paper.LAWS}


def test_a_run_figure_has_the_four_panels_with_labelled_axes(runs):
    figure = run_figure(runs["null-space-vector"], "heading")
    panels = [axes for axes in figure.axes if axes.get_title(loc="left")]
    assert [axes.get_title(loc="left")[:3] for axes in panels] == ["(a)", "(b)", "(c)", "(d)"]
    for axes in panels:
        assert "(" in axes.get_xlabel()
        assert "(" in axes.get_ylabel()
    assert figure.get_suptitle() == "heading"


def test_the_torque_panel_shows_the_recorded_torques(runs):
    run = runs["jmdc"]
    lines = run_figure(run).axes[1].get_lines()
    np.testing.assert_array_equal([line.get_ydata() for line in lines], run.tau.T)


def test_panels_of_what_explodes_are_logarithmic_and_say_so(runs):
    for law, scale in (("null-space-vector", "symlog"), ("jmdc", "linear")):
        torques, product = (run_figure(runs[law]).axes[i] for i in (1, 3))
        assert torques.get_yscale() == scale
        assert torques.get_ylabel() == ("torque (N m), log beyond ±10" if scale == "symlog" else "torque (N m)")
        assert product.get_yscale() == scale


def test_stick_figures_end_on_the_tip(runs):
    run = runs["jmdc"]
    sticks = [line.get_xydata() for line in run_figure(run).axes[0].get_lines()][:-1]
    assert len(sticks) == 21
    np.testing.assert_allclose([stick[-1] for stick in sticks], run.x[::20], atol=1e-12)
    assert all(len(stick) == 4 for stick in sticks)
    np.testing.assert_allclose([np.linalg.norm(np.diff(stick, axis=0), axis=1) for stick in sticks], 1.0)


def test_sign_changes_are_marked_where_there_are_any(runs):
    def marked(run):
        return [line for line in run_figure(run).axes[2].get_lines() if line.get_label() == "sign change"]

    assert len(marked(runs["null-space-vector"])[0].get_xdata()) == 6
    assert not marked(runs["jmdc"])


def test_the_comparison_draws_every_law_on_common_scales(runs):
    figure = comparison_figure(runs)
    motions = figure.axes[:4]
    assert len({axes.get_xlim() for axes in motions}) == len({axes.get_ylim() for axes in motions}) == 1
    torque = next(axes for axes in figure.axes if axes.get_title(loc="left") == "largest joint torque")
    assert torque.get_yscale() == "log"
    assert len(torque.get_lines()) == 4
    back_to_front = sorted(torque.get_lines(), key=lambda line: line.get_zorder())
    assert back_to_front[0].get_label() == "null space vector"
    assert back_to_front[-1].get_label() == "JMDC"


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_saved_figures_are_the_same_every_time(runs, tmp_path, suffix):
    for name in ("one", "two"):
        save_figure(run_figure(runs["jmdc"]), tmp_path / f"{name}.{suffix}")
    assert (tmp_path / f"one.{suffix}").read_bytes() == (tmp_path / f"two.{suffix}").read_bytes()
    if suffix == "png":
        assert imread(tmp_path / "one.png")[..., :3].std() > 0.05


def test_a_figure_that_cannot_be_written_is_an_error_of_ours(runs, tmp_path):
    with pytest.raises(OutputError, match="missing"):
        save_figure(run_figure(runs["jmdc"]), tmp_path / "missing" / "figure.png")


def test_drawing_opens_no_window_and_needs_no_backend():
    code = (
        "import sys, json; from aspect_control.studies.paper import trajectory_a as p;"
        "from aspect_control.views import run_figure;"
        "run_figure(p.run_law('jmdc', 0.01)); print(json.dumps('matplotlib.pyplot' in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) is False
