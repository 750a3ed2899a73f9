"""The hypothesis on random motions: what is run, definitions, statistics, answers."""

import json
import math
from functools import cache

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import pearsonr, rankdata

from aspect_control.exceptions import ParameterError, ScenarioError, StudyError
from aspect_control.studies import Study
from aspect_control.studies.hypothesis import (
    ABLATION,
    EXPLODED_INSIDE,
    LEFT_AND_CALM,
    THRESHOLDS,
    AspectTable,
    HypothesisResult,
    Part,
    conditions,
    evidence,
    hypothesis_study,
    paired_difference,
    rank_correlation,
)
from aspect_control.studies.proportion import proportion
from aspect_control.studies.rows import columns, to_table
from aspect_control.views import (
    hypothesis_figure,
    hypothesis_report,
    hypothesis_rows,
    hypothesis_verdict,
    shares_figure,
)
from aspect_control.views.reports.hypothesis_report import filled_page, hypothesis_fields

LAWS = ("pseudoinverse", "null-space-vector")
DEFINITION = {
    "scenarios": ["planar3r"],
    "motions": {"random": 4, "seed": 3},
    "laws": [{"name": law} for law in LAWS],
    "grid": [{"simulation.dt": [1e-2]}],
    "endings": ["diverged", "workspace-left", "tracking-lost"],
    "saturation": False,
    "report": "hypothesis",
}
CALM = {
    "scenario": "planar3r",
    "point": 0,
    "status": "finished",
    "message": "finished",
    "peak_torque": 20.0,
    "peak_torque_inside": 20.0,
    "aspect_preserved": True,
    "sign_changes": 0,
    "margin": 0.1,
    "manipulability_min": 1.0,
    "self_motion_max": 0.1,
    "dt": 1e-3,
    "seed": 0,
    "robot": "planar3r",
    "path_length": 1.0,
    "duration": 2.0,
    "on_border": 0,
    "wrong_length": 1,
    "minors": 3,
    "redundancy": 1,
    "wall_time": 0.1,
}
LEFT = {"aspect_preserved": False, "margin": -0.5, "sign_changes": 1, "left_at": 1.0}


@pytest.fixture(scope="module")
def study():
    return Study(DEFINITION, "small")


@pytest.fixture(scope="module")
def table(study):
    return study.run()


@pytest.fixture(scope="module")
def found(study, table):
    return evidence([Part(study, table, "small.parquet", "0" * 64)])


def run(sample, law="jmdc", ratio=1.0, inside=None, reference=20.0, **changes):
    """A row of a table whose torque is so many times the reference, and so many before the aspect was left."""
    peak = ratio * reference
    inside = peak if inside is None else inside * reference
    return {**CALM, "sample": sample, "law": law, "peak_torque": peak, "peak_torque_inside": inside, **changes}


def calmest(sample, reference=20.0):
    """The run that the others of a sample are held against."""
    return run(sample, "calmest", reference=reference)


@cache
def layout_of(keys):
    grid = [{key: [1.0] for key in keys}] if keys else []
    return Study({"scenarios": ["planar3r"], "laws": [{"name": "jmdc"}], "grid": grid})


def table_of(*rows, keys=()):
    layout = layout_of(tuple(keys))
    empty = dict.fromkeys(columns(layout))
    return to_table(layout, [{**empty, **row, "row": number} for number, row in enumerate(rows)])


def result_of(*rows):
    (condition,) = conditions(table_of(*rows))
    return HypothesisResult(condition)


# What is run


def test_laws_are_the_scenarios_and_jmdc_without_the_minor_measure():
    study = hypothesis_study("planar3r", 3, seed=2, dt=5e-3)
    assert study.laws("planar3r") == (*LAWS, "modified-null-space-vector", "jmdc", ABLATION)
    assert study.setup("planar3r").laws[ABLATION].parameters["kappa"] == 0.0
    assert (study.runs, study.setup("planar3r").dt, study.setup("planar3r").saturation) == (15, 5e-3, None)
    assert {event.name for event in study.setup("planar3r").events} <= set(DEFINITION["endings"])


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"samples": 0}, ParameterError),
        ({"samples": 1, "seed": -1}, ParameterError),
        ({"samples": 1, "dt": 0.0}, ParameterError),
        ({"samples": 1, "scenario": "no-such"}, ScenarioError),
    ],
)
def test_what_makes_no_study_is_refused(arguments, error):
    with pytest.raises(error):
        hypothesis_study(**{"scenario": "planar3r", **arguments})


