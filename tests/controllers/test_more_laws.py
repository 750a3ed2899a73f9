"""The laws beyond the paper's, and soft switching of the modified law, against their equations to the letter."""

import json

import numpy as np
import pytest

from aspect_control import Hold, StraightLine, Target, controllers, criteria, simulate
from aspect_control.analysis import aspect_preserved, peak_torque, total_variation
from aspect_control.exceptions import (
    NonFiniteError,
    NotRedundantError,
    NotResetError,
    ParameterError,
    TooManyMinorsError,
    UnknownNameError,
)
from aspect_control.redundancy import manipulability, manipulability_gradient
from aspect_control.scenario import load_scenario
from aspect_control.studies.paper import trajectory_a as paper
from example_arms import example_arm, random_postures, slopes
from oracles.literal import Printed

LAWS = {
    "damped-null-space": controllers.DampedNullSpace,
    "inertia-weighted": controllers.InertiaWeighted,
    "jmdc": controllers.JMinorDynamicControl,
    "modified-null-space-vector": controllers.ModifiedNullSpaceVector,
    "null-space-vector": controllers.NullSpaceVector,
    "operational-space": controllers.OperationalSpace,
    "pseudoinverse": controllers.Pseudoinverse,
    "resolved-motion": controllers.ResolvedMotion,
}
TASK_SPACE_LAWS = {
    "pseudoinverse": {},
    "null-space-vector": {},
    "modified-null-space-vector": {"switching": "hard"},
    "modified-null-space-vector, dead-beat": {"switching": "dead-beat"},
    "modified-null-space-vector, brake": {"switching": "brake"},
    "damped-null-space": {"damping": 7.0},
    "inertia-weighted": {},
    "operational-space": {"damping": 7.0},
}
DT = 1e-3
DAMPED = ["damped-null-space", "operational-space"]
SOFT_SWITCHINGS = ["dead-beat", "brake"]
soft_switching = pytest.mark.parametrize("switching", SOFT_SWITCHINGS)
damped_law = pytest.mark.parametrize("law", DAMPED)


@pytest.fixture(scope="module", params=["planar", "seven", "panda xyz", "panda pose"])
def arm(request):
    if request.param.startswith("panda"):
        return example_arm(*request.param.split())
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module", params=["planar", "panda pose"])
def arm_with_one_joint_to_spare(request):
    return example_arm(*request.param.split()) if " " in request.param else request.getfixturevalue(request.param)


def create(label, arm, **parameters):
    return controllers.create(label.split(",")[0], arm, **TASK_SPACE_LAWS.get(label, {}), **parameters)


def projector(J):
    return np.eye(J.shape[1]) - np.linalg.pinv(J) @ J


def random_target(arm, q, rng):
    """A target within reach of the gains: the task value near the arm's own."""
    x = arm.coordinates.displaced(arm.task_position(q), rng.uniform(-0.5, 0.5, arm.task_dim))
    return Target(x, *rng.normal(0.0, 1.0, (2, arm.task_dim)))


def random_samples(arm, count, seed, self_motion=1.0):
    """Measured states, with self-motion of some size, and targets; away from singularities."""
    rng = np.random.default_rng(seed)
    while count > 0:
        q, v = rng.uniform(-np.pi, np.pi, arm.nv), rng.normal(0.0, 1.0, arm.nv)
        J = arm.jacobian(q)
        if np.linalg.cond(J) < 60.0:
            size = self_motion(rng) if callable(self_motion) else self_motion
            yield q, v + (size - 1.0) * projector(J) @ v, random_target(arm, q, rng)
            count -= 1


def gains(size):
    """Two positive definite matrices, neither symmetric."""
    rng = np.random.default_rng(0)
    p, v = rng.normal(0.0, 2.0, (2, size, size))
    return np.diag(rng.uniform(50.0, 150.0, size)) + p - p.T, np.diag(rng.uniform(10.0, 30.0, size)) + v - v.T


def rounding(printed):
    """Every law adds and subtracts torques of this size, and rounds accordingly."""
    return 1e-9 * (1.0 + np.linalg.norm(printed.tau_tilde))


def agree(printed, tau, expected):
    np.testing.assert_allclose(tau, expected, rtol=0, atol=rounding(printed))


