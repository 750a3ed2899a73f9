"""Figures of merit, the continuous-time limit and the claims."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from aspect_control import Arm, Circle, StraightLine, controllers, simulate
from aspect_control.analysis import (
    aspect_preserved,
    continuous_limit,
    intervals,
    minor_zero_crossings,
    summarize,
    total_variation,
)
from aspect_control.resources import model_path
from aspect_control.studies.paper import AGREES, DIFFERS, NOT_MEASURED, PARTLY, claims, torque_peaks
from aspect_control.studies.paper import trajectory_a as paper
from oracles.literal import null_space_terms


@pytest.fixture(scope="module")
def reproduction():
    kept = {}
    result = paper.reproduce(1e-3, keep=kept.__setitem__, progress=lambda label, part: None)
    assert kept == result.all_runs
    return result


@given(st.lists(st.booleans(), min_size=2, max_size=40))
def test_intervals_cover_exactly_the_samples_that_are_on(on):
    t = np.arange(len(on), dtype=float)
    covered = np.zeros(len(on), dtype=bool)
    for start, end in intervals(t, np.array(on)):
        covered[(t >= start) & ((t < end) | (end == t[-1]))] |= np.array(on)[
            (t >= start) & ((t < end) | (end == t[-1]))
        ]
        assert on[int(start)]
        assert start == 0 or not on[int(start) - 1]
        assert not on[int(end)] or end == t[-1]
    assert covered.tolist() == on


def test_total_variation_of_a_known_signal():
    values = np.array([[0.0, 1.0], [2.0, 1.0], [-1.0, 1.0]])
    assert total_variation(values).tolist() == [5.0, 0.0]


def test_zero_crossings_are_where_the_minor_vanishes_between_samples(reproduction):
    run = reproduction.runs["null-space-vector"]
    crossings = minor_zero_crossings(run)
    assert [minor for minor, _ in crossings] == [3, 2, 1, 3, 2, 1]
    for minor, time in crossings:
        i = np.searchsorted(run.t, time) - 1
        before, after = run.minors[i, minor - 1], run.minors[i + 1, minor - 1]
        assert before * after < 0.0
        assert run.t[i] < time < run.t[i + 1]


def test_summary_has_the_published_keys_and_agrees_with_the_run(reproduction):
    for law, run in reproduction.runs.items():
        summary = summarize(run)
        for joint in range(3):
            i = round(summary["peak_torque_time"][joint] / run.info.dt)
            assert abs(run.tau[i, joint]) == summary["peak_torque"][joint] == np.abs(run.tau[:, joint]).max()
        assert summary["aspect_preserved"] == (not summary["minor_zero_crossings"])
        assert summary["maciejewski_product_max"] == run.maciejewski_product.max()
        assert summary["max_tracking_error"] == np.linalg.norm(run.x - run.x_desired, axis=1).max()
        assert summary["torque_total_variation"] == np.abs(np.diff(run.tau, axis=0)).sum(axis=0).tolist()
        assert ("null_space_term_on" in summary) == (law == "modified-null-space-vector")


# Starts on a border


READY = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
ON_BORDER = [2, 5, 7, 8, 10, 13, 15, 16, 17, 19]


def run_from_ready(displacement):
    """The panda's usual start, in a plane of symmetry: ten of its minors are zero there."""
    arm = Arm.from_example("panda", frame="panda_hand", task="xyz")
    line = StraightLine(displacement, 1.5, profile="quintic")
    return simulate(controllers.Pseudoinverse(arm), line, q0=READY, dt=4e-3)


@pytest.fixture(scope="module")
def sideways():
    return run_from_ready([0.0, 0.4, 0.1])


@pytest.fixture(scope="module")
def backwards():
    return run_from_ready([-0.5, 0.3, 0.1])


def changes(run, minors):
    """Which of the minors, counted from 1, change their sign after the start."""
    return [minor for minor in minors if len(np.unique(np.sign(run.minors[1:, minor - 1]))) > 1]


