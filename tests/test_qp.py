"""Least torque as a quadratic program: against Eq. (11), independent solvers, its limits, and what can go wrong."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
import qpsolvers
from example_arms import example_arm, random_motions
from scipy.optimize import linprog

from aspect_control import Arm, StraightLine, Target, controllers, simulate
from aspect_control.analysis.metrics import aspect_preserved, total_variation
from aspect_control.analysis.trajectory_a import Q0, TRAJECTORY
from aspect_control.controllers.qp import QPTorque
from aspect_control.controllers.qp_osqp import KeptOSQP
from aspect_control.controllers.qp_solver import NO_LIMIT, SAME_LIMITS, Answer
from aspect_control.exceptions import (
    NonFiniteError,
    NotResetError,
    ParameterError,
    ShapeError,
    UnknownNameError,
)

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
REST = Target(np.zeros(2), np.zeros(2), np.zeros(2))
INSIDE = np.array([0.3, 0.4, 0.5])


@pytest.fixture
def robot(request, planar):
    return planar if request.param == "planar" else example_arm(request.param)


every_arm = pytest.mark.parametrize("robot", ARMS, indirect=True)
planar_and_panda = pytest.mark.parametrize("robot", ["planar", "panda"], indirect=True)
every_limit = pytest.mark.parametrize("limits", LIMITS.values(), ids=LIMITS)


def require(solver):
    if solver not in qpsolvers.available_solvers:
        pytest.skip(f"{solver} is not installed")


def samples(arm, count, seed):
    rng = np.random.default_rng(seed)
    for q, v in random_motions(arm, count, seed):
        x = arm.task_position(q) + rng.normal(0.0, 0.1, arm.task_dim)
        yield q, v, Target(x, *rng.normal(0.0, 2.0, (2, arm.task_dim)))


class Literal:
    """Eq. (8) with limits in φ, by NumPy's pseudoinverse: τ = M(s J⁺b + (I − J⁺J)φ) + N, G φ + s g ≤ h."""

    def __init__(self, controller, q, v, target, dt=None):
        arm, limits, T = controller.arm, controller.limits, controller.horizon
        state = arm.state(q, v)
        J_pinv = np.linalg.pinv(state.J)
        self.P = np.eye(arm.nv) - J_pinv @ state.J
        self.particular = J_pinv @ controller.commanded_acceleration(state, target)
        self.M, self.nle = state.M, state.nle
        G, g, h = [], [], []
        if limits.torque is not None:
            MP, c = state.M @ self.P, state.M @ self.particular
            G += [MP, -MP]
            g += [c, -c]
            h += [limits.torque - state.nle, limits.torque + state.nle]
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

    def least_torque(self, s):
        """The torque of Eq. (8) by quadprog on φ, regularised by 1e-10."""
        MP, fixed = self.M @ self.P, s * self.M @ self.particular + self.nle
        cost = MP.T @ MP + 1e-10 * np.eye(len(MP))
        phi = qpsolvers.solve_qp(cost, MP.T @ fixed, self.G, self.h - s * self.g, solver="quadprog")
        return None if phi is None else MP @ phi + fixed


# The law without a limit in the way


@every_arm
@pytest.mark.parametrize(("solver", "accuracy"), [("osqp", 1e-4), ("daqp", 1e-7), ("quadprog", 1e-7)])
@pytest.mark.parametrize("limits", [{}, {"torque_limit": 1e7}], ids=["no limits", "wide limits"])
def test_without_active_limit_it_is_equation_11(robot, solver, accuracy, limits):
    require(solver)
    controller, reference = QPTorque(robot, solver=solver, **limits), controllers.NullSpaceVector(robot)
    for q, v, target in samples(robot, 1000, seed=1):
        expected = reference.torque(q, v, target)
        np.testing.assert_allclose(controller.torque(q, v, target), expected, rtol=0, atol=accuracy)
        assert controller.status.outcome == "optimal"
        assert controller.status.task_scale == 1.0


