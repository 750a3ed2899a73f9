"""The hypothesis on random motions: draws, definitions, statistics, processes."""

import json
import math
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import pearsonr, rankdata

from aspect_control.analysis import aspect_preserved
from aspect_control.exceptions import (
    ParameterError,
    UnknownNameError,
    WorkerError,
)
from aspect_control.scenario import load_scenario
from aspect_control.studies.hypothesis import (
    ABLATION,
    EXPLODED_INSIDE,
    LEFT_AND_CALM,
    THRESHOLDS,
    AspectTable,
    Experiment,
    HypothesisResult,
    Outcome,
    SampleOutcome,
    examine_hypothesis,
    proportion,
    rank_correlation,
    time_estimate,
)
from aspect_control.studies.hypothesis.outcome import sample_outcome
from aspect_control.studies.hypothesis.parallel import processes
from aspect_control.views import hypothesis_figure, hypothesis_report, hypothesis_verdict

LAWS = ("pseudoinverse", "null-space-vector")


@pytest.fixture(scope="module")
def experiment():
    return Experiment.of("planar3r", load_scenario("planar3r"), seed=3, dt=1e-2, laws=LAWS)


@pytest.fixture(scope="module")
def result(experiment):
    return examine_hypothesis(experiment, 4, workers=2)


def made(law="jmdc", **changes):
    values = {
        "status": "finished",
        "end": 2.0,
        "peak_torque": 20.0,
        "peak_ratio": 1.0,
        "aspect_preserved": True,
        "sign_changes": 0,
        "left_at": None,
        "margin": 0.1,
        "exploded_at": (None,) * len(THRESHOLDS),
        "manipulability": 1.0,
        "self_motion": 0.1,
    }
    return Outcome(law, **{**values, **changes})


def sample(index, *outcomes, reference=20.0):
    return SampleOutcome(index, (0.0,) * 3, (1.0, 0.0), 2.0, 0, 0, reference, outcomes)


# The draws


@pytest.mark.parametrize(("name", "draws"), [("planar3r", 20), ("panda-xyz", 20), ("panda-pose", 2)])
def test_draws_are_inside_the_limits_and_both_ends_are_within_reach(name, draws):
    experiment = Experiment.of(name, load_scenario(name), seed=5)
    arm, own = experiment.arm, experiment.own_line
    acceleration = np.linalg.norm(own.displacement[:3]) / own.duration**2
    for index in range(draws):
        draw = experiment.draw(index)
        arm.require_within_limits(draw.q0)
        length = np.linalg.norm(draw.line.displacement[:3]) / np.linalg.norm(own.displacement[:3])
        assert 0.5 <= length <= 1.5
        assert np.linalg.norm(draw.line.displacement[:3]) / draw.line.duration**2 == pytest.approx(acceleration)
        assert draw.line.profile == own.profile
        assert len(arm.minors_on_border(draw.q0)) == 0
        if name == "planar3r":
            assert np.linalg.norm(arm.task_position(draw.q0) + draw.line.displacement) <= arm.reach


def test_starts_fill_the_whole_turn_and_directions_are_even():
    experiment = Experiment.of("planar3r", load_scenario("planar3r"), seed=0)
    draws = [experiment.draw(index) for index in range(400)]
    angles = np.array([experiment.arm.positions(draw.q0) for draw in draws])
    assert np.all(np.abs(angles) <= np.pi)
    # The first angle turns the whole picture, so that it and the direction of the line are uniform.
    directions = np.array([np.arctan2(*draw.line.displacement[::-1]) for draw in draws])
    for values in (angles[:, 0], directions):
        assert abs(np.exp(1j * values).mean()) < 3.0 / math.sqrt(len(draws))


def test_a_draw_depends_on_seed_and_index_alone(experiment):
    again = Experiment.of("planar3r", load_scenario("planar3r"), seed=3, dt=1e-3)
    for index in (7, 2, 0):
        one, other = experiment.draw(index), again.draw(index)
        assert one.q0.tobytes() == other.q0.tobytes()
        assert one.line.displacement.tobytes() == other.line.displacement.tobytes()
    starts = {experiment.draw(index).q0.tobytes() for index in range(20)}
    assert len(starts) == 20
    assert replace(experiment, seed=4).draw(0).q0.tobytes() not in starts