def test_minors_that_are_zero_at_the_start_are_listed(sideways):
    summary = summarize(sideways)
    assert summary["minors"] == sideways.minors.shape[1] == 19
    assert summary["minors_on_border_at_start"] == ON_BORDER
    small = np.abs(sideways.minors[0])
    assert small[np.array(ON_BORDER) - 1].max() < 1e-12
    assert np.delete(small, np.array(ON_BORDER) - 1).min() > 1e-3


def test_minors_without_a_sign_at_the_start_cannot_leave_the_aspect(sideways):
    others = [minor for minor in range(1, 20) if minor not in ON_BORDER]
    assert changes(sideways, ON_BORDER)
    assert not changes(sideways, others)
    assert aspect_preserved(sideways)
    assert minor_zero_crossings(sideways) == []
    assert summarize(sideways)["aspect_preserved"]


def test_crossings_of_a_start_on_a_border_are_those_of_the_other_minors(backwards):
    others = [minor for minor in range(1, 20) if minor not in ON_BORDER]
    crossed = {minor for minor, _ in minor_zero_crossings(backwards)}
    assert crossed == set(changes(backwards, others)) == {4, 12, 18}
    assert changes(backwards, ON_BORDER)
    assert not aspect_preserved(backwards)
    assert not summarize(backwards)["aspect_preserved"]


def test_a_start_off_every_border_lists_none(reproduction):
    for run in reproduction.runs.values():
        summary = summarize(run)
        assert (summary["minors"], summary["minors_on_border_at_start"]) == (3, [])
        assert summary["max_orientation_error"] == 0.0


def test_features_of_the_paper_in_the_summary(reproduction):
    summary = {law: summarize(run) for law, run in reproduction.runs.items()}
    assert max(summary["null-space-vector"]["peak_torque"]) > 1e4
    for law in ("modified-null-space-vector", "jmdc"):
        assert summary[law]["aspect_preserved"]
        assert max(summary[law]["peak_torque"]) < 20.0
    assert summary["modified-null-space-vector"]["null_space_term_on"][0][0] == 1.0
    (first, first_size), (second, second_size) = torque_peaks(reproduction.runs["null-space-vector"])
    assert first == pytest.approx(1.25, abs=0.01)
    assert second == pytest.approx(1.8, abs=0.01)
    assert min(first_size, second_size) > 1e3


def test_the_peaks_converge_to_the_continuous_limit_at_first_order(reproduction):
    limit = reproduction.limit.maciejewski_product_max
    errors = np.array([limit - run.maciejewski_product.max() for run in reproduction.refined])
    assert np.all(errors > 0.0)
    assert np.all((errors[:-1] / errors[1:] > 1.5) & (errors[:-1] / errors[1:] < 2.5))


def test_continuous_limit_equals_an_independent_integration(planar):
    def torque(t, q, v, end):
        """Eq. (11) to the letter, with the trajectory written out."""
        state = planar.state(q, v)
        t, a = min(t, end), np.array([1.5, 1.0])
        first = end == 1.0
        x_d = x0 + (0.5 * t**2 if first else 1.0 - 0.5 * (2.0 - t) ** 2) * a
        dx_d, ddx_d = (t if first else 2.0 - t) * a, a if first else -a
        b = ddx_d + 20.0 * (dx_d - state.dx) + 100.0 * (x_d - state.x) - state.drift
        tau_tilde, _, theta_ddot_H = null_space_terms(state, b)
        return tau_tilde + state.M @ theta_ddot_H

    def derivative(t, y, end):
        return np.concatenate([y[3:], pin.aba(planar.model, data, y[:3], y[3:], torque(t, y[:3], y[3:], end))])

    data, x0 = planar.model.createData(), planar.task_position(paper.Q0)
    y, peak = np.concatenate([paper.Q0, np.zeros(3)]), 0.0
    for begin, end in ((0.0, 1.0), (1.0, 2.0)):
        solution = solve_ivp(
            derivative, (begin, end), y, method="DOP853", rtol=1e-10, atol=1e-10, args=(end,), max_step=2e-3
        )
        y = solution.y[:, -1]
        peak = max(
            peak, max(np.abs(torque(t, s[:3], s[3:], end)).max() for t, s in zip(solution.t, solution.y.T, strict=True))
        )
    limit = continuous_limit(controllers.NullSpaceVector(planar), paper.TRAJECTORY, paper.Q0)
    # Both solvers work to 1e-10, and the motion stretches an error by a factor of some 1e3.
    np.testing.assert_allclose(limit.q_end, y[:3], atol=1e-6)
    # The independent peak is read at the solver's own steps, so that it can only be lower.
    assert peak <= limit.peak_torque.max() * (1.0 + 1e-6)
    assert peak == pytest.approx(limit.peak_torque.max(), rel=0.02)


