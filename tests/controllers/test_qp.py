"""Least torque as a quadratic program: its equations, independent solvers, its limits, and what can go wrong."""

import copy
import dataclasses
import multiprocessing
import os
import pickle
import subprocess
import sys
from collections import Counter

import daqp
import numpy as np
import osqp
import pytest
import qpsolvers
from scipy.optimize import linprog

from aspect_control import Arm, StraightLine, Target, controllers, simulate
from aspect_control.analysis import aspect_preserved, total_variation
from aspect_control.controllers import QPStatus, QPTorque
from aspect_control.exceptions import (
    AspectControlError,
    NonFiniteError,
    NotResetError,
    ParameterError,
    ShapeError,
    UnknownNameError,
)
from aspect_control.scenario import load_scenario
from aspect_control.studies.paper.trajectory_a import Q0, TRAJECTORY
from example_arms import example_arm, random_motions

DT = 1e-3
ARMS = ("planar", "panda", "xarm7")
SOLVERS = ("osqp", "daqp", "quadprog")
LIMITS = {
    "torque": {"torque_limit": 30.0},
    "torque and acceleration": {"torque_limit": 60.0, "acceleration_limit": 30.0},
    "all": {
        "torque_limit": 40.0,
        "speed_limit": 3.0,
        "position_limit": (-2.8, 2.8),
        "acceleration_limit": 200.0,
        "stability": "maciejewski",
    },
}
SCENARIOS = (
    "baxter-xyz",
    "kinova-xyz",
    "panda-pose",
    "panda-xyz",
    "planar3r",
    "talos-arm-xyz",
    "ur5-xyz",
    "xarm7-xyz",
)
REST = Target(np.zeros(2), np.zeros(2), np.zeros(2))
INSIDE = np.array([0.3, 0.4, 0.5])
NOT_CALLED = "no solver called"


@pytest.fixture
def robot(request, planar):
    return planar if request.param == "planar" else example_arm(request.param)


every_arm = pytest.mark.parametrize("robot", ARMS, indirect=True)
planar_and_panda = pytest.mark.parametrize("robot", ["planar", "panda"], indirect=True)
every_limit = pytest.mark.parametrize("limits", LIMITS.values(), ids=LIMITS)
every_solver = pytest.mark.parametrize("solver", SOLVERS)
both_dampings = pytest.mark.parametrize("damping", [0.0, None], ids=["undamped", "damped"])


def create(arm, damping=None, **parameters):
    """The law with some damping; None for the default."""
    return QPTorque(arm, **parameters, **({} if damping is None else {"damping": damping}))


def samples(arm, count, seed):
    rng = np.random.default_rng(seed)
    for q, v in random_motions(arm, count, seed):
        x = arm.task_position(q) + rng.normal(0.0, 0.1, arm.task_dim)
        yield q, v, Target(x, *rng.normal(0.0, 2.0, (2, arm.task_dim)))


def along_a_motion(arm, count):
    """States and targets near each other, faster and faster, so that the active limits change now and then."""
    q, v, target = next(samples(arm, 1, seed=16))
    for i in range(count):
        swing = np.sin(0.013 * i) * (1.0 + 0.1 * np.cos(0.0007 * i))
        yield q + 0.3 * swing, v * np.cos(0.013 * i), Target(target.x, target.dx, target.ddx * swing)


SELF_MOTION_COST = 15.0
"""ρ of the default, in units of the mean inertia of a joint."""