def test_laws_are_the_scenarios_and_jmdc_without_the_minor_measure():
    experiment = Experiment.of("planar3r", load_scenario("planar3r"))
    assert experiment.laws == (
        "pseudoinverse",
        "null-space-vector",
        "modified-null-space-vector",
        "jmdc",
        "jmdc-without-minor-measure",
    )
    assert experiment.scenario.controllers[-1].parameters == {"kappa": 0.0}
    assert Experiment.of("planar3r", load_scenario("planar3r"), laws=[ABLATION]).laws == (ABLATION,)


def test_starts_at_rank_loss_are_drawn_again_and_counted(tmp_path, planar_path):
    _, second, third = re.split(r"(?=<limit )", planar_path.read_text())[1:]
    text = planar_path.read_text()
    for part in (second, third):
        text = text.replace(part, re.sub(r"<limit [^>]*>", STIFF, part))
    (tmp_path / "stretched.urdf").write_text(text)
    shipped = (Path(__file__).parents[2] / "scenarios" / "planar3r.toml").read_text()
    stretched = shipped.replace('example = "planar3r"', 'urdf = "stretched.urdf"').replace("140, -140", "0, 0")
    (tmp_path / "stretched.toml").write_text(stretched)
    with pytest.raises(ParameterError, match=r"no line was found for stretched .* [1-9][\d,]* started on a border"):
        Experiment.of("stretched", load_scenario(tmp_path / "stretched.toml"))


STIFF = '<limit lower="-1e-9" upper="1e-9" effort="1e6" velocity="1e3"/>'


# Definitions


def test_outcomes_agree_with_the_runs(experiment, result):
    for each in result.samples:
        runs = {law: experiment.run(each.index, law) for law in LAWS}
        peaks = {law: np.abs(run.tau).max() for law, run in runs.items()}
        assert each.reference == min(peaks[law] for law, run in runs.items() if run.status == "finished")
        for found in each.outcomes:
            run = runs[found.law]
            assert found.peak_torque == peaks[found.law]
            assert found.peak_ratio == peaks[found.law] / each.reference
            assert (found.margin > 0.0) == found.aspect_preserved == aspect_preserved(run) == (found.left_at is None)
            if found.aspect_preserved:
                assert found.margin == pytest.approx(run.border_distance.min())
            for threshold, at in zip(THRESHOLDS, found.exploded_at, strict=True):
                assert found.exploded(threshold) == (at is not None)
                if at is not None and at < run.t[-1]:
                    assert np.abs(run.tau[run.t < at]).max(initial=0.0) <= threshold * each.reference


@pytest.mark.parametrize(
    ("changes", "burst"),
    [({}, False), ({"peak_ratio": 10.0}, False), ({"peak_ratio": 10.1}, True), ({"status": "tracking lost"}, True)],
)
def test_exploded_is_an_early_end_or_a_peak_beyond_the_threshold(changes, burst):
    assert made(**changes).exploded(10.0) is burst


def test_a_sample_that_no_law_finishes_is_in_no_table(tmp_path):
    scenario = load_scenario("planar3r", ["limits.tracking=1e-9"])
    experiment = Experiment.of("planar3r", scenario, dt=1e-2, laws=LAWS)
    result = examine_hypothesis(experiment, 2)
    assert result.undecided == (0, 1)
    assert result.table("pseudoinverse").total == 0
    assert "No run left its aspect" in " ".join(hypothesis_verdict(result))
    assert "Left out, since no law finished: 2" in hypothesis_report(result)
    json.dumps(result.to_dict(), allow_nan=False)
    hypothesis_figure(result).savefig(tmp_path / "empty.png")


# Statistics

pairs = st.lists(st.tuples(st.booleans(), st.floats(0.1, 1e6), st.booleans()), max_size=30)


@settings(max_examples=25)
@given(pairs)
def test_tables_add_up(runs):
    outcomes = [
        made(aspect_preserved=kept, peak_ratio=ratio, status="finished" if done else "diverged")
        for kept, ratio, done in runs
    ]
    tables = [AspectTable.of("jmdc", outcomes, threshold, place) for place, threshold in enumerate(THRESHOLDS)]
    for table in tables:
        assert table.total == len(runs)
        assert table.kept == sum(kept for kept, _, _ in runs)
        burst = sum(not done or ratio > table.threshold for _, ratio, done in runs)
        assert table.kept_exploded + table.left_exploded == burst
        assert table.exploded_if_left.count + table.calm_if_left.count == table.left
        json.dumps(table.to_dict(), allow_nan=False)
    calm = [table.kept_calm + table.left_calm for table in tables]
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