def self_motion_energy(run):
    """½ θ̇_HᵀMθ̇_H at every sample, J."""
    rows = zip(run.homogeneous_velocity, run.q, run.v, strict=True)
    return np.array([0.5 * h @ run.arm.state(q, v).M @ h for h, q, v in rows])


# Task acceleration


@pytest.mark.parametrize("label", TASK_SPACE_LAWS)
def test_task_space_laws_bring_about_the_commanded_task_acceleration(arm, label):
    Kp, Kv = gains(arm.task_dim)
    controller = create(label, arm, kp=Kp, kv=Kv)
    for q, v, target in random_samples(arm, 40, seed=1):
        controller.reset(q, v, DT)
        printed = Printed(arm, q, v, target, Kp, Kv)
        tau = controller.torque(q, v, target)
        size = np.linalg.norm(printed.b) + np.linalg.norm(printed.J @ printed.M_inv, 2) * np.linalg.norm(tau)
        np.testing.assert_allclose(printed.task_acceleration(tau), printed.b, rtol=0, atol=1e-10 * size)


# Damped null space


@pytest.mark.parametrize("damping", [0.0, 10.0, 35.0])
def test_damped_null_space_is_the_pseudoinverse_law_less_the_damped_self_motion(arm, damping):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.DampedNullSpace(arm, kp=Kp, kv=Kv, damping=damping)
    for q, v, target in random_samples(arm, 60, seed=2):
        p = Printed(arm, q, v, target, Kp, Kv)
        agree(p, controller.torque(q, v, target), p.tau_tilde - damping * p.M @ p.P @ v)


def test_damped_null_space_without_damping_is_the_pseudoinverse_law(arm):
    undamped, plain = controllers.DampedNullSpace(arm, damping=0.0), controllers.Pseudoinverse(arm)
    for q, v, target in random_samples(arm, 20, seed=3):
        np.testing.assert_array_equal(undamped.torque(q, v, target), plain.torque(q, v, target))


# Inertia-weighted


def test_inertia_weighted_law_is_the_task_force_through_the_transposed_jacobian(arm):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.InertiaWeighted(arm, kp=Kp, kv=Kv)
    for q, v, target in random_samples(arm, 60, seed=4):
        p = Printed(arm, q, v, target, Kp, Kv)
        agree(p, controller.torque(q, v, target), p.J.T @ p.Lambda @ p.b + p.N)


def test_inertia_weighted_law_has_the_least_acceleration_in_the_norm_of_the_inertia(arm):
    rng = np.random.default_rng(5)
    controller = controllers.InertiaWeighted(arm)
    for q, v, target in random_samples(arm, 40, seed=5):
        p = Printed(arm, q, v, target)
        best = p.M_inv @ (controller.torque(q, v, target) - p.N)
        least = best @ p.M @ best
        for size in 10.0 ** rng.uniform(-2.0, 2.0, 30):
            addition = size * p.P @ rng.normal(0.0, 1.0, arm.nv)
            other = best + addition
            np.testing.assert_allclose(p.J @ other, p.J @ best, rtol=0, atol=1e-10 * (1 + np.linalg.norm(other)))
            more = addition @ p.M @ addition
            # Pythagoras: the addition is M-orthogonal to the best, so that it can only add.
            assert other @ p.M @ other - least == pytest.approx(more, rel=1e-6, abs=1e-9 * (least + more))
            assert more > 0.0


def test_inertia_weighted_law_is_not_the_pseudoinverse_law(arm):
    (q, v, target), *_ = random_samples(arm, 1, seed=6)
    p = Printed(arm, q, v, target)
    tau = controllers.InertiaWeighted(arm).torque(q, v, target)
    assert np.linalg.norm(tau - p.tau_tilde) > 1e-3 * np.linalg.norm(p.tau_tilde)


# Operational space


@pytest.mark.parametrize("damping", [0.0, 10.0, 35.0])
def test_operational_space_law_is_khatibs(arm, damping):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.OperationalSpace(arm, kp=Kp, kv=Kv, damping=damping)
    for q, v, target in random_samples(arm, 60, seed=7):
        p = Printed(arm, q, v, target, Kp, Kv)
        tau_0 = -damping * p.M @ v
        null_torque = (np.eye(arm.nv) - p.J.T @ p.J_bar.T) @ tau_0
        agree(p, controller.torque(q, v, target), p.J.T @ p.Lambda @ p.b + p.N + null_torque)