def test_every_claim_is_judged_and_reasons_are_given_where_it_fails(reproduction):
    judged = claims(reproduction)
    assert len(judged) == 20
    assert {claim.verdict for claim in judged} <= {AGREES, PARTLY, DIFFERS}
    assert all(claim.why for claim in judged if claim.verdict != AGREES)
    verdicts = {claim.says: claim.verdict for claim in judged}
    assert verdicts["Joint torques are drastically held down."] == AGREES
    assert verdicts["Small minors make J⁺ large, hence τ̃, hence the torque."] == DIFFERS
    assert verdicts["The null-space term is on from 1.0 to 1.65 s and from 1.8 to 2.0 s."] == PARTLY


def test_verdicts_follow_the_runs(reproduction):
    calm = reproduction.runs["modified-null-space-vector"]
    swapped = reproduction._replace(runs={**reproduction.runs, "jmdc": reproduction.runs["null-space-vector"]})
    verdicts = {(claim.subject, claim.says): claim.verdict for claim in claims(swapped)}
    assert verdicts["JMDC", "The configurations belong to only one aspect."] == DIFFERS
    assert verdicts["JMDC", "Joint torques are drastically reduced."] == DIFFERS
    swapped = reproduction._replace(runs={**reproduction.runs, "null-space-vector": calm})
    verdicts = {(claim.subject, claim.says): claim.verdict for claim in claims(swapped)}
    assert verdicts["modified method", "Joint torques are drastically held down."] == DIFFERS


def test_runs_that_end_early_or_are_sampled_too_coarsely_are_not_judged(reproduction):
    lost = paper.run_law("null-space-vector", 0.05)
    assert lost.status == "tracking lost"
    early = reproduction._replace(runs={**reproduction.runs, "null-space-vector": lost})
    assert [claim.verdict for claim in claims(early)] == [NOT_MEASURED]
    assert [claim.verdict for claim in claims(reproduction._replace(dt=0.5))] == [NOT_MEASURED]


def test_the_order_of_the_task_s_coordinates_is_nothing_to_the_continuous_limit():
    circle = Circle(0.2, 1.0, "xy")
    ends = []
    for task in ("xy", ("y", "x")):
        arm = Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task=task, gravity=(0, 0, 0))
        ends.append(continuous_limit(controllers.Pseudoinverse(arm), circle, paper.Q0).q_end)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-8)


def test_the_continuous_limit_of_a_task_with_a_rotation_is_what_ever_finer_runs_converge_to():
    arm = Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task=("x", "rz"), gravity=(0, 0, 0))
    law, line = controllers.Pseudoinverse(arm), StraightLine([0.3, -0.5], 1.0, "quintic")
    limit = continuous_limit(law, line, paper.Q0)
    errors = [np.linalg.norm(simulate(law, line, q0=paper.Q0, dt=dt).q[-1] - limit.q_end) for dt in (4e-3, 2e-3, 1e-3)]
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2.0, atol=0.1)