def test_problem_is_the_program_in_the_smallest_number_of_unknowns():
    arm = example_arm("panda")
    controller = QPTorque(arm, torque_limit="urdf", acceleration_limit=5e3, solver="osqp")
    # A posture at which the limits allow the whole task and change the torque.
    for q, v, target in samples(arm, 200, seed=2):
        tau, least = controller.torque(q, v, target), controllers.NullSpaceVector(arm).torque(q, v, target)
        if controller.status.outcome == "optimal" and np.abs(tau - least).max() > 0.1:
            break
    problem = controller.problem(q, v, target)
    r = arm.nv - arm.task_dim
    np.testing.assert_array_equal(problem.P, np.eye(r))
    np.testing.assert_array_equal(problem.q, np.zeros(r))
    assert problem.G.shape == (4 * arm.nv, r)
    eta = qpsolvers.solve_problem(problem, "quadprog").x
    literal = Literal(controller, q, v, target).least_torque(1.0)
    # ‖τ‖² = ‖η‖² + ‖τ of Eq. (11)‖²
    assert eta @ eta + least @ least == pytest.approx(literal @ literal, rel=1e-6)


# Limits


@planar_and_panda
@every_limit
@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_tight_limits_hold_and_the_task_scale_is_the_largest(robot, limits, solver):
    require(solver)
    controller = QPTorque(robot, solver=solver, **limits)
    outcomes = set()
    for q, v, target in samples(robot, 300, seed=3):
        tau = controller.torque(q, v, target)
        status, literal = controller.status, Literal(controller, q, v, target)
        outcomes.add(status.outcome)
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
    assert "scaled" in outcomes


@planar_and_panda
@pytest.mark.parametrize("solver", SOLVERS)
def test_with_active_limits_it_is_the_literal_program(robot, solver):
    require(solver)
    require("quadprog")
    controller = QPTorque(robot, solver=solver, torque_limit=200.0, acceleration_limit=100.0)
    compared = active = 0
    for q, v, target in samples(robot, 150, seed=4):
        tau = controller.torque(q, v, target)
        if controller.status.outcome != "optimal":
            continue
        expected = Literal(controller, q, v, target).least_torque(1.0)
        if expected is None:
            continue
        np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-3)
        compared += 1
        active += np.abs(tau - controllers.NullSpaceVector(robot).torque(q, v, target)).max() > 0.1
    assert compared > 10
    assert active > 3


def test_every_solver_gives_the_same_scale_and_the_same_outcome(planar):
    for solver in SOLVERS:
        require(solver)
    laws = [QPTorque(planar, solver=solver, torque_limit=30.0) for solver in SOLVERS]
    for q, v, target in samples(planar, 100, seed=5):
        torques = [law.torque(q, v, target) for law in laws]
        assert len({law.status.outcome for law in laws}) == 1
        for law, tau in zip(laws, torques, strict=True):
            assert law.status.task_scale == pytest.approx(laws[1].status.task_scale, abs=1e-7)
            np.testing.assert_allclose(tau, torques[1], rtol=0, atol=1e-3)


def test_braking_takes_energy_out_of_the_arm(monkeypatch):
    arm = example_arm("panda")
    controller = QPTorque(arm, torque_limit=80.0)
    monkeypatch.setattr(controller._solver, "solve", raises)
    limited = 0
    for q, v, target in samples(arm, 100, seed=6):
        tau, gravity = controller.torque(q, v, target), arm.state(q, np.zeros(arm.nv)).nle
        assert controller.status.outcome == "braking"
        assert controller.status.task_scale == 0.0
        assert "no torque within the limits" in controller.status.message
        assert np.abs(tau).max() <= 80.0
        if np.isclose(np.abs(tau).max(), 80.0) and np.abs(gravity).max() < 80.0:
            limited += 1
            assert v @ (tau - gravity) < 0.0
    assert limited > 2


def test_braking_is_the_stated_torque_when_it_fits(planar, monkeypatch):
    controller = QPTorque(planar, torque_limit=1e6, horizon=0.2)
    monkeypatch.setattr(controller._solver, "solve", raises)
    for q, v, target in samples(planar, 20, seed=15):
        state = planar.state(q, v)
        expected = state.M @ (-v / 0.2) + state.nle
        np.testing.assert_allclose(controller.torque(q, v, target), expected, rtol=1e-12)


def test_braking_brings_the_arm_to_rest(planar, monkeypatch):
    controller = QPTorque(planar, torque_limit=5.0)
    monkeypatch.setattr(controller._solver, "solve", raises)
    run = simulate(
        controller, StraightLine(np.zeros(2), duration=4.0), q0=INSIDE, v0=[1.0, -2.0, 2.0], dt=DT, events=()
    )
    energy = [v @ planar.state(q, v).M @ v for q, v in zip(run.q, run.v, strict=True)]
    assert np.all(np.diff(energy) <= 1e-9)
    assert energy[-1] < 1e-3 * energy[0]


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
def test_half_space_is_the_modified_method_for_one_spare_joint(planar, solver):
    require(solver)
    law = QPTorque(planar, solver=solver, stability="maciejewski")
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
    law, modified = QPTorque(robot, stability="maciejewski"), controllers.ModifiedNullSpaceVector(robot)
    saved = 0
    for q, v, target in samples(robot, 200, seed=9):
        tau, switched = law.torque(q, v, target), modified.torque(q, v, target)
        assert tau @ tau <= (switched @ switched) * (1.0 + 1e-9) + 1e-6
        saved += tau @ tau < 0.999 * (switched @ switched)
    assert saved > 20