def test_operational_space_damping_brings_about_no_task_acceleration_but_brakes(arm):
    plain, braked = (controllers.OperationalSpace(arm, damping=damping) for damping in (0.0, 25.0))
    for q, v, target in random_samples(arm, 60, seed=8):
        p = Printed(arm, q, v, target)
        null_torque = braked.torque(q, v, target) - plain.torque(q, v, target)
        size = np.linalg.norm(p.J @ p.M_inv, 2) * (np.linalg.norm(p.tau_tilde) + 25.0 * np.linalg.norm(p.M @ v))
        np.testing.assert_allclose(p.J @ p.M_inv @ null_torque, 0.0, rtol=0, atol=1e-10 * size)
        assert null_torque @ v < 0.0


def test_operational_space_without_damping_is_the_inertia_weighted_law(arm):
    plain, weighted = controllers.OperationalSpace(arm, damping=0.0), controllers.InertiaWeighted(arm)
    for q, v, target in random_samples(arm, 20, seed=9):
        np.testing.assert_array_equal(plain.torque(q, v, target), weighted.torque(q, v, target))


# Damping in closed loop


@damped_law
def test_self_motion_decays_at_the_rate_of_the_damping_while_the_task_stands_still(arm, law):
    rng = np.random.default_rng(3)
    q0 = rng.uniform(-1.0, 1.0, arm.nv)
    v0 = projector(arm.jacobian(q0)) @ rng.normal(0.0, 1.0, arm.nv)
    run = simulate(controllers.create(law, arm, damping=10.0), Hold(0.5), q0=q0, v0=v0, dt=2e-3)
    energy = self_motion_energy(run)
    assert run.status == "finished"
    assert energy[0] > 5e-3
    assert np.diff(energy).max() < 0.0
    # The inertia changes on the way, hence not e⁻¹⁰ to the digit.
    assert 0.5 * np.exp(-10.0) < energy[-1] / energy[0] < 2.0 * np.exp(-10.0)
    assert run.tracking_error.max() < 1e-3


@damped_law
def test_self_motion_does_not_decay_without_damping(arm, law):
    rng = np.random.default_rng(3)
    q0 = rng.uniform(-1.0, 1.0, arm.nv)
    v0 = projector(arm.jacobian(q0)) @ rng.normal(0.0, 1.0, arm.nv)
    energy = self_motion_energy(simulate(controllers.create(law, arm, damping=0.0), Hold(0.5), q0=q0, v0=v0, dt=2e-3))
    assert energy[-1] > 0.5 * energy[0]


# Manipulability


@pytest.mark.parametrize("name", ["planar", "seven", "panda pose", "panda xyz", "kinova xyz", "pr2 xyz"])
def test_manipulability_gradient_is_that_of_central_differences(request, name):
    arm = example_arm(*name.split()) if " " in name else request.getfixturevalue(name)
    for q in random_postures(arm, 15, seed=10):
        J = arm.jacobian(q)
        exact = manipulability_gradient(J, arm.jacobian_derivative(q))
        differences = slopes(arm, lambda q: manipulability(arm.jacobian(q)), q)
        size = max(np.linalg.norm(exact), float(manipulability(J)))
        np.testing.assert_allclose(exact, differences, rtol=0, atol=1e-6 * size)


def test_manipulability_gradient_is_zero_where_the_jacobian_has_lost_rank(planar):
    q = np.zeros(3)
    np.testing.assert_allclose(
        manipulability_gradient(planar.jacobian(q), planar.jacobian_derivative(q)), 0.0, rtol=0, atol=1e-12
    )


# Resolved motion