# Arms and settings of a table


def test_a_condition_is_an_arm_at_a_grid_point():
    rows = [
        run(sample, law, scenario=arm, point=point, **{"simulation.dt": dt})
        for arm in ("planar3r", "panda-xyz")
        for sample in range(2)
        for law in LAWS
        for point, dt in enumerate((1e-3, 5e-4))
    ]
    found = conditions(table_of(*rows, keys=["simulation.dt"]))
    assert [(each.scenario, each.point, each.changes) for each in found] == [
        (arm, point, {"simulation.dt": dt})
        for arm in ("planar3r", "panda-xyz")
        for point, dt in enumerate((1e-3, 5e-4))
    ]
    assert all((each.laws, len(each.rows)) == (LAWS, 4) for each in found)


def test_a_law_that_a_point_does_not_change_is_held_against_the_others_there():
    kappa = "controller.jmdc.kappa"
    rows = [run(0, "pseudoinverse"), run(0, point=0, **{kappa: 0.0}), run(0, point=1, ratio=3.0, **{kappa: 1.0})]
    first, second = conditions(table_of(*rows, keys=[kappa]))
    assert (first.laws, second.laws) == (("pseudoinverse", "jmdc"),) * 2
    assert (first.changes, second.changes) == ({kappa: 0.0}, {kappa: 1.0})
    assert HypothesisResult(second).of("jmdc")["ratio"].tolist() == [3.0]


def test_a_law_that_was_not_run_at_a_setting_is_not_taken_from_another():
    rows = [
        run(0, law, point=point, **{"simulation.dt": dt})
        for point, dt in enumerate((1e-3, 5e-4))
        for law in LAWS[: 2 - point]
    ]
    assert [each.laws for each in conditions(table_of(*rows, keys=["simulation.dt"]))] == [LAWS, LAWS[:1]]


def test_a_motion_of_which_a_law_is_still_missing_is_left_out():
    (condition,) = conditions(table_of(calmest(0), run(0), calmest(1), run(1), calmest(2)))
    assert condition.rows["sample"].unique().tolist() == [0, 1]


# Definitions


def test_results_agree_with_the_runs(study, table):
    (condition,) = conditions(table)
    result = HypothesisResult(condition)
    assert len(result.rows) == 8
    for sample in range(4):
        runs = {law: study.record("planar3r", sample, law) for law in LAWS}
        peaks = {law: np.abs(run.tau).max() for law, run in runs.items()}
        reference = min(peaks[law] for law, run in runs.items() if run.status == "finished")
        for row in result.rows[result.rows["sample"] == sample].to_dict("records"):
            assert (row["peak_torque"], row["reference"]) == (peaks[row["law"]], reference)
            assert row["ratio"] == peaks[row["law"]] / reference
    for threshold in THRESHOLDS:
        for law in LAWS:
            assert_counts_are_read_off_the_runs(study, result, law, threshold)


def assert_counts_are_read_off_the_runs(study, result, law, threshold):
    counts = dict.fromkeys(("kept_calm", "kept_exploded", "left_calm", "left_exploded", "left_first"), 0)
    for row in result.of(law).to_dict("records"):
        run = study.record("planar3r", row["sample"], law)
        signs = np.sign(run.minors)
        left = run.t[np.any(signs != signs[0], axis=1)]
        beyond = run.t[np.abs(run.tau).max(axis=1) > threshold * row["reference"]]
        burst = len(beyond) > 0 or run.status != "finished"
        counts[f"{'left' if len(left) else 'kept'}_{'exploded' if burst else 'calm'}"] += 1
        # The sign changes between two samples; a torque that passes the threshold at the second of them comes after.
        counts["left_first"] += bool(burst and len(left) and (not len(beyond) or left[0] <= beyond[0]))
    assert {name: getattr(result.table(law, threshold), name) for name in counts} == counts


@pytest.mark.parametrize(
    ("changes", "burst"),
    [({}, False), ({"ratio": 10.0}, False), ({"ratio": 10.1}, True), ({"status": "tracking lost"}, True)],
)
def test_exploded_is_an_early_end_or_a_peak_beyond_the_threshold(changes, burst):
    assert result_of(calmest(0), run(0, **changes)).table("jmdc").kept_exploded == burst


def test_the_reference_is_of_the_laws_that_finish():
    result = result_of(run(0, ratio=0.5, status="diverged"), run(0, "calmest", ratio=2.0))
    assert result.motions["reference"].tolist() == [40.0]