@every_arm
def test_dead_beat_brakes_no_further_than_to_rest(robot):
    law = QPTorque(robot, stability="dead-beat")
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
    with pytest.raises(NotResetError, match=r"qp with .*dead-beat.* needs Δt: call reset\(q, v, dt\)"):
        QPTorque(planar, stability="dead-beat").torque(INSIDE, np.zeros(3), REST)


# In closed loop


@pytest.mark.parametrize("stability", ["maciejewski", "dead-beat"])
def test_trajectory_a_within_a_torque_limit(planar, stability):
    run = simulate(QPTorque(planar, torque_limit=30.0, stability=stability), TRAJECTORY, q0=Q0, dt=DT)
    assert np.abs(run.tau).max() <= 30.0 + 1e-6
    assert run.status == "finished"


def test_trajectory_a_least_torque_within_a_limit_is_bounded_but_loses_the_task(planar):
    # From t = 0.77 s on the self-motion that the method has built up costs more than 30 N m.
    run = simulate(QPTorque(planar, torque_limit=30.0), TRAJECTORY, q0=Q0, dt=DT, events=())
    assert run.status == "finished"
    assert np.abs(run.tau).max() <= 30.0 + 1e-6
    assert run.tracking_error.max() > 0.1


def test_trajectory_a_dead_beat_stays_in_its_aspect_without_chatter(planar):
    run = simulate(QPTorque(planar, stability="dead-beat"), TRAJECTORY, q0=Q0, dt=DT)
    assert run.status == "finished"
    assert aspect_preserved(run)
    assert total_variation(run.tau)[0] < 60.0


def test_trajectory_a_maciejewski_stays_in_its_aspect(planar):
    run = simulate(QPTorque(planar, stability="maciejewski"), TRAJECTORY, q0=Q0, dt=DT)
    assert run.status == "finished"
    assert aspect_preserved(run)
    assert np.abs(run.tau).max() < 20.0


@pytest.mark.parametrize("stability", ["none", "dead-beat"])
def test_panda_within_the_limits_of_its_urdf(stability):
    arm = example_arm("panda")
    law = QPTorque(arm, torque_limit="urdf", speed_limit="urdf", position_limit="urdf", stability=stability)
    q0 = np.array([0.1, -0.5, 0.2, -2.0, 0.1, 1.6, 0.5])
    run = simulate(law, StraightLine([0.1, 0.1, -0.1], duration=0.5), q0=q0, dt=DT)
    assert run.status == "finished"
    assert np.all(np.abs(run.tau) <= arm.torque_limit + 1e-6)
    # The bound holds for M and N of the sample; within it they change.
    assert np.all(np.abs(run.v) <= arm.velocity_limit + 0.05)
    lower, upper = arm.position_limits
    assert np.all((run.q >= lower - 1e-3) & (run.q <= upper + 1e-3))


# The kept workspace


@pytest.fixture
def osqp_calls(monkeypatch):
    """Calls of OSQP's workspaces, counted by name."""
    import osqp

    counts = {"setup": 0, "update": 0, "solve": 0}
    for name in counts:
        original = getattr(osqp.OSQP, name)

        def counted(self, *args, name=name, original=original, **kwargs):
            counts[name] += 1
            return original(self, *args, **kwargs)

        monkeypatch.setattr(osqp.OSQP, name, counted)
    return counts


def test_workspace_is_set_up_once_a_shape(planar, osqp_calls):
    law = QPTorque(planar, torque_limit=30.0)
    law.reset(INSIDE, np.zeros(3), DT)
    for q, v, target in samples(planar, 100, seed=11):
        law.torque(q, v, target)
    # Programs that keep the task and programs that scale it.
    assert osqp_calls["setup"] == 2
    assert osqp_calls["solve"] > 100
    assert osqp_calls["update"] == osqp_calls["solve"] - 2


