"""The comparison of all laws."""

import numpy as np
import pyarrow as pa
import pytest

from aspect_control import controllers
from aspect_control.analysis import summarize
from aspect_control.simulation.metrics import METRICS
from aspect_control.studies.comparison import SCENARIOS, VARIANTS, comparison_study
from aspect_control.studies.study import Study
from aspect_control.views import comparison_report, torque_figure


@pytest.fixture(scope="module")
def quick():
    """The comparison of one arm, coarsely sampled."""
    definition = comparison_study().definition
    return Study({"scenarios": ["planar3r"], "laws": definition.laws, "grid": [{"simulation.dt": [0.01]}]})


@pytest.fixture(scope="module")
def table(quick):
    return quick.run()


@pytest.fixture(scope="module")
def runs(quick):
    return {law: quick.record("planar3r", 0, law) for law in quick.laws("planar3r")}


def test_every_installed_law_of_the_package_is_compared():
    ours = {name for name in controllers.available() if controllers.find(name).__module__.startswith("aspect_control.")}
    assert {table["name"] for table in VARIANTS.values()} == ours


def test_every_variant_runs_on_every_scenario_under_its_label(runs):
    study = comparison_study()
    assert tuple(study.scenarios) == SCENARIOS
    assert all(study.laws(scenario) == tuple(VARIANTS) for scenario in SCENARIOS)
    assert runs["modified-brake"].info.parameters["switching"] == "brake"
    assert runs["qp-dead-beat"].info.parameters["stability"] == "dead-beat"


def test_the_report_has_a_row_and_a_figure_for_each_scenario(table):
    there = table.set_column(table.column_names.index("scenario"), "scenario", [["there"] * table.num_rows])
    report = comparison_report(pa.concat_tables([table, there]))
    assert report.count("| damped-null-space |") == 2
    assert "(torques-planar3r.png)" in report
    assert "(torques-there.png)" in report


def test_the_report_says_what_the_runs_came_to(table, runs):
    lines = [line.split(" | ") for line in comparison_report(table).splitlines() if line.startswith("| jmdc |")]
    summary = summarize(runs["jmdc"])
    (cells,) = lines
    assert cells[1:3] == ["finished", f"{max(summary['peak_torque']):,.1f}"]
    assert cells[3] == f"{summary['torque_squared_integral']:,.1f}"
    assert cells[4] == f"{sum(summary['torque_total_variation']):,.1f}"
    assert cells[6] == "kept"
    assert cells[7] == f"{1e3 * summary['max_tracking_error']:.2g} |"


def test_a_run_that_failed_has_a_row_without_figures(table):
    nothing = {name: [None] * table.num_rows for name in METRICS}
    for name, values in {**nothing, "status": ["error"] * table.num_rows}.items():
        place = table.column_names.index(name)
        table = table.set_column(place, name, pa.array(values, table.schema.field(name).type))
    assert "| jmdc | error | – | – | – | – | – | – |" in comparison_report(table)


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