def test_a_motion_that_no_law_finishes_is_in_no_table(tmp_path):
    lost = [run(sample, law, status="tracking lost") for sample in range(2) for law in LAWS]
    result = result_of(*lost)
    assert (result.undecided, result.table("pseudoinverse").total) == ((0, 1), 0)
    condition = {"setting": "", **json.loads(json.dumps(result.to_dict(), allow_nan=False))}
    assert "No run left its aspect" in " ".join(hypothesis_verdict([condition]))
    hypothesis_figure(result).savefig(tmp_path / "empty.png")
    shares_figure([condition, condition]).savefig(tmp_path / "shares.png")


def test_a_run_that_raised_is_counted_and_in_no_table():
    nothing = dict.fromkeys(("peak_torque", "peak_torque_inside", "aspect_preserved", "sign_changes", "margin"))
    result = result_of(calmest(0), {**run(0), **nothing, "status": "error"})
    assert (result.failed, result.table("jmdc").total, result.table("calmest").total) == (1, 0, 1)
    json.dumps(result.to_dict(), allow_nan=False)


def test_the_torque_came_first_if_it_passed_the_threshold_before_the_aspect_was_left():
    result = result_of(
        calmest(0),
        run(0, ratio=50.0, inside=10.0, **LEFT),
        calmest(1),
        run(1, ratio=50.0, inside=10.1, **LEFT),
        calmest(2),
        run(2, ratio=1.0, inside=1.0, **LEFT),
        calmest(3),
        run(3, ratio=50.0),
        calmest(4),
        run(4, ratio=5.0, inside=1.0, status="diverged", **LEFT),
    )
    found = result.table("jmdc")
    assert (found.left_first, found.exploded_inside.count, found.exploded_inside.total) == (2, 2, 4)


# Statistics

pairs = st.lists(st.tuples(st.booleans(), st.floats(1.0, 1e6), st.floats(0.0, 1.0), st.booleans()), max_size=30)


@settings(max_examples=25, deadline=None)
@given(pairs)
def test_tables_add_up(runs):
    rows = [
        row
        for sample, (kept, ratio, share, done) in enumerate(runs)
        for row in (
            calmest(sample),
            run(
                sample,
                ratio=ratio,
                inside=ratio if kept else ratio * share,
                status="finished" if done else "diverged",
                **({} if kept else LEFT),
            ),
        )
    ]
    if not rows:
        return
    result = result_of(*rows)
    tables = [result.table("jmdc", threshold) for threshold in THRESHOLDS]
    for each in tables:
        assert each.total == len(runs)
        assert each.kept == sum(kept for kept, *_ in runs)
        burst = sum(not done or ratio > each.threshold for _, ratio, _, done in runs)
        assert each.kept_exploded + each.left_exploded == burst
        assert each.left_first <= each.left_exploded
        assert each.exploded_if_left.count + each.calm_if_left.count == each.left
        json.dumps(each.to_dict() | each.association(), allow_nan=False)
    calm = [each.kept_calm + each.left_calm for each in tables]
    assert calm == sorted(calm)


@pytest.mark.parametrize(("count", "total"), [(0, 10), (7, 20), (20, 20), (123, 400)])
def test_interval_is_wilsons(count, total):
    z, p = 1.959963984540054, count / total
    centre = (p + z**2 / (2 * total)) / (1 + z**2 / total)
    half = z / (1 + z**2 / total) * math.sqrt(p * (1 - p) / total + z**2 / (4 * total**2))
    found = proportion(count, total)
    assert (found.value, found.low, found.high) == pytest.approx((p, centre - half, centre + half), abs=1e-12)


def test_of_no_runs_nothing_is_known():
    assert (proportion(0, 0).value, proportion(0, 0).low, proportion(0, 0).high) == (None, 0.0, 1.0)


def test_association_is_that_of_fishers_tea_tasting():
    table = AspectTable("jmdc", 10.0, kept_calm=3, kept_exploded=1, left_calm=1, left_exploded=3, left_first=3)
    assert table.fisher_p == pytest.approx(0.4857142857)
    ratio, low, high = table.odds_ratio

    def shares(odds):
        weights = np.array([1, 16, 36, 16, 1]) * odds ** np.arange(5)
        return weights / weights.sum()

    assert shares(ratio) @ np.arange(5) == pytest.approx(3.0, rel=1e-6)
    assert shares(low)[3:].sum() == pytest.approx(0.025, rel=1e-6)
    assert shares(high)[:4].sum() == pytest.approx(0.025, rel=1e-6)
    assert table.risk_difference == pytest.approx(0.5)
    empty = AspectTable("jmdc", 10.0, kept_calm=3, kept_exploded=0, left_calm=1, left_exploded=0, left_first=0)
    assert (empty.fisher_p, empty.odds_ratio, empty.risk_difference) == (None, None, 0.0)