@pytest.mark.parametrize("solver", SOLVERS)
def test_no_solver_is_called_where_no_limit_is_in_the_way(planar, solver, monkeypatch):
    require(solver)
    law = QPTorque(planar, solver=solver, torque_limit=1e7)
    monkeypatch.setattr(law._solver, "search", raises)
    for q, v, target in samples(planar, 50, seed=11):
        law.torque(q, v, target)
        assert (law.status.outcome, law.status.iterations) == ("optimal", 0)
        assert law.status.message == NO_LIMIT


@pytest.mark.parametrize("limits", LIMITS.values(), ids=LIMITS)
@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_torque_does_not_depend_on_the_limits_of_the_sample_before(solver, limits):
    require(solver)
    arm = example_arm("panda")
    kept, forgetful = QPTorque(arm, solver=solver, **limits), QPTorque(arm, solver=solver, **limits)
    q, v, target = next(samples(arm, 1, seed=16))
    counts = {"kept": 0, "searched": 0}
    for i in range(60):
        # Small steps, so that the limits that are reached change now and then.
        state = q + 0.004 * i, v * np.cos(0.05 * i), target
        forgetful._solver.forget()
        tau = kept.torque(*state)
        np.testing.assert_allclose(tau, forgetful.torque(*state), rtol=0, atol=1e-5 * (1.0 + np.abs(tau).max()))
        assert kept.status.outcome == forgetful.status.outcome
        assert kept.status.task_scale == pytest.approx(forgetful.status.task_scale, abs=1e-7)
        counts["kept" if kept.status.message == SAME_LIMITS else "searched"] += 1
        assert forgetful.status.message != SAME_LIMITS
    assert min(counts.values()) > 0


def test_no_sparse_conversion_after_the_first_tick(planar, monkeypatch):
    from aspect_control.controllers import qp_osqp

    law = QPTorque(planar, torque_limit=30.0)
    motions = list(samples(planar, 20, seed=11))
    for each in motions[:10]:
        law.torque(*each)
    monkeypatch.setattr(qp_osqp, "_dense_pattern", None)
    for each in motions[10:]:
        law._solver._multipliers.clear()
        law.torque(*each)
        assert law.status.iterations
        assert "TypeError" not in law.status.message


def test_reset_makes_a_run_repeatable(planar):
    law = QPTorque(planar, torque_limit=30.0)
    runs = [simulate(law, TRAJECTORY, q0=Q0, dt=2e-2, events=()) for _ in range(2)]
    np.testing.assert_array_equal(runs[0].tau, runs[1].tau)


def test_nothing_is_printed(planar, capfd):
    law = QPTorque(planar, torque_limit=30.0)
    for q, v, target in samples(planar, 50, seed=12):
        law.torque(q, v, target)
    assert capfd.readouterr() == ("", "")


