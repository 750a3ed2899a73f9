"""What is counted in the table of a study, and its report."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from aspect_control.studies.study_summary import THRESHOLD, grid_keys, study_summary, varying_keys, with_explosions
from aspect_control.views import grid_figure, study_figure, study_report
from study_tables import failed, table_of

CALM, WILD = {"law": "calm"}, {"law": "wild"}


def by_law(table):
    return {each.group["law"]: each for each in study_summary(table)}


def exploded(table):
    return with_explosions(table)["exploded"].to_list()


# Shares and percentiles


def test_runs_are_counted_by_how_they_ended():
    found = by_law(table_of(CALM, {**CALM, "status": "diverged"}, failed(**CALM), {**WILD, "status": "joint-limit"}))
    assert (found["calm"].runs, found["calm"].finished, found["calm"].failed) == (3, 1, 1)
    assert (found["wild"].runs, found["wild"].finished, found["wild"].failed) == (1, 0, 0)


@given(kept=st.lists(st.booleans(), min_size=1, max_size=40))
def test_share_that_kept_the_aspect_has_wilsons_interval(kept):
    rows = [{"sample": sample, "aspect_preserved": value} for sample, value in enumerate(kept)]
    found = by_law(table_of(*rows, failed(sample=99)))["jmdc"].kept
    interval = binomtest(sum(kept), len(kept)).proportion_ci(0.95, method="wilson")
    assert (found.count, found.total, found.low, found.high) == (sum(kept), len(kept), interval.low, interval.high)


@given(peaks=st.lists(st.floats(1e-3, 1e6), min_size=1, max_size=30))
def test_percentiles_are_those_of_the_runs_that_did_not_fail(peaks):
    rows = [{"sample": i, "peak_torque": peak, "tracking_error_max": peak / 7.0} for i, peak in enumerate(peaks)]
    found = by_law(table_of(*rows, failed(sample=99)))["jmdc"]
    for spread, values in ((found.peak_torque, peaks), (found.tracking_error, np.array(peaks) / 7.0)):
        assert (spread.median, spread.p95) == pytest.approx(tuple(np.quantile(values, (0.5, 0.95))))
    assert (found.torque_squared_integral.median, found.torque_squared_integral.p95) == (100.0, 100.0)


def test_a_law_that_only_failed_has_no_shares_and_no_percentiles():
    found = by_law(table_of(failed(**CALM), WILD))["calm"]
    assert found.kept.value is found.exploded.value is None
    assert np.isnan(found.peak_torque.median)


# Exploded


@pytest.mark.parametrize(
    ("wild", "expected"),
    [
        ({"peak_torque": 10.0 * THRESHOLD}, False),
        ({"peak_torque": 10.0 * THRESHOLD + 1e-9}, True),
        ({"peak_torque": 20.0, "status": "diverged"}, True),
        ({"peak_torque": 20.0, "status": "joint-limit"}, False),
        ({"peak_torque": None, "status": "diverged"}, True),
        ({"peak_torque": 1.0, "status": "joint-limit"}, False),
    ],
)
def test_a_run_exploded_if_its_peak_is_beyond_ten_times_that_of_the_calmest_that_finished(wild, expected):
    assert exploded(table_of(CALM, {**WILD, **wild})) == [False, expected]


def test_the_reference_is_of_the_same_scenario_and_sample():
    small = {"peak_torque": 1e-3}
    table = table_of(CALM, WILD, {**CALM, **small, "sample": 1}, {**CALM, **small, "scenario": "other"})
    assert with_explosions(table)["reference"].to_list() == [10.0, 10.0, 1e-3, 1e-3]


def test_a_motion_that_no_law_finishes_is_left_out_of_the_exploded():
    table = table_of({**CALM, "status": "diverged"}, failed(**WILD), {**CALM, "sample": 1})
    assert with_explosions(table)["exploded"].isna().to_list() == [True, True, False]
    assert by_law(table)["calm"].exploded.total == 1


def test_a_torque_that_overflowed_counts_as_exploded_and_not_in_the_percentiles():
    found = by_law(table_of(CALM, {**WILD, "peak_torque": None, "status": "tracking-lost"}))["wild"]
    assert (found.exploded.count, found.overflowed) == (1, 1)
    assert np.isnan(found.peak_torque.median)


# Grids


def test_keys_of_a_grid_stand_between_point_and_parameters():
    table = table_of(CALM, keys=("controller.kp", "simulation.dt"))
    assert grid_keys(table) == ["controller.kp", "simulation.dt"]
    assert grid_keys(table_of(CALM)) == []


def test_laws_are_compared_at_the_same_values_of_the_grid():
    rows = [
        {**law, "point": point, "controller.kp": gain, "peak_torque": peak}
        for point, gain in enumerate((50.0, 200.0))
        for law, peak in ((CALM, gain), (WILD, 20.0 * gain))
    ]
    table = table_of(*rows, keys=("controller.kp",))
    assert with_explosions(table)["reference"].to_list() == [50.0, 50.0, 200.0, 200.0]
    groups = [each.group for each in study_summary(table, ("controller.kp", "law"))]
    assert groups == [{"controller.kp": row["controller.kp"], "law": row["law"]} for row in rows]


def test_runs_on_one_motion_count_once_in_an_interval():
    rows = [
        {"point": point, "sample": sample, "aspect_preserved": sample < 3} for point in range(5) for sample in range(12)
    ]
    found = by_law(table_of(*rows))["jmdc"].kept
    interval = binomtest(3, 12).proportion_ci(0.95, method="wilson")
    assert (found.count, found.total, found.low, found.high) == (15, 60, interval.low, interval.high)


@given(kept=st.lists(st.lists(st.booleans(), min_size=1, max_size=6), min_size=1, max_size=8))
def test_a_share_lies_within_its_interval(kept):
    rows = [
        {"sample": sample, "point": point, "aspect_preserved": value}
        for sample, values in enumerate(kept)
        for point, value in enumerate(values)
    ]
    found = by_law(table_of(*rows))["jmdc"].kept
    assert found.low - 1e-12 <= found.value <= found.high + 1e-12


def test_a_parameter_of_one_law_does_not_take_its_reference_away():
    """The other laws run once, at the first point."""
    key = "controller.wild.kappa"
    table = table_of(
        {**CALM, "peak_torque": 1.0},
        {**WILD, key: 0.0, "peak_torque": 2.0},
        {**WILD, key: 0.1, "peak_torque": 50.0, "point": 1},
        keys=(key,),
    )
    assert with_explosions(table)["reference"].to_list() == [1.0, 1.0, 1.0]
    assert exploded(table) == [False, False, True]


def test_only_keys_with_several_values_vary():
    rows = ({**CALM, "a": 1.0, "b": "x"}, {**CALM, "a": 1.0, "b": "y"}, {**CALM, "b": "x"})
    assert varying_keys(table_of(*rows, keys=("a", "b"))) == ["b"]


# The report


@pytest.fixture(scope="module")
def grid():
    """Two arms, two laws, two gains, four motions; one run failed, one diverged."""
    rows = [
        {
            "scenario": scenario, "sample": sample, "law": law, "point": point, "controller.kp": gain,
            "peak_torque": peak * (1.0 + sample), "aspect_preserved": sample % 2 == 0,
        }
        for scenario in ("one", "two")
        for point, gain in enumerate((50.0, 100.0))
        for sample in range(4)
        for law, peak in (("jmdc", 10.0), ("null-space-vector", 500.0))
    ]  # fmt: skip
    rows[0] = failed(**{key: rows[0][key] for key in ("scenario", "sample", "law", "point", "controller.kp")})
    rows[-1]["status"] = "diverged"
    return table_of(*rows, keys=("controller.kp",))


def cells(text, heading):
    """The rows of the table under a heading, without its header."""
    section = text.split(f"\n{heading}\n")[1].split("\n#")[0]
    return [
        [cell.strip() for cell in line.strip("|").split("|")] for line in re.findall(r"^\|.*\|$", section, re.M)[2:]
    ]


def test_report_has_a_row_for_each_law_and_for_each_point(grid):
    text = study_report(grid, "What it is for.")
    assert "What it is for." in text
    assert [row[:4] for row in cells(text, "## one")] == [["jmdc", "8", "7", "1"], ["null-space-vector", "8", "8", "0"]]
    points = cells(text, "### two")
    assert [row[:3] for row in points] == [
        [point, gain, law]
        for point, gain in (("0", "50"), ("1", "100"))
        for law in ("jmdc", "null-space-vector")
    ]  # fmt: skip
    assert points[1][-6:] == ["0.50 [0.15, 0.85]", "1.00 [0.51, 1.00]", "1,250 / 1,925", "100 / 100", "1 / 1", "0.5"]


def test_report_says_how_runs_ended_and_why_they_failed(grid):
    text = study_report(grid)
    assert cells(text, "## How the runs ended that did not finish") == [
        ["jmdc", "error", "1"],
        ["null-space-vector", "diverged", "1"],
    ]
    assert "- jmdc: J has lost rank (1)" in text
    assert "All runs finished." in study_report(table_of(CALM, WILD))


def test_report_lists_so_many_reasons_and_counts_the_rest():
    text = study_report(table_of(*(failed(f"reason {i}", sample=i) for i in range(25))))
    assert len(re.findall(r"^- jmdc: reason", text, re.M)) == 20
    assert "- and 5 reasons more" in text


def test_report_of_a_study_without_a_grid_speaks_of_none():
    text = study_report(table_of(CALM, WILD))
    assert "grid" not in text
    assert "study.png" in text


# The figures


def test_figure_has_a_line_a_law_with_its_shares_and_percentiles(grid):
    figure = study_figure(grid)
    kept, exploded, torque = figure.axes
    laws = [label.get_text() for label in kept.get_yticklabels()]
    assert laws == ["JMDC", "null space vector"] * 2
    places = kept.get_yticks()
    for place, each in zip(places, study_summary(grid), strict=True):
        for axes, share in ((kept, each.kept), (exploded, each.exploded)):
            drawn = [line.get_xdata().tolist() for line in axes.get_lines() if set(line.get_ydata()) == {place}]
            assert drawn == [[share.low, share.high], [share.value]]
        drawn = [line.get_xdata().tolist() for line in torque.get_lines() if set(line.get_ydata()) == {place}]
        spread = each.peak_torque
        assert drawn == [[spread.median, spread.p95], [spread.median], [spread.p95]]
    assert [text.get_text() for text in kept.texts] == ["one", "two"]
    low, high = sorted(kept.get_ylim())
    assert all(low < text.get_position()[1] < high for text in kept.texts)
    assert low < min(places) < max(places) < high


def test_figure_says_where_nothing_is_known():
    kept, exploded, _ = study_figure(table_of(failed(**CALM), WILD)).axes
    assert "not known" in [text.get_text() for text in kept.texts]
    assert "not known" in [text.get_text() for text in exploded.texts]


def test_figure_of_a_grid_shows_the_shares_along_each_key(grid):
    figure = grid_figure(grid, "two")
    kept, exploded = figure.axes
    assert [label.get_text() for label in kept.get_xticklabels()] == ["50", "100"]
    assert kept.get_xlabel() == "controller.kp (1/s²)"
    found = {
        (each.group["controller.kp"], each.group["law"]): each
        for each in study_summary(grid.filter(np.array(grid["scenario"]) == "two"), ("controller.kp", "law"))
    }
    for axes, name in ((kept, "kept"), (exploded, "exploded")):
        for line, law in zip(axes.get_lines(), ("jmdc", "null-space-vector"), strict=True):
            assert line.get_ydata().tolist() == [getattr(found[gain, law], name).value for gain in (50.0, 100.0)]


def test_figure_of_a_grid_shows_a_parameter_of_one_law_for_that_law_alone():
    key = "controller.wild.kappa"
    rows = [CALM, *({**WILD, key: value, "point": point} for point, value in enumerate((0.0, 0.1)))]
    kept, _ = grid_figure(table_of(*rows, keys=(key,)), "arm").axes
    assert [line.get_xdata().tolist() for line in kept.get_lines()] == [[0.0, 1.0]]