def printed_resolved_motion(arm, samples, q0, v0, Kp, Kv, kappa):
    """Eqs. (2) and (19)–(21), by lists indexed with i as in the paper."""
    theta_d, dtheta_d = [q0], [v0]
    for i, (q, v, target) in enumerate(samples):
        s = arm.state(q, v)
        ddtheta_d = (dtheta_d[i] - dtheta_d[i - 1]) / DT if i > 0 else np.zeros(arm.nv)
        yield s.M @ (ddtheta_d + Kv @ (dtheta_d[i] - v) + Kp @ (theta_d[i] - q)) + s.nle
        J, dJ = s.J, arm.jacobian_derivative(q)
        w, JJ_inv = np.sqrt(np.linalg.det(J @ J.T)), np.linalg.inv(J @ J.T)
        slope = [0.5 * w * np.trace(JJ_inv @ (dJ[:, :, k] @ J.T + J @ dJ[:, :, k].T)) for k in range(arm.nv)]
        theta_d.append(theta_d[i] + dtheta_d[i] * DT)
        dtheta_d.append(np.linalg.pinv(J) @ target.dx + kappa * projector(J) @ np.array(slope))


@pytest.mark.parametrize("kappa", [0.0, 0.001, 2.0])
@pytest.mark.parametrize("moving", [False, True], ids=["from rest", "moving"])
def test_resolved_motion_is_equation_2_with_computed_torque(arm, kappa, moving):
    Kp, Kv = gains(arm.nv)
    controller = controllers.ResolvedMotion(arm, kp=Kp, kv=Kv, kappa=kappa, criterion="manipulability")
    samples = list(random_samples(arm, 40, seed=11))
    q0, v0 = np.linspace(0.1, 0.9, arm.nv), moving * np.linspace(-1.0, 2.0, arm.nv)
    controller.reset(q0, v0, DT)
    expected = printed_resolved_motion(arm, samples, q0, v0, Kp, Kv, kappa)
    for (q, v, target), tau in zip(samples, expected, strict=True):
        # θ̈_d divides a difference of speeds by dt, and with it their rounding.
        tolerance = 1e-10 * (1.0 + np.linalg.norm(tau))
        np.testing.assert_allclose(controller.torque(q, v, target), tau, rtol=0, atol=tolerance)