def test_import_loads_no_solver():
    code = (
        "import sys, aspect_control, aspect_control.controllers.qp\n"
        "sys.exit(bool({'osqp', 'qpsolvers', 'scipy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# A solver that fails


def raises(program):
    raise RuntimeError("out of order")


FAILURES = {
    "raises": raises,
    "NaN": lambda p: Answer(np.full(len(p.q), np.nan), np.zeros(len(p.A)), "solved", 1),
    "wrong shape": lambda p: Answer(np.zeros(len(p.q) + 3), np.zeros(len(p.A)), "solved", 1),
    "no solution": lambda p: Answer(None, np.zeros(len(p.A)), "stopped", 1),
    "garbage": lambda p: Answer(np.full(len(p.q), 1e6), np.zeros(len(p.A)), "solved", 1),
    "garbage object": lambda p: None,
    "not optimal": lambda p: Answer(np.full(len(p.q), 1.0), np.zeros(len(p.A)), "solved", 1),
}


@pytest.mark.parametrize("failure", FAILURES.values(), ids=FAILURES)
@every_arm
def test_failing_solver_ends_in_bounded_braking(robot, failure, monkeypatch):
    law = QPTorque(robot, torque_limit=500.0)
    monkeypatch.setattr(law._solver, "solve", failure)
    q, v, target = next(samples(robot, 1, seed=13))
    tau = law.torque(q, v, target)
    assert law.status.outcome == "braking"
    assert np.isfinite(tau).all()
    assert np.abs(tau).max() <= 500.0


def test_old_solution_is_not_taken_for_a_new_one(planar, monkeypatch):
    law = QPTorque(planar, torque_limit=40.0)
    answers, solve = {}, law._solver.solve

    def stale(program):
        return answers.setdefault(program.A.shape, solve(program))

    monkeypatch.setattr(law._solver, "solve", stale)
    outcomes = []
    for q, v, target in samples(planar, 30, seed=14):
        tau = law.torque(q, v, target)
        assert np.abs(tau).max() <= 40.0
        outcomes.append(law.status.outcome)
    assert outcomes[0] == "scaled"
    assert set(outcomes[1:]) == {"braking"}


def test_osqp_that_does_not_converge_leaves_a_bounded_torque(planar, monkeypatch):
    import osqp

    monkeypatch.setattr(osqp.OSQP, "solve", raises)
    law = QPTorque(planar, torque_limit=40.0)
    tau = law.torque(INSIDE, np.ones(3), REST)
    assert law.status.outcome == "braking"
    assert np.abs(tau).max() <= 40.0


@pytest.mark.parametrize("q", [np.zeros(3), [0.0, np.pi, 0.0], [0.0, 0.0, np.pi]])
@pytest.mark.parametrize("stability", ["none", "maciejewski", "dead-beat"])
def test_rank_deficient_jacobian(planar, q, stability):
    law = QPTorque(planar, torque_limit=30.0, stability=stability)
    law.reset(q, np.zeros(3), DT)
    for v in (np.zeros(3), np.array([1.0, -2.0, 3.0])):
        tau = law.torque(q, v, Target([1.0, 1.0], [1.0, -1.0], [1.0, 1.0]))
        assert np.isfinite(tau).all()
        assert np.abs(tau).max() <= 30.0 + 1e-6


@pytest.mark.parametrize("speed", [1e10, 1e100, 1e150])
def test_torque_is_bounded_or_an_error_at_absurd_speeds(planar, speed):
    law = QPTorque(planar, torque_limit=30.0)
    try:
        tau = law.torque(INSIDE, speed * np.array([1.0, -1.0, 1.0]), REST)
    except NonFiniteError:
        return
    assert np.abs(tau).max() <= 30.0


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
        horizon=0.2,
        stability="maciejewski",
    )
    again = QPTorque(arm, **law.parameters)
    assert again.parameters == law.parameters
    assert law.parameters["position_limit"] == [-3.0, [3.0] * 7]
    assert isinstance(law._solver, KeptOSQP)


def test_status_cannot_be_changed(planar):
    law = QPTorque(planar)
    assert law.status is None
    law.torque(INSIDE, np.zeros(3), REST)
    with pytest.raises(dataclasses.FrozenInstanceError):
        law.status.outcome = "braking"


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
        (np.nan, NonFiniteError),
        (np.inf, NonFiniteError),
        ([1.0, 2.0], ShapeError),
        (np.ones((3, 3)), ShapeError),
        ("high", ParameterError),
        (True, ParameterError),
        ({}, ShapeError),
    ],
)
def test_bad_limit_is_an_error(planar, name, value, error):
    with pytest.raises(error, match=name):
        QPTorque(planar, **{name: value})


@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        ((1.0, -1.0), ParameterError, r"below the upper, got \[1, -1\] for joint"),
        ((1.0, 1.0), ParameterError, "below the upper"),
        (([0.0, 0.0, 2.0], 1.0), ParameterError, r"got \[2, 1\]"),
        ((np.nan, 1.0), NonFiniteError, r"position_limit\[0\]"),
        ((0.0, np.inf), NonFiniteError, r"position_limit\[1\]"),
        (([0.0, 0.0], 1.0), ShapeError, r"position_limit\[0\] must have shape \(3,\), got \(2,\)"),
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


@pytest.mark.parametrize("gain", ["kp", "kv"])
def test_negative_gain_is_an_error(planar, gain):
    with pytest.raises(ParameterError, match="must not be negative"):
        QPTorque(planar, **{gain: -1.0})


def test_urdf_without_limits_is_an_error(planar_path):
    text = planar_path.read_text().replace('effort="1e6" velocity="1e3"', 'effort="0" velocity="0"')
    arm = Arm.from_urdf_text(text.replace('type="revolute"', 'type="continuous"'), frame="tool", task="xy")
    for name in ("torque_limit", "speed_limit", "position_limit", "acceleration_limit"):
        with pytest.raises(ParameterError, match=f"{name} = 'urdf': the description of 'planar3r' has no such limit"):
            QPTorque(arm, **{name: "urdf"})


def test_target_of_another_task_has_no_problem(planar):
    with pytest.raises(ShapeError, match="task"):
        QPTorque(planar).problem(INSIDE, np.zeros(3), Target(*np.zeros((3, 3))))