class Literal:
    """The program in φ, by NumPy's pseudoinverse: τ = M(s J⁺b + P φ) + N with P = I − J⁺J, θ̈_H = P φ, G φ + s g ≤ h.

    Minimise ½‖τ‖² + ½ρ(θ̈_H + Dθ̇_H)ᵀM(θ̈_H + Dθ̇_H).
    """

    def __init__(self, controller, q, v, target, dt=None):
        arm, limits, T, D = controller.arm, controller.limits, controller.horizon, controller.damping
        state = arm.state(q, v)
        J_pinv = np.linalg.pinv(state.J)
        self.P = np.eye(arm.nv) - J_pinv @ state.J
        self.particular = J_pinv @ controller.commanded_acceleration(state, target)
        self.M, self.nle = state.M, state.nle
        self.rho = SELF_MOTION_COST * np.trace(state.M) / arm.nv if D > 0.0 else 0.0
        self.damping = D * self.P @ v
        MP, c = state.M @ self.P, state.M @ self.particular
        G, g, h = [MP, -MP], [c, -c], [limits.torque - state.nle, limits.torque + state.nle]
        if limits.bound_acceleration:
            slowest, fastest = limits.acceleration_interval(arm.positions(q), v, T, dt or T)
            G += [self.P, -self.P]
            g += [self.particular, -self.particular]
            h += [fastest, -slowest]
        if controller.stability != "none":
            G += [(self.P @ v)[None] @ self.P]
            g += [np.zeros(1)]
            h += [np.zeros(1)]
        finite = np.isfinite(np.concatenate(h))
        self.G, self.g, self.h = np.vstack(G)[finite], np.concatenate(g)[finite], np.concatenate(h)[finite]

    def largest_scale(self):
        """s by a linear program in the n + 1 unknowns φ and s; −1 if not even s = 0 is possible."""
        n = self.P.shape[1]
        size = np.maximum(np.linalg.norm(self.G, axis=1), 1e-3)
        A, h = np.column_stack((self.G, self.g)) / size[:, None], self.h / size
        bounds = [(None, None)] * n + [(0.0, 1.0)]
        result = linprog(np.append(np.zeros(n), -1.0), A_ub=A, b_ub=h, bounds=bounds, method="highs")
        return result.x[-1] if result.status == 0 else -1.0

    def torque(self, s, phi):
        return self.M @ (s * self.particular + self.P @ phi) + self.nle

    def quadratic(self, s):
        """The cost as ½ φᵀHφ + fᵀφ."""
        MP = self.M @ self.P
        fixed, pull = s * self.M @ self.particular + self.nle, self.rho * MP.T @ self.damping
        return MP.T @ MP + self.rho * self.P.T @ MP, MP.T @ fixed + pull

    def free_torque(self, s):
        """The torque of least cost without limits."""
        H, f = self.quadratic(s)
        return self.torque(s, -np.linalg.pinv(H, rcond=1e-12, hermitian=True) @ f)

    def best_torque(self, s):
        """The torque of least cost by quadprog on φ, regularised by 1e-10."""
        H, f = self.quadratic(s)
        phi = qpsolvers.solve_qp(H + 1e-10 * np.eye(len(H)), f, self.G, self.h - s * self.g, solver="quadprog")
        return None if phi is None else self.torque(s, phi)

    def cost(self, s, tau):
        deviation = np.linalg.solve(self.M, tau - self.nle) - s * self.particular + self.damping
        return 0.5 * tau @ tau + 0.5 * self.rho * deviation @ self.M @ deviation


# The law without an active limit


@every_arm
@every_solver
@pytest.mark.parametrize("limits", [{}, {"torque_limit": 1e7}, {"torque_limit": np.inf}], ids=["none", "wide", "inf"])
def test_undamped_without_active_limit_it_is_equation_11(robot, solver, limits):
    controller, reference = QPTorque(robot, solver=solver, damping=0.0, **limits), controllers.NullSpaceVector(robot)
    for q, v, target in samples(robot, 1000, seed=1):
        expected = reference.torque(q, v, target)
        rounding = 1e-9 * (1.0 + np.abs(expected).max()) * np.linalg.cond(robot.jacobian(q))
        np.testing.assert_allclose(controller.torque(q, v, target), expected, rtol=0, atol=rounding)
        assert controller.status == QPStatus("optimal", 1.0, controller.status.message, 0)
        assert NOT_CALLED in controller.status.message


@every_arm
@pytest.mark.parametrize("damping", [1e-3, 10.0, 30.0])
def test_damped_without_active_limit_it_is_the_minimum_of_both_costs(robot, damping):
    controller = QPTorque(robot, damping=damping)
    least, none = controllers.NullSpaceVector(robot), controllers.DampedNullSpace(robot, damping=damping)
    for q, v, target in samples(robot, 300, seed=1):
        tau, literal = controller.torque(q, v, target), Literal(controller, q, v, target)
        expected, cost = literal.free_torque(1.0), literal.cost(1.0, tau)
        rounding = 1e-9 * (1.0 + np.abs(expected).max()) * np.linalg.cond(robot.jacobian(q))
        np.testing.assert_allclose(tau, expected, rtol=0, atol=rounding)
        assert all(cost <= literal.cost(1.0, law.torque(q, v, target)) * (1.0 + 1e-12) for law in (least, none))