def test_rank_correlation_is_pearsons_of_the_ranks():
    x, y = np.random.default_rng(0).integers(0, 9, (2, 40))
    assert rank_correlation(x, y) == pytest.approx(pearsonr(rankdata(x), rankdata(y)).statistic)
    assert rank_correlation([1.0, 2.0, 9.0], [3.0, 1.0, 0.5]) == pytest.approx(-1.0)
    assert rank_correlation([1.0, 2.0, 3.0], [1.0, 1.0, 1.0]) is None
    assert rank_correlation([1.0, 2.0], [1.0, 2.0]) is None


@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=40))
def test_a_paired_difference_is_a_coin_thrown_on_the_motions_that_differ(motions):
    one, other = (np.array([motion[i] for motion in motions], dtype=bool) for i in (0, 1))
    found = paired_difference(one, other)
    n, k = found["one_alone"] + found["other_alone"], min(found["one_alone"], found["other_alone"])
    assert found["one"] - found["other"] == found["one_alone"] - found["other_alone"]
    assert n == sum(a != b for a, b in motions)
    if n:
        tail = sum(math.comb(n, i) for i in range(k + 1)) / 2**n
        assert found["p"] == pytest.approx(min(1.0, 2.0 * tail))
    else:
        assert found["p"] is None


def test_the_minor_measure_is_judged_on_the_same_motions():
    rows = [
        row
        for sample in range(8)
        for row in (
            calmest(sample),
            run(sample, ratio=50.0 if sample < 7 else 1.0),
            run(sample, ABLATION, **(LEFT if sample == 0 else {})),
        )
    ]
    found = result_of(*rows).minor_measure()
    assert found["kept"] == {"one": 8, "other": 7, "one_alone": 1, "other_alone": 0, "p": 1.0}
    assert found["exploded"] == {"one": 7, "other": 0, "one_alone": 7, "other_alone": 0, "p": 2 / 2**7}
    assert result_of(calmest(0), run(0)).minor_measure() is None


# Counterexamples and answers


def clear_cases():
    return [
        row
        for sample, (changes, reference) in enumerate(
            [
                ({**LEFT, "margin": -0.9, "ratio": 5.0}, 20.0),
                ({**LEFT, "margin": -0.2, "ratio": 1.5}, 20.0),
                ({**LEFT, "margin": -0.3, "ratio": 1.5}, 20.0),
                ({**LEFT, "margin": -0.8, "ratio": 50.0, "inside": 1.0}, 20.0),
                ({"ratio": 50.0}, 20.0),
                ({"ratio": 500.0}, 20.0),
                ({**LEFT, "ratio": 1.0}, 5e3),
            ]
        )
        for row in (calmest(sample, reference), run(sample, reference=reference, **changes))
    ]


def test_clearest_counterexamples_went_farthest_at_the_strictest_threshold():
    found = [each for each in result_of(*clear_cases()[:12]).clearest() if each.law == "jmdc"]
    assert [(each.kind, each.sample) for each in found] == [
        (LEFT_AND_CALM, 2),
        (LEFT_AND_CALM, 1),
        (EXPLODED_INSIDE, 5),
        (EXPLODED_INSIDE, 4),
    ]
    assert [each.row for each in found] == [5, 3, 11, 9]


def test_answers_follow_from_the_counts():
    result = result_of(*clear_cases())
    assert (result.demanding, result.bound) == ((6,), 200.0)
    words = " ".join(hypothesis_verdict([{"setting": "", **result.to_dict()}]))
    assert "Necessary for a calm torque? No: 4 of 5 runs" in words
    assert "3 of them within 2 times the reference and 3 below 10 times the median reference" in words
    assert "P(calm given left) is 0.80 [0.38, 0.96] (jmdc, planar3r)" in words
    assert "Sufficient? No: 2 of 9 runs" in words
    assert "In 2 of 3 runs that exploded" in words


def verdict_of(*rows):
    return " ".join(hypothesis_verdict([{"setting": "", **result_of(*rows).to_dict()}]))