def test_which_came_first_is_read_off_the_times():
    burst = {"aspect_preserved": False, "peak_ratio": 50.0}
    at = (0.4, 0.5, 0.6, 0.7, None)
    outcomes = [
        made(**burst, left_at=0.6, exploded_at=at),
        made(**burst, left_at=0.61, exploded_at=at),
        made(aspect_preserved=False, left_at=0.1),
        made(peak_ratio=50.0, exploded_at=at),
    ]
    table = AspectTable.of("jmdc", outcomes, 10.0, 2)
    assert (table.left_first, table.exploded_inside.count, table.exploded_inside.total) == (1, 2, 3)


def test_clearest_counterexamples_went_farthest_at_the_strictest_threshold():
    law = "pseudoinverse"
    single = Experiment.of("planar3r", load_scenario("planar3r"), laws=[law])
    left = {"law": law, "aspect_preserved": False}
    samples = (
        sample(0, made(**left, margin=-0.9, peak_ratio=5.0)),
        sample(1, made(**left, margin=-0.2, peak_ratio=1.5)),
        sample(2, made(**left, margin=-0.3, peak_ratio=1.5)),
        sample(3, made(**left, margin=-0.8, peak_ratio=50.0)),
        sample(4, made(law, peak_ratio=50.0)),
        sample(5, made(law, peak_ratio=500.0)),
        sample(6, made(law, peak_ratio=None), reference=None),
    )
    found = HypothesisResult(single, 7, samples).clearest()
    assert [(each.kind, each.index) for each in found] == [
        (LEFT_AND_CALM, 2),
        (LEFT_AND_CALM, 1),
        (EXPLODED_INSIDE, 5),
        (EXPLODED_INSIDE, 4),
    ]
    hard = sample(7, made(**left, peak_torque=5e3), reference=5e3)
    harder = HypothesisResult(single, 8, (*samples, hard))
    assert (harder.demanding, harder.bound) == ((7,), 200.0)
    assert "3 below 10 times" in " ".join(hypothesis_verdict(harder))
    words = " ".join(hypothesis_verdict(HypothesisResult(single, 7, samples)))
    assert "Necessary for a calm torque? No: 3 of 4 runs" in words
    assert "2 of them within 2 times the reference and 3 below 10 times the median reference" in words
    assert "Sufficient? No: 2 of 2 runs" in words


# Processes


def test_the_number_of_workers_changes_nothing(experiment, result):
    assert [each.index for each in result.samples] == list(range(4))
    assert result.samples == tuple(sample_outcome(experiment, index) for index in range(4))


def test_counterexamples_are_run_again_at_a_quarter_of_the_sampling_time(experiment, result):
    assert result.counterexamples
    each = result.counterexamples[0]
    run = experiment.run(each.index, each.outcome.law, experiment.dt / 4)
    assert each.finer.peak_torque == np.abs(run.tau).max()
    reference = each.outcome.peak_torque / each.outcome.peak_ratio
    assert each.finer.peak_ratio == pytest.approx(each.finer.peak_torque / reference)
    assert each.holds == (not each.finer.aspect_preserved and not each.finer.exploded(10.0))


def test_an_interrupt_keeps_what_was_computed(experiment):
    kept, before = [], dict(os.environ)

    def keep(result):
        kept.append(result)
        if len(result.samples) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        examine_hypothesis(experiment, 10_000, workers=2, keep=keep)
    assert len(kept[-1].samples) == 2
    assert kept[-1].samples[0] == sample_outcome(experiment, kept[-1].samples[0].index)
    assert dict(os.environ) == before
    assert "Interrupted" in hypothesis_report(kept[-1])


def end(state, item):
    os._exit(3)


def test_a_process_that_ends_by_itself_is_one_clear_error():
    with pytest.raises(WorkerError, match="a worker process ended by itself"), processes(None, 2) as spread:
        list(spread(end, [0]))


def test_a_law_that_is_not_there_is_named_with_those_that_are(experiment):
    with pytest.raises(UnknownNameError, match=r"'magic'.*'jmdc'"):
        Experiment.of("planar3r", load_scenario("planar3r"), laws=["magic"])
    with pytest.raises(UnknownNameError, match=r"'magic'.*'pseudoinverse'"):
        experiment.run(0, "magic")


def test_the_estimate_grows_with_the_samples_and_falls_with_the_workers(experiment):
    one, many = time_estimate(experiment, 10, 1), time_estimate(experiment, 100_000, 1)
    assert many > 100.0 * one > 0.0
    assert time_estimate(experiment, 100_000, 8) < many