@pytest.mark.parametrize("kappa", [0.0, 0.001, 0.3])
@pytest.mark.parametrize("scenario", ["planar3r", "panda-xyz", "kinova-xyz"])
def test_resolved_motion_by_the_minor_measure_is_jmdc_bit_for_bit(scenario, kappa):
    setup = load_scenario(scenario).build()
    arm, q0, trajectory = setup.arm, setup.q0, setup.trajectory
    resolved = controllers.ResolvedMotion(arm, kappa=kappa, criterion="minor-measure")
    jmdc = controllers.JMinorDynamicControl(arm, kappa=kappa)
    one, other = (simulate(law, trajectory, q0=q0, dt=4e-3) for law in (resolved, jmdc))
    assert one.status == other.status
    assert len(one.t) > 100
    for name in ("q", "v", "tau"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_resolved_motion_without_a_criterion_is_jmdc_without_one_bit_for_bit(arm):
    samples = list(random_samples(arm, 20, seed=12))
    laws = (
        controllers.ResolvedMotion(arm, kappa=0.0, criterion="manipulability"),
        controllers.ResolvedMotion(arm, kappa=0.0, criterion="minor-measure"),
        controllers.JMinorDynamicControl(arm, kappa=0.0),
    )
    for law in laws:
        law.reset(samples[0][0], samples[0][1], DT)
        assert law.criterion is None
    for q, v, target in samples:
        first, second, jmdc = (law.torque(q, v, target) for law in laws)
        np.testing.assert_array_equal(first, jmdc)
        np.testing.assert_array_equal(second, jmdc)


def test_resolved_motion_climbs_the_manipulability_while_the_task_stands_still(arm):
    q0 = np.array([0.3, 0.7, -1.1, -0.9, 0.5, 1.2, 0.4])[: arm.nv]

    def values(kappa):
        run = simulate(controllers.ResolvedMotion(arm, kappa=kappa), Hold(0.5), q0=q0, dt=2e-3)
        assert run.status == "finished"
        assert run.tracking_error.max() < 1e-3
        return manipulability(run.jacobians)

    still, climbing = values(0.0), values(1.0)
    np.testing.assert_allclose(still, still[0], rtol=1e-9)
    assert np.diff(climbing).min() >= 0.0
    assert climbing[-1] > still[-1] * (1.0 + 1e-5)


def test_own_gradient_of_a_derived_criterion_is_the_one_that_counts(arm):
    class Twice(criteria.MinorMeasure):
        def gradient(self, state):
            return 2.0 * criteria.MinorMeasure.gradient(self, state)

    (q, v, target), *_ = random_samples(arm, 1, seed=14)
    laws = [
        controllers.ResolvedMotion(arm, kappa=0.01, criterion=Twice(arm)),
        controllers.ResolvedMotion(arm, kappa=0.02, criterion=criteria.MinorMeasure(arm)),
    ]
    for law in laws:
        law.reset(q, v, 1e-3)
        law.torque(q, v, target)
    once, again = (law.torque(q, v, target) for law in laws)
    np.testing.assert_allclose(once, again, rtol=1e-9)


@pytest.mark.parametrize("law", ["jmdc", "resolved-motion"])
def test_refused_sample_leaves_the_memory_as_it_was(arm, law):
    refused, plain = controllers.create(law, arm), controllers.create(law, arm)
    motions = list(random_samples(arm, 3, seed=15))
    for each in (refused, plain):
        each.reset(*motions[0][:2], 1e-3)
    for q, v, target in motions:
        for bad in ((np.full_like(q, np.nan), v), (q, np.full_like(v, np.inf)), (q, np.full_like(v, 1e200))):
            with pytest.raises(NonFiniteError):
                refused.torque(*bad, target)
        np.testing.assert_array_equal(refused.torque(q, v, target), plain.torque(q, v, target))


def test_resolved_motion_needs_a_reset(arm):
    (q, v, target), *_ = random_samples(arm, 1, seed=13)
    with pytest.raises(NotResetError, match=r"resolved-motion has memory: call reset\(q, v, dt\)"):
        controllers.ResolvedMotion(arm).torque(q, v, target)


# Dead-beat and brake switching


def sizes(rng):
    """From self-motion that one sample can stop to self-motion that it cannot."""
    return 10.0 ** rng.uniform(-5.0, 0.5)


def test_dead_beat_scales_the_null_space_term_as_it_says(arm):
    Kp, Kv = gains(arm.task_dim)
    hard, dead_beat = (
        controllers.ModifiedNullSpaceVector(arm, kp=Kp, kv=Kv, switching=each) for each in ("hard", "dead-beat")
    )
    plain = controllers.Pseudoinverse(arm, kp=Kp, kv=Kv)
    met = {"off": 0, "scaled": 0, "full": 0}
    for q, v, target in random_samples(arm, 400, seed=14, self_motion=sizes):
        p = Printed(arm, q, v, target, Kp, Kv)
        dead_beat.reset(q, v, DT)
        tau = dead_beat.torque(q, v, target)
        if p.product >= 0.0:
            met["off"] += 1
            np.testing.assert_array_equal(tau, plain.torque(q, v, target))
            continue
        scale = p.theta_dot_H @ p.theta_dot_H / (-p.product * DT)
        met["full" if scale >= 1.0 else "scaled"] += 1
        agree(p, tau, p.tau_tilde + min(1.0, scale) * (p.tau_minimum - p.tau_tilde))
        if scale >= 1.0 + 1e-6:
            atol = 1e-13 * (1.0 + np.linalg.norm(p.tau_tilde))
            np.testing.assert_allclose(tau, hard.torque(q, v, target), rtol=0, atol=atol)
    assert min(met.values()) > 20


def test_brake_applies_the_part_of_the_null_space_term_along_the_self_motion(arm):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.ModifiedNullSpaceVector(arm, kp=Kp, kv=Kv, switching="brake")
    plain = controllers.Pseudoinverse(arm, kp=Kp, kv=Kv)
    met = {"off": 0, "to rest": 0, "braked": 0}
    for q, v, target in random_samples(arm, 400, seed=20, self_motion=sizes):
        p = Printed(arm, q, v, target, Kp, Kv)
        controller.reset(q, v, DT)
        tau = controller.torque(q, v, target)
        if p.product >= 0.0:
            met["off"] += 1
            np.testing.assert_array_equal(tau, plain.torque(q, v, target))
            continue
        along = np.outer(p.theta_dot_H, p.theta_dot_H) / (p.theta_dot_H @ p.theta_dot_H) @ p.theta_ddot_H
        to_rest = -p.theta_dot_H / DT
        stops = np.linalg.norm(to_rest) < np.linalg.norm(along)
        met["to rest" if stops else "braked"] += 1
        agree(p, tau, p.tau_tilde + p.M @ (to_rest if stops else along))
    assert min(met.values()) > 20


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
def test_brake_and_dead_beat_are_one_for_one_joint_to_spare(arm_with_one_joint_to_spare, dt):
    arm = arm_with_one_joint_to_spare
    laws = [controllers.ModifiedNullSpaceVector(arm, switching=each) for each in SOFT_SWITCHINGS]
    for q, v, target in random_samples(arm, 100, seed=21, self_motion=sizes):
        for law in laws:
            law.reset(q, v, dt)
        one, other = (law.torque(q, v, target) for law in laws)
        agree(Printed(arm, q, v, target), one, other)


def after_a_sample(p, tau, dt):
    """θ̇_H after one sample of exact integration in the null space, and what rounding may add to it."""
    return p.theta_dot_H + dt * p.M_inv @ (tau - p.tau_tilde), dt * np.linalg.norm(p.M_inv, 2) * rounding(p)


@soft_switching
@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
def test_soft_switching_never_reverses_the_self_motion_within_a_sample(arm, switching, dt):
    braked = 0
    controller = controllers.ModifiedNullSpaceVector(arm, switching=switching)
    for q, v, target in random_samples(arm, 200, seed=15, self_motion=sizes):
        p = Printed(arm, q, v, target)
        controller.reset(q, v, dt)
        after, slack = after_a_sample(p, controller.torque(q, v, target), dt)
        before = np.linalg.norm(p.theta_dot_H)
        assert p.theta_dot_H @ after >= -before * slack
        if switching == "brake" or arm.redundancy == 1:
            assert np.linalg.norm(after) <= before + slack
        braked += p.product < 0.0
    assert braked > 50


def test_dead_beat_may_start_another_self_motion_where_two_joints_are_to_spare():
    """What the brake is for: most of θ̈_H may point across a self-motion that is nearly at rest."""
    arm, growth = example_arm("panda", "xyz"), {each: [] for each in SOFT_SWITCHINGS}
    laws = {each: controllers.ModifiedNullSpaceVector(arm, switching=each) for each in SOFT_SWITCHINGS}
    for q, v, target in random_samples(arm, 100, seed=22, self_motion=1e-3):
        p = Printed(arm, q, v, target)
        for switching, law in laws.items():
            law.reset(q, v, DT)
            after, _ = after_a_sample(p, law.torque(q, v, target), DT)
            growth[switching].append(np.linalg.norm(after) / np.linalg.norm(p.theta_dot_H))
    assert max(growth["dead-beat"]) > 10.0
    assert max(growth["brake"]) < 1.0 + 1e-6


def test_hard_switching_does_reverse_it(arm_with_one_joint_to_spare):
    arm, reversed_ = arm_with_one_joint_to_spare, 0
    controller = controllers.ModifiedNullSpaceVector(arm)
    for q, v, target in random_samples(arm, 100, seed=16, self_motion=1e-4):
        p = Printed(arm, q, v, target)
        after, _ = after_a_sample(p, controller.torque(q, v, target), DT)
        reversed_ += p.theta_dot_H @ after < 0.0
    assert reversed_ > 10


@soft_switching
def test_soft_switching_applies_no_null_space_torque_at_rest(arm, switching):
    controller, plain = controllers.ModifiedNullSpaceVector(arm, switching=switching), controllers.Pseudoinverse(arm)
    rest = np.zeros(arm.nv)
    for q, _, target in random_samples(arm, 20, seed=17):
        controller.reset(q, rest, DT)
        np.testing.assert_array_equal(controller.torque(q, rest, target), plain.torque(q, rest, target))


@soft_switching
def test_soft_switching_needs_a_reset_and_hard_switching_none(arm, switching):
    refused = 0
    for q, v, target in random_samples(arm, 30, seed=18):
        assert np.isfinite(controllers.ModifiedNullSpaceVector(arm).torque(q, v, target)).all()
        if Printed(arm, q, v, target).product < 0.0:
            with pytest.raises(NotResetError, match=rf"{switching}.*call reset\(q, v, dt\)"):
                controllers.ModifiedNullSpaceVector(arm, switching=switching).torque(q, v, target)
            refused += 1
    assert refused > 5


def test_switching_is_hard_unless_told(planar):
    assert controllers.ModifiedNullSpaceVector(planar).switching == "hard"


@pytest.fixture(scope="module")
def trajectory_a():
    def run(law, **parameters):
        return paper.run_law(law, 1e-3, **parameters)

    modified = "modified-null-space-vector"
    soft = {each: run(modified, switching=each) for each in SOFT_SWITCHINGS}
    return {"plain": run("pseudoinverse"), "hard": run(modified), **soft}


@soft_switching
def test_soft_switching_does_not_chatter_on_trajectory_a(trajectory_a, switching):
    plain, hard, soft = (total_variation(trajectory_a[label].tau) for label in ("plain", "hard", switching))
    assert hard[0] > 50.0 * soft[0]
    assert np.all(soft <= plain)


@soft_switching
def test_soft_switching_keeps_what_is_good_about_the_modified_method_on_trajectory_a(trajectory_a, switching):
    plain, hard, soft = (trajectory_a[label] for label in ("plain", "hard", switching))
    assert [run.status for run in (plain, hard, soft)] == ["finished"] * 3
    np.testing.assert_allclose(peak_torque(soft)[0], peak_torque(hard)[0], rtol=0.01)
    squares = [(run.tau**2).sum() for run in (soft, hard, plain)]
    assert squares[0] < squares[1] < squares[2]
    assert aspect_preserved(soft)
    assert soft.tracking_error.max() < 1e-4


def variations(scenario, switchings):
    """Total variation of each joint's torque, N m, by switching."""
    law = '{{name = "modified-null-space-vector", label = "{0}", switching = "{0}"}}'
    runs = load_scenario(scenario, [f"controllers = [{', '.join(map(law.format, switchings))}]"]).build().run()
    assert {run.status for run in runs.values()} == {"finished"}
    return [total_variation(runs[each].tau) for each in switchings]


@pytest.mark.parametrize(
    ("scenario", "share"), [("panda-xyz", 0.8), ("panda-pose", 0.75), ("talos-arm-xyz", 0.5), ("baxter-xyz", 0.25)]
)
def test_dead_beat_is_calmer_than_hard_switching_on_some_real_arms(scenario, share):
    hard, dead_beat = variations(scenario, ["hard", "dead-beat"])
    assert dead_beat.sum() < share * hard.sum()
    assert np.all(dead_beat <= hard * (1.0 + 1e-3))


@pytest.mark.parametrize("scenario", ["panda-xyz", "ur5-xyz", "kinova-xyz", "xarm7-xyz"])
def test_the_brake_is_calmer_than_either_on_real_arms(scenario):
    hard, dead_beat, brake = variations(scenario, ["hard", *SOFT_SWITCHINGS])
    assert brake.sum() < 0.6 * hard.sum()
    assert brake.sum() < 0.6 * dead_beat.sum()


# Bad parameters


@damped_law
@pytest.mark.parametrize("damping", [-1e-9, -10.0, np.nan, np.inf, "much", None, True, [1.0]])
def test_bad_damping_is_an_error(planar, law, damping):
    with pytest.raises(ParameterError, match="damping must be a"):
        controllers.create(law, planar, damping=damping)


@pytest.mark.parametrize("kappa", [-0.001, np.nan, np.inf, "small", None])
@pytest.mark.parametrize("criterion", ["manipulability", "minor-measure"])
def test_bad_weight_of_the_criterion_is_an_error(planar, kappa, criterion):
    with pytest.raises(ParameterError, match="kappa must be a"):
        controllers.ResolvedMotion(planar, kappa=kappa, criterion=criterion)


@pytest.mark.parametrize("kappa", [0.0, 0.001])
@pytest.mark.parametrize("criterion", ["manipulabilty", "", None, 3])
def test_unknown_criterion_lists_those_that_exist(planar, kappa, criterion):
    with pytest.raises(UnknownNameError, match=r"unknown criterion .*available: .*'manipulability', 'minor-measure'"):
        controllers.ResolvedMotion(planar, kappa=kappa, criterion=criterion)


@pytest.mark.parametrize("switching", ["deadbeat", "soft", "", None, True])
def test_unknown_switching_lists_those_that_exist(planar, switching):
    with pytest.raises(
        UnknownNameError, match=r"unknown switching .*available: 'hard', 'dead-beat', 'brake'"
    ) as caught:
        controllers.ModifiedNullSpaceVector(planar, switching=switching)
    assert caught.value.available == ("hard", *SOFT_SWITCHINGS)


@pytest.mark.parametrize("law", ["damped-null-space", "inertia-weighted", "operational-space", "resolved-motion"])
def test_bad_gains_and_tasks_are_errors_of_the_new_laws_too(planar, law):
    for name in ("kp", "kv"):
        with pytest.raises(ParameterError, match=f"{name} must not be negative"):
            controllers.create(law, planar, **{name: -1.0})
        with pytest.raises(NonFiniteError, match=f"{name} must be finite"):
            controllers.create(law, planar, **{name: np.nan})
    with pytest.raises(NotRedundantError, match=f"{law} needs a redundant arm"):
        controllers.create(law, example_arm("ur5", "pose"))


def test_only_the_minor_measure_minds_how_many_minors_there_are(planar, monkeypatch):
    def too_many(arm):
        raise TooManyMinorsError("too many")

    monkeypatch.setattr(type(planar), "minor_columns", property(too_many))
    controllers.ResolvedMotion(planar, criterion="manipulability")
    controllers.ResolvedMotion(planar, criterion="minor-measure", kappa=0.0)
    with pytest.raises(TooManyMinorsError):
        controllers.ResolvedMotion(planar, criterion="minor-measure")


# Parameters and registry


@pytest.mark.parametrize(
    ("law", "own"),
    [
        ("damped-null-space", {"damping": 3.5}),
        ("inertia-weighted", {}),
        ("operational-space", {"damping": 3.5}),
        ("resolved-motion", {"kappa": 0.02, "criterion": "manipulability"}),
        ("resolved-motion", {"kappa": 0.02, "criterion": "minor-measure"}),
        ("resolved-motion", {"kappa": 0.0, "criterion": "minor-measure"}),
        ("modified-null-space-vector", {"switching": "hard"}),
        ("modified-null-space-vector", {"switching": "dead-beat"}),
        ("modified-null-space-vector", {"switching": "brake"}),
    ],
)
def test_parameters_construct_the_law_again(arm, law, own):
    Kp, Kv = gains(arm.nv if law == "resolved-motion" else arm.task_dim)
    controller = controllers.create(law, arm, kp=Kp, kv=np.diag(Kv), **own)
    assert {name: controller.parameters[name] for name in own} == own
    assert set(controller.parameters) == set(controllers.parameter_names(type(controller)))
    again = controllers.create(law, arm, **json.loads(json.dumps(controller.parameters)))
    assert again.parameters == controller.parameters
    samples = list(random_samples(arm, 10, seed=19))
    for each in (controller, again):
        each.reset(samples[0][0], samples[0][1], DT)
    for q, v, target in samples:
        np.testing.assert_array_equal(again.torque(q, v, target), controller.torque(q, v, target))


def test_registry_holds_every_law():
    assert set(LAWS) <= set(controllers.available())


@pytest.mark.parametrize("law", LAWS)
def test_registry_finds_each_law_by_its_name(planar, law):
    assert controllers.find(law) is LAWS[law]
    assert LAWS[law].name == law
    assert type(controllers.create(law, planar)) is LAWS[law]


@pytest.mark.parametrize("law", ["damped-null-space", "inertia-weighted", "operational-space", "resolved-motion"])
def test_a_recorded_run_of_a_new_law_comes_back(planar, law, tmp_path):
    run = simulate(controllers.create(law, planar), StraightLine([0.2, 0.1], 0.1), q0=paper.Q0, dt=1e-2)
    run.save(tmp_path / "run.npz")
    again = type(run).load(tmp_path / "run.npz")
    assert again == run
    assert controllers.create(again.info.controller, again.arm, **again.info.parameters).name == law