@both_dampings
def test_problem_is_the_program_that_is_solved(damping):
    arm = example_arm("panda")
    controller = create(arm, damping, torque_limit="urdf", acceleration_limit=5e3)
    scaled = 0
    for q, v, target in samples(arm, 60, seed=2):
        tau, state = controller.torque(q, v, target), arm.state(q, v)
        problem, r = controller.problem(state, target), arm.redundancy
        assert problem.P.shape == (r + 1, r + 1)
        assert problem.G.shape == (2 * (2 * arm.nv + 1), r + 1)
        x = qpsolvers.solve_problem(problem, "quadprog").x
        if controller.status.outcome == "braking":
            assert x is None
            continue
        # The last two rows are σ ≤ σ₁ and −σ ≤ 0.
        s = x[-1] / problem.h[len(problem.h) // 2 - 1]
        assert s == pytest.approx(controller.status.task_scale, abs=1e-6)
        literal = Literal(controller, q, v, target)
        more = literal.cost(s, tau) - literal.cost(s, literal.free_torque(s))
        assert 0.5 * x[:-1] @ x[:-1] == pytest.approx(more, rel=1e-3, abs=1e-5 * literal.cost(s, tau))
        scaled += controller.status.outcome == "scaled"
    assert scaled > 5


# Limits


@planar_and_panda
@every_limit
@both_dampings
@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_tight_limits_hold_and_the_task_scale_is_the_largest(robot, limits, solver, damping):
    controller = create(robot, damping, solver=solver, **limits)
    outcomes = Counter()
    for q, v, target in samples(robot, 180, seed=3):
        tau = controller.torque(q, v, target)
        status, literal = controller.status, Literal(controller, q, v, target)
        outcomes[status.outcome] += 1
        assert np.abs(tau).max() <= limits["torque_limit"] + 1e-6
        s = literal.largest_scale()
        if status.outcome == "braking":
            assert s <= 1e-6
            continue
        assert status.task_scale == pytest.approx(s, abs=1e-5)
        acceleration = np.linalg.solve(literal.M, tau - literal.nle)
        phi = acceleration - status.task_scale * literal.particular
        np.testing.assert_allclose(literal.P @ phi, phi, atol=1e-4 * (1.0 + np.abs(acceleration).max()))
        room = literal.h - status.task_scale * literal.g - literal.G @ phi
        assert np.all(room >= -1e-4 * (1.0 + np.abs(literal.h)))
    assert outcomes["scaled"] > 20


@planar_and_panda
@every_solver
@both_dampings
def test_with_active_limits_it_is_the_literal_program(robot, solver, damping):
    controller = create(robot, damping, solver=solver, torque_limit=200.0, acceleration_limit=100.0)
    compared = active = 0
    for q, v, target in samples(robot, 150, seed=4):
        tau = controller.torque(q, v, target)
        if controller.status.outcome != "optimal":
            continue
        literal = Literal(controller, q, v, target)
        expected = literal.best_torque(1.0)
        if expected is None:
            continue
        np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-3)
        compared += 1
        active += np.abs(tau - literal.free_torque(1.0)).max() > 0.1
    assert compared > 10
    assert active > 3


@every_limit
def test_every_solver_gives_the_same_torque(planar, limits):
    laws = [QPTorque(planar, solver=solver, **limits) for solver in SOLVERS]
    for q, v, target in samples(planar, 100, seed=5):
        torques = [law.torque(q, v, target) for law in laws]
        assert len({law.status.outcome for law in laws}) == 1
        for law, tau in zip(laws, torques, strict=True):
            assert law.status.task_scale == pytest.approx(laws[1].status.task_scale, abs=1e-9)
            np.testing.assert_allclose(tau, torques[1], rtol=0, atol=1e-6)


def test_daqp_falls_in_where_osqp_is_not_exact_and_status_says_so():
    arm = example_arm("panda")
    law, said = QPTorque(arm, torque_limit=60.0, acceleration_limit=30.0), Counter()
    for q, v, target in samples(arm, 100, seed=5):
        law.torque(q, v, target)
        assert law.status.message.startswith("osqp: ")
        said["daqp: solved" in law.status.message] += 1
        assert law.status.iterations > 0
    assert min(said.values()) > 5


def braking_samples(arm, law, count, seed):
    """Samples at which no torque within the limits gives even the part 0 of the task."""
    for each in samples(arm, count, seed):
        tau = law.torque(*each)
        if law.status.outcome == "braking":
            assert law.status.task_scale == 0.0
            assert "no torque within the limits: " in law.status.message
            yield *each, tau


def out_of_order(*_, **__):
    raise RuntimeError("out of order")


def test_braking_is_the_stated_torque_when_it_fits(planar, monkeypatch):
    monkeypatch.setattr(daqp, "solve", out_of_order)
    controller, braked = QPTorque(planar, torque_limit=60.0, horizon=0.2, solver="daqp"), 0
    for q, v, _, tau in braking_samples(planar, controller, 100, seed=15):
        state = planar.state(q, v)
        expected = state.M @ (-v / 0.2) + state.nle
        if np.abs(expected).max() <= 60.0:
            np.testing.assert_allclose(tau, expected, rtol=1e-12)
            braked += 1
    assert braked > 10


