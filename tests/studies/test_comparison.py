"""The comparison of all laws."""

import numpy as np
import pytest

from aspect_control import controllers
from aspect_control.analysis import summarize
from aspect_control.scenario import load_scenario
from aspect_control.studies.comparison import VARIANTS, with_variants
from aspect_control.views import comparison_report, torque_figure


@pytest.fixture(scope="module")
def runs():
    return with_variants(load_scenario("planar3r", ["simulation.dt=0.01"])).build().run()


def test_every_installed_law_of_the_package_is_compared():
    ours = {name for name in controllers.available() if controllers.find(name).__module__.startswith("aspect_control.")}
    assert {table["name"] for table in VARIANTS.values()} == ours


def test_a_scenario_with_all_variants_runs_each_under_its_label(runs):
    assert list(runs) == list(VARIANTS)
    assert runs["modified-brake"].info.parameters["switching"] == "brake"
    assert runs["qp-dead-beat"].info.parameters["stability"] == "dead-beat"


def test_self_motion_energy_is_that_of_the_null_space_part_of_the_velocity(runs):
    run = runs["pseudoinverse"]
    energies = []
    for q, v in zip(run.q, run.v, strict=True):
        state = run.arm.state(q, v)
        part = v - np.linalg.pinv(state.J) @ state.J @ v
        energies.append(part @ state.M @ part / 2.0)
    np.testing.assert_allclose(run.self_motion_energy, energies, rtol=0, atol=1e-9 * max(energies))


def test_the_report_has_a_row_and_a_figure_for_each_scenario(runs):
    summary = {label: {**summarize(run), "self_motion_energy_max": 1.0} for label, run in runs.items()}
    report = comparison_report({"here": summary, "there": summary})
    assert report.count("| damped-null-space |") == 2
    assert "(torques-here.png)" in report
    assert "(torques-there.png)" in report


def test_calm_runs_share_a_scale_and_the_exploding_one_has_its_own(runs):
    panels = {axes.get_title(loc="left"): axes for axes in torque_figure(runs, "title").axes}
    own = {title.split(" (")[0]: axes for title, axes in panels.items() if " (" in title}
    assert own["null-space-vector"].get_yscale() == "symlog"
    assert "null-space-vector (log beyond ±10 N m)" in panels
    calm = {axes.get_ylim() for title, axes in panels.items() if title and " (" not in title}
    assert len(calm) == 1
    for label, run in runs.items():
        axes = panels.get(label) or own[label]
        np.testing.assert_array_equal([line.get_ydata() for line in axes.get_lines()], run.tau.T)
        low, high = axes.get_ylim()
        assert low <= run.tau.min()
        assert run.tau.max() <= high