def test_answers_turn_with_the_counts():
    calm = [row for sample in range(200) for row in (calmest(sample), run(sample))]
    assert "No run left its aspect" in verdict_of(*calm)
    assert "none of the 400 runs that kept it exploded; the highest upper end of an interval is 0.019" in verdict_of(
        *calm
    )
    once = [*calm[:-1], run(199, ratio=50.0)]
    assert "Sufficient? Nearly: 1 of 400 runs" in verdict_of(*once)
    burst = [row for sample in range(3) for row in (calmest(sample), run(sample, ratio=50.0, inside=1.0, **LEFT))]
    assert "Nothing here contradicts it: all 3 runs that left exploded" in verdict_of(*burst)
    assert (
        "In 0 of 3 runs that exploded the torque passed the threshold before any minor had changed sign."
        in verdict_of(*burst)
    )


def test_a_difference_of_the_minor_measure_is_said_only_if_it_shows():
    def motions(number):
        return [
            row for sample in range(number) for row in (calmest(sample), run(sample, ratio=50.0), run(sample, ABLATION))
        ]

    assert "makes no difference that shows" in verdict_of(*motions(5))
    assert "explodes more often on 1 of 1 arm (planar3r: 6 motions with it, 0 without)" in verdict_of(*motions(6))


def test_counterexamples_are_run_again_at_a_quarter_of_the_sampling_time(study, found):
    assert found["counterexamples"]
    for each in found["counterexamples"][:2]:
        run = study.record("planar3r", each["sample"], each["law"], dt=1e-2 / 4)
        peak, signs = np.abs(run.tau).max(), np.sign(run.minors)
        assert each["finer_peak_torque"] == peak
        burst = run.status != "finished" or peak > 10.0 * each["reference"]
        kept = bool(np.all(signs == signs[0]))
        assert each["holds"] == (
            (kept, burst) == {LEFT_AND_CALM: (False, False), EXPLODED_INSIDE: (True, True)}[each["kind"]]
        )


# Documents


def test_the_report_has_what_was_found_and_where_it_comes_from(found):
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    report = hypothesis_report(found, ["hypothesis-planar3r"])
    assert f"`{'0' * 64}`" in report
    assert "![hypothesis-planar3r](hypothesis-planar3r.png)" in report
    for row in hypothesis_rows(found["conditions"][0]):
        assert f"| {' | '.join(row[:5])} |" in report
    assert "${" not in report


def test_settings_are_rows_by_their_names(study, tmp_path):
    grid = [{"controller.kp": [100.0]}, {"simulation.dt": [2e-2, 1e-2]}]
    two = Study({**DEFINITION, "motions": {"random": 2, "seed": 3}, "grid": grid}, "settings")
    legs = Study({**DEFINITION, "motions": {"random": 2, "seed": 3, "legs": 2}}, "legs")
    parts = [Part(each, each.run(), "a.parquet", "0" * 64) for each in (two, legs)]
    found = evidence(parts)
    assert [each["setting"] for each in found["conditions"]] == ["kp = 100", "dt = 0.02", "dt = 0.01", "2 legs"]
    assert found["counterexamples"] == []
    fields = hypothesis_fields(found)
    assert fields["settings"].count("| dt = 0.02 |") == 2
    assert "of 4 settings" in fields["settings"]
    shares_figure(found["conditions"]).savefig(tmp_path / "settings.png")
    assert "## Settings" in hypothesis_report(found)


def test_a_page_is_filled_in():
    assert filled_page("${a} costs 3 $$", {"a": "it"}) == "it costs 3 $"
    with pytest.raises(StudyError, match=r"asks for the field 'b'; there are a"):
        filled_page("${b}", {"a": ""})
    with pytest.raises(StudyError, match="a dollar sign is written"):
        filled_page("$ 3", {})


def test_a_table_of_many_runs_is_the_sum_of_its_parts(table):
    """The statistics go through columns: as many motions again count again."""
    again = table.set_column(
        table.column_names.index("sample"), "sample", pa.array([each + 4 for each in table["sample"].to_pylist()])
    )
    (one,), (both,) = conditions(table), conditions(pa.concat_tables([table, again]))
    for law in LAWS:
        single, double = HypothesisResult(one).table(law), HypothesisResult(both).table(law)
        for name in ("kept_calm", "kept_exploded", "left_calm", "left_exploded", "left_first"):
            assert getattr(double, name) == 2 * getattr(single, name)