def test_braking_takes_energy_out_of_the_arm(monkeypatch):
    monkeypatch.setattr(daqp, "solve", out_of_order)
    arm = example_arm("panda")
    law, limited = QPTorque(arm, torque_limit=80.0, solver="daqp"), 0
    for q, v, _, tau in braking_samples(arm, law, 200, seed=6):
        gravity = arm.state(q, np.zeros(arm.nv)).nle
        assert np.abs(tau).max() <= 80.0
        if np.isclose(np.abs(tau).max(), 80.0) and np.abs(gravity).max() < 80.0:
            limited += 1
            assert v @ (tau - gravity) < 0.0
    assert limited > 2


def test_braking_takes_energy_out_of_a_moving_arm(planar, monkeypatch):
    monkeypatch.setattr(daqp, "solve", out_of_order)
    controller, outcomes = QPTorque(planar, torque_limit=5.0, solver="daqp"), []
    line, v0 = StraightLine([1.5, 1.0], duration=2.0), [1.0, -2.0, 2.0]
    note = lambda _: outcomes.append(controller.status.outcome)  # noqa: E731
    run = simulate(controller, line, q0=INSIDE, v0=v0, dt=DT, events=(), watch=note)
    energy = np.array([v @ planar.state(q, v).M @ v for q, v in zip(run.q, run.v, strict=True)])
    braked = np.array(outcomes[:-1]) == "braking"
    assert np.count_nonzero(braked) > 1000
    assert np.all(np.diff(energy)[braked] <= 1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_joint_beyond_its_position_limit_comes_back(planar, side):
    controller = QPTorque(planar, position_limit=(-1.0, 1.0), torque_limit=50.0)
    q0 = side * np.array([1.2, 0.5, 0.3])
    run = simulate(controller, StraightLine(np.zeros(2), duration=2.0), q0=q0, dt=DT, events=())
    assert np.abs(run.tau).max() <= 50.0
    assert np.all(np.abs(run.q[-1]) <= 1.0 + 2e-2)


def test_joint_beyond_its_speed_limit_slows_down(planar):
    controller = QPTorque(planar, speed_limit=1.0, torque_limit=50.0)
    line = StraightLine(np.zeros(2), duration=1.0)
    run = simulate(controller, line, q0=INSIDE, v0=[0.0, 2.5, -2.0], dt=DT, events=())
    assert np.abs(run.tau).max() <= 50.0
    assert np.abs(run.v[-1]).max() <= 1.0 + 1e-2


def test_intervals_of_acceleration_are_never_empty(planar):
    controller = QPTorque(planar, speed_limit=1.0, position_limit=(-1.0, 1.0), acceleration_limit=10.0)
    rng = np.random.default_rng(7)
    for position, v in rng.normal(0.0, 5.0, (200, 2, 3)):
        lower, upper = controller.limits.acceleration_interval(position, v, 0.1, DT)
        assert np.all(lower >= -10.0)
        assert np.all(lower <= upper)
        assert np.all(upper <= 10.0)


# Stability


@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_half_space_is_the_modified_method_for_one_redundant_degree_of_freedom(planar, solver):
    law = QPTorque(planar, solver=solver, stability="maciejewski", damping=0.0)
    modified = controllers.ModifiedNullSpaceVector(planar)
    for q, v, target in samples(planar, 300, seed=8):
        expected = modified.torque(q, v, target)
        accuracy = 1e-8 * np.abs(expected).max() + 1e-6
        np.testing.assert_allclose(law.torque(q, v, target), expected, rtol=0, atol=accuracy)
    rest = np.zeros(3)
    expected = modified.torque(INSIDE, rest, REST)
    np.testing.assert_allclose(law.torque(INSIDE, rest, REST), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("robot", ["panda", "xarm7"], indirect=True)
def test_half_space_keeps_the_saving_that_does_not_feed_the_self_motion(robot):
    law = QPTorque(robot, stability="maciejewski", damping=0.0)
    modified, saved = controllers.ModifiedNullSpaceVector(robot), 0
    for q, v, target in samples(robot, 200, seed=9):
        tau, switched = law.torque(q, v, target), modified.torque(q, v, target)
        assert tau @ tau <= (switched @ switched) * (1.0 + 1e-9) + 1e-6
        saved += tau @ tau < 0.999 * (switched @ switched)
    assert saved > 20


@every_arm
@both_dampings
def test_dead_beat_brakes_no_further_than_to_rest(robot, damping):
    law = create(robot, damping, stability="dead-beat")
    law.reset(np.array(random_motions(robot, 1, 0)[0][0]), np.zeros(robot.nv), DT)
    for q, v, target in samples(robot, 200, seed=10):
        state, tau = robot.state(q, v), law.torque(q, v, target)
        P = np.eye(robot.nv) - np.linalg.pinv(state.J) @ state.J
        # θ̈_H = P θ̈: J⁺b is orthogonal to the null space.
        product = v @ P @ np.linalg.solve(state.M, tau - state.nle)
        self_motion = v @ P @ v
        rounding = 1e-6 * (1.0 + self_motion / DT)
        assert -self_motion / DT - rounding <= product <= rounding


def test_dead_beat_without_reset_is_an_error(planar):
    law = QPTorque(planar, stability="dead-beat")
    for call in (law.torque, lambda q, v, target: law.problem(planar.state(q, v), target)):
        with pytest.raises(NotResetError, match=r"qp with .*dead-beat.* needs Δt: call reset\(q, v, dt\)"):
            call(INSIDE, np.zeros(3), REST)


# In closed loop


@pytest.mark.parametrize("name", SCENARIOS)
def test_default_finishes_every_scenario_calmly_within_the_limits_of_the_robot_file(name):
    setup = load_scenario(name).build()
    arm = setup.arm
    law = QPTorque(arm, torque_limit="urdf")
    run = simulate(law, setup.trajectory, q0=setup.q0, dt=2e-3)
    assert run.status == "finished", run.message
    assert np.all(np.abs(run.tau) <= arm.torque_limit + 1e-6)
    assert np.abs(run.v).max() < 10.0
    assert run.tracking_error.max() < 5e-3


def test_pr2_cannot_hold_its_shoulder_within_the_limits_of_its_file():
    # The file has no counterbalance: gravity asks for 44 N m of a joint that has 30 N m.
    setup = load_scenario("pr2-xyz").build()
    arm = setup.arm
    gravity = arm.state(setup.q0, np.zeros(arm.nv)).nle
    assert np.any(np.abs(gravity) > 1.4 * arm.torque_limit)
    run = simulate(QPTorque(arm), setup.trajectory, q0=setup.q0, dt=2e-3)
    assert run.status == "finished"
    assert np.abs(run.v).max() < 10.0


def test_undamped_builds_up_the_self_motion_that_the_default_does_not():
    setup = load_scenario("panda-xyz").build()
    arm = setup.arm
    law = QPTorque(arm, torque_limit="urdf", damping=0.0)
    run = simulate(law, setup.trajectory, q0=setup.q0, dt=DT, events=())
    assert np.abs(run.v).max() > 50.0


@pytest.mark.parametrize("stability", ["none", "maciejewski", "dead-beat"])
def test_trajectory_a_within_a_torque_limit(planar, stability):
    run = simulate(QPTorque(planar, torque_limit=30.0, stability=stability), TRAJECTORY, q0=Q0, dt=DT)
    assert np.abs(run.tau).max() <= 30.0 + 1e-6
    assert run.status == "finished"


def test_trajectory_a_undamped_within_a_limit_is_bounded_but_loses_the_task(planar):
    # From t = 0.77 s on the self-motion that the method has built up costs more than 30 N m.
    run = simulate(QPTorque(planar, torque_limit=30.0, damping=0.0), TRAJECTORY, q0=Q0, dt=DT, events=())
    assert run.status == "finished"
    assert np.abs(run.tau).max() <= 30.0 + 1e-6
    assert run.tracking_error.max() > 0.1


@pytest.mark.parametrize(("stability", "variation"), [("maciejewski", 1e4), ("dead-beat", 60.0)])
def test_trajectory_a_undamped_with_stability_stays_in_its_aspect(planar, stability, variation):
    run = simulate(QPTorque(planar, stability=stability, damping=0.0), TRAJECTORY, q0=Q0, dt=DT)
    assert run.status == "finished"
    assert aspect_preserved(run)
    assert np.abs(run.tau).max() < 20.0
    assert total_variation(run.tau)[0] < variation


@pytest.mark.parametrize("stability", ["none", "dead-beat"])
@both_dampings
def test_panda_within_the_limits_of_its_urdf(stability, damping):
    arm = example_arm("panda")
    limits = {f"{name}_limit": "urdf" for name in ("torque", "speed", "position")}
    law = create(arm, damping, stability=stability, **limits)
    q0 = np.array([0.1, -0.5, 0.2, -2.0, 0.1, 1.6, 0.5])
    run = simulate(law, StraightLine([0.1, 0.1, -0.1], duration=0.3), q0=q0, dt=DT)
    assert run.status == "finished"
    assert np.all(np.abs(run.tau) <= arm.torque_limit + 1e-6)
    # The bound holds for M and N of the sample; within it they change.
    assert np.all(np.abs(run.v) <= arm.velocity_limit + 0.05)
    lower, upper = arm.position_limits
    assert np.all((run.q >= lower - 1e-3) & (run.q <= upper + 1e-3))


# What is kept between calls


@pytest.fixture
def osqp_calls(monkeypatch):
    """Calls of OSQP's workspaces, counted by name."""
    counts = Counter()
    for name in ("setup", "update", "solve"):
        original = getattr(osqp.OSQP, name)

        def counted(self, *args, name=name, original=original, **kwargs):
            counts[name] += 1
            return original(self, *args, **kwargs)

        monkeypatch.setattr(osqp.OSQP, name, counted)
    return counts


@every_limit
def test_osqp_is_set_up_once(planar, limits, osqp_calls):
    law, outcomes = QPTorque(planar, **limits), set()
    law.reset(INSIDE, np.zeros(3), DT)
    for each in samples(planar, 150, seed=11):
        law.torque(*each)
        outcomes.add(law.status.outcome)
    assert outcomes == {"optimal", "scaled", "braking"}
    assert osqp_calls["setup"] == 1
    assert osqp_calls["solve"] > 50
    assert osqp_calls["update"] == osqp_calls["solve"]


def test_no_solver_is_called_while_the_active_limits_stay_the_same(osqp_calls):
    arm = example_arm("panda")
    law, said = QPTorque(arm, torque_limit=30.0), Counter()
    for each in along_a_motion(arm, 500):
        law.torque(*each)
        said[NOT_CALLED in law.status.message] += 1
        assert (NOT_CALLED in law.status.message) == (law.status.iterations == 0)
    assert osqp_calls["solve"] == said[False] < 0.2 * said[True]


@every_limit
@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_torque_does_not_depend_on_the_active_limits_of_the_sample_before(solver, limits):
    arm = example_arm("panda")
    kept, forgetful = QPTorque(arm, solver=solver, **limits), QPTorque(arm, solver=solver, **limits)
    kept.reset(arm.configuration(np.zeros(7)), np.zeros(7), DT)
    for state in along_a_motion(arm, 60):
        forgetful.reset(state[0], state[1], DT)
        tau = kept.torque(*state)
        np.testing.assert_allclose(tau, forgetful.torque(*state), rtol=0, atol=1e-6 * (1.0 + np.abs(tau).max()))
        assert kept.status.outcome == forgetful.status.outcome
        assert kept.status.task_scale == pytest.approx(forgetful.status.task_scale, abs=1e-9)


BAD_CALLS = (
    lambda q, v, target: (np.full_like(q, np.nan), v, target),
    lambda q, v, target: (q, v[:-1], target),
    lambda q, v, target: (q, v, Target([0.0], [0.0], [0.0])),
    lambda q, v, target: (q, v * 1e60, target),
    lambda q, v, target: (q, v, None),
)


@every_limit
@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_refused_calls_and_copies_leave_no_trace(limits, solver):
    arm, rng = example_arm("panda"), np.random.default_rng(0)
    law = QPTorque(arm, solver=solver, **limits)
    law.reset(arm.configuration(np.zeros(7)), np.zeros(7), DT)
    twin, searched, refused = copy.deepcopy(law), 0, 0
    for i, state in enumerate(along_a_motion(arm, 2000)):
        try:
            twin.torque(*BAD_CALLS[rng.integers(len(BAD_CALLS))](*state))
        except AspectControlError:
            refused += 1
        if i % 100 == 50:
            twin = pickle.loads(pickle.dumps(twin)) if i % 200 == 50 else copy.deepcopy(twin)
        np.testing.assert_array_equal(twin.torque(*state), law.torque(*state))
        assert twin.status == law.status
        searched += NOT_CALLED not in law.status.message
    assert searched > 20
    assert refused > 1000


def torques_of(law, states):
    return np.array([law.torque(*state) for state in states])


def test_spawned_process_gives_the_same_torque_before_and_after_a_motion_has_begun():
    arm = example_arm("panda")
    law, states = QPTorque(arm, torque_limit=30.0), list(along_a_motion(arm, 300))
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        for part in (states[:100], states[100:]):
            there = pool.apply(torques_of, (law, part))
            np.testing.assert_array_equal(there, torques_of(law, part))


def test_memory_is_replaced_and_never_changed(planar):
    law = QPTorque(planar, torque_limit=30.0)
    remembered = []
    for each in samples(planar, 50, seed=12):
        law.torque(*each)
        remembered.append((law.memory, pickle.dumps(law.memory)))
    assert all(pickle.dumps(memory) == before for memory, before in remembered)


def test_reset_makes_a_run_repeatable(planar):
    law = QPTorque(planar, torque_limit=30.0, damping=0.0)
    runs = [simulate(law, TRAJECTORY, q0=Q0, dt=2e-2, events=()) for _ in range(2)]
    np.testing.assert_array_equal(runs[0].tau, runs[1].tau)


@every_limit
@every_solver
def test_nothing_is_printed(planar, limits, solver, capfd):
    law, outcomes = QPTorque(planar, solver=solver, **limits), set()
    for each in samples(planar, 150, seed=12):
        law.torque(*each)
        outcomes.add(law.status.outcome)
    assert outcomes == {"optimal", "scaled", "braking"}
    assert capfd.readouterr() == ("", "")


def test_import_loads_no_solver():
    code = (
        "import sys, aspect_control, aspect_control.controllers.qp\n"
        "sys.exit(bool({'daqp', 'osqp', 'qpsolvers', 'scipy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, env={**os.environ}).returncode == 0


# A solver that fails


def answer(x, flag=1, scale=1.0):
    return lambda H, f, A, *_, **__: (x, 0.0, flag, {"lam": scale * np.ones(len(A)), "iterations": 1})


FAILURES = {
    "raises": out_of_order,
    "no solution": answer(None, flag=-1),
    "garbage": answer(None),
    "NaN": answer(None, scale=np.nan),
    "wrong shape": lambda *_, **__: (None, 0.0, 1, {"lam": np.ones(40), "iterations": 1}),
    "garbage object": lambda *_, **__: None,
    "nothing active": answer(None, scale=0.0),
}


@pytest.mark.parametrize("failure", FAILURES.values(), ids=FAILURES)
@every_arm
def test_failing_solver_ends_in_bounded_braking(robot, failure, monkeypatch):
    monkeypatch.setattr(daqp, "solve", failure)
    law = QPTorque(robot, torque_limit=30.0, solver="daqp")
    for each in samples(robot, 10, seed=13):
        tau = law.torque(*each)
        assert np.abs(tau).max() <= 30.0
        assert law.status.outcome == "braking" or NOT_CALLED in law.status.message
    assert law.status.outcome == "braking"


def test_old_solution_is_not_taken_for_a_new_one(planar, monkeypatch):
    law, first, solve = QPTorque(planar, torque_limit=40.0, solver="daqp"), [], daqp.solve

    def stale(*args, **kwargs):
        first.append(solve(*args, **kwargs))
        return first[0]

    exact = QPTorque(planar, torque_limit=40.0, solver="quadprog")
    monkeypatch.setattr(daqp, "solve", stale)
    for q, v, target in samples(planar, 60, seed=14):
        tau = law.torque(q, v, target)
        assert np.abs(tau).max() <= 40.0
        if law.status.outcome != "braking":
            np.testing.assert_allclose(tau, exact.torque(q, v, target), atol=1e-6)
    assert len(first) > 10


@pytest.mark.parametrize("name", ["solve", "setup"])
def test_osqp_that_fails_makes_room_for_daqp(planar, name, monkeypatch):
    monkeypatch.setattr(osqp.OSQP, name, out_of_order)
    law, exact = QPTorque(planar, torque_limit=40.0), QPTorque(planar, torque_limit=40.0, solver="daqp")
    for each in samples(planar, 30, seed=14):
        np.testing.assert_array_equal(law.torque(*each), exact.torque(*each))
        assert law.status.outcome == exact.status.outcome


@pytest.mark.parametrize("q", [np.zeros(3), [0.0, np.pi, 0.0], [0.0, 0.0, np.pi]])
@pytest.mark.parametrize("stability", ["none", "maciejewski", "dead-beat"])
@both_dampings
def test_rank_deficient_jacobian(planar, q, stability, damping):
    law = create(planar, damping, torque_limit=30.0, stability=stability)
    law.reset(q, np.zeros(3), DT)
    for v in (np.zeros(3), np.array([1.0, -2.0, 3.0])):
        tau = law.torque(q, v, Target([1.0, 1.0], [1.0, -1.0], [1.0, 1.0]))
        assert np.isfinite(tau).all()
        assert np.abs(tau).max() <= 30.0 + 1e-6


@every_limit
@pytest.mark.parametrize("speed", [1e5, 1e10, 1e20, 1e24, 1e100, 1e150])
def test_torque_is_bounded_or_an_error_at_absurd_speeds(planar, speed, limits):
    law = QPTorque(planar, **limits)
    try:
        tau = law.torque(INSIDE, speed * np.array([1.0, -1.0, 1.0]), REST)
    except NonFiniteError:
        return
    assert np.abs(tau).max() <= limits["torque_limit"]


# Parameters and bad input


def test_parameters_construct_the_law_again():
    arm = example_arm("panda")
    law = QPTorque(
        arm,
        kp=[1.0, 2.0, 3.0],
        solver="osqp",
        torque_limit="urdf",
        speed_limit=2.0,
        position_limit=(-3.0, np.full(7, 3.0)),
        acceleration_limit=list(range(1, 8)),
        damping=7.0,
        horizon=0.2,
        stability="maciejewski",
    )
    again = QPTorque(arm, **law.parameters)
    assert again.parameters == law.parameters
    assert law.parameters["position_limit"] == [-3.0, [3.0] * 7]
    assert law.parameters["damping"] == 7.0


def test_status_cannot_be_changed(planar):
    law = QPTorque(planar)
    assert law.status is None
    law.torque(INSIDE, np.zeros(3), REST)
    with pytest.raises(dataclasses.FrozenInstanceError):
        law.status.outcome = "braking"
    with pytest.raises(AttributeError):
        law.status = None


@pytest.mark.parametrize("solver", ["osqq", "", None, 3])
def test_unknown_solver_lists_those_installed(planar, solver):
    with pytest.raises(UnknownNameError, match=r"unknown QP solver.*available: .*'osqp'"):
        QPTorque(planar, solver=solver)


@pytest.mark.parametrize("stability", ["deadbeat", None, True])
def test_unknown_stability_lists_those_that_exist(planar, stability):
    with pytest.raises(UnknownNameError, match=r"unknown stability.*'none', 'maciejewski', 'dead-beat'"):
        QPTorque(planar, stability=stability)


@pytest.mark.parametrize("name", ["torque_limit", "speed_limit", "acceleration_limit"])
@pytest.mark.parametrize(
    ("value", "error"),
    [
        (0.0, ParameterError),
        (-1.0, ParameterError),
        ([1.0, -1.0, 1.0], ParameterError),
        (np.nan, ParameterError),
        (-np.inf, ParameterError),
        ([1.0, 2.0], ShapeError),
        (np.ones((3, 3)), ShapeError),
        ("high", ParameterError),
        (True, ShapeError),
        ({}, ShapeError),
        (1j, ShapeError),
    ],
)
def test_bad_limit_is_an_error(planar, name, value, error):
    with pytest.raises(error, match=name):
        QPTorque(planar, **{name: value})


@pytest.mark.parametrize("name", ["torque_limit", "speed_limit", "acceleration_limit"])
@pytest.mark.parametrize("value", [None, np.inf, [np.inf] * 3])
def test_infinity_is_no_limit(planar, name, value):
    law, free = QPTorque(planar, **{name: value}), QPTorque(planar)
    for each in samples(planar, 20, seed=1):
        np.testing.assert_array_equal(law.torque(*each), free.torque(*each))


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        ((1.0, -1.0), ParameterError, r"below the upper, got \[1, -1\] rad for joint"),
        ((1.0, 1.0), ParameterError, "below the upper"),
        (([0.0, 0.0, 2.0], 1.0), ParameterError, r"got \[2, 1\]"),
        ((np.nan, 1.0), ParameterError, "below the upper"),
        (([0.0, 0.0], 1.0), ShapeError, r"position_limit\[0\] must be a number or a vector of 3 numbers"),
        (2.0, ShapeError, "pair"),
        ((1.0, 2.0, 3.0), ShapeError, "pair"),
        ("wide", ParameterError, "pair"),
    ],
)
def test_bad_position_limit_is_an_error(planar, value, error, message):
    with pytest.raises(error, match=message):
        QPTorque(planar, position_limit=value)


@pytest.mark.parametrize("horizon", [0.0, -0.1, np.nan, np.inf, None])
def test_bad_horizon_is_an_error(planar, horizon):
    with pytest.raises(ParameterError, match="horizon must be a"):
        QPTorque(planar, horizon=horizon)


@pytest.mark.parametrize("damping", [-0.1, np.nan, np.inf, None, "none"])
def test_bad_damping_is_an_error(planar, damping):
    with pytest.raises(ParameterError, match="damping must be a"):
        QPTorque(planar, damping=damping)


@pytest.mark.parametrize("gain", ["kp", "kv"])
def test_negative_gain_is_an_error(planar, gain):
    with pytest.raises(ParameterError, match="must not be negative"):
        QPTorque(planar, **{gain: -1.0})


def test_urdf_without_limits_is_an_error(planar_path):
    text = planar_path.read_text().replace('effort="1e6" velocity="1e3"', 'effort="0" velocity="0"')
    arm = Arm.from_urdf_text(text.replace('type="revolute"', 'type="continuous"'), frame="tool", task="xy")
    for name in ("torque_limit", "speed_limit", "position_limit"):
        with pytest.raises(ParameterError, match=f"{name} = 'urdf': the robot's description has no such limit"):
            QPTorque(arm, **{name: "urdf"})
    with pytest.raises(ParameterError, match="acceleration_limit must be"):
        QPTorque(arm, acceleration_limit="urdf")


def test_target_of_another_task_has_no_problem(planar):
    with pytest.raises(ShapeError, match="task"):
        QPTorque(planar).problem(planar.state(INSIDE, np.zeros(3)), Target(*np.zeros((3, 3))))
