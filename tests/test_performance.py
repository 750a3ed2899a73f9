"""Fast paths equal the literal equations, whatever the state and the memory layout; a tick makes few calls."""

import json
import os
import subprocess
import sys
import warnings
from importlib.util import find_spec

import numpy as np
import pytest
from example_arms import example_arm

from aspect_control import Target, controllers
from aspect_control.benchmark import arms, literal
from aspect_control.controllers.qp_solver import NO_LIMIT, SAME_LIMITS
from aspect_control.redundancy import (
    minimum_torque,
    minor_measure_gradient,
    minors,
    pseudoinverse,
    pseudoinverse_torque,
)
from aspect_control.redundancy.gradients import laplace_expansion
from aspect_control.redundancy.pseudoinverse import least_norm, least_norm_solution

STATES = 10_000


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda", "xyz")


def random_states(arm, count, seed):
    rng = np.random.default_rng(seed)
    m = arm.task_dim
    for q, v in zip(rng.uniform(-np.pi, np.pi, (count, arm.nv)), rng.normal(0.0, 1.0, (count, arm.nv)), strict=True):
        yield q, v, Target(rng.normal(0.0, 0.5, m), rng.normal(size=m), rng.normal(size=m))


def relative(actual, expected):
    return np.linalg.norm(actual - expected) / np.linalg.norm(expected)


# Equal to the literal equations


@pytest.mark.parametrize("name", [name for name in literal.LAWS if name != "jmdc"])
def test_torques_equal_the_literal_equations_at_10000_states(panda, name):
    law, (equations, _, _) = controllers.create(name, panda), literal.LAWS[name]
    share = STATES // (len(literal.LAWS) - 1) + 1
    law.reset(np.zeros(7), np.zeros(7), 1e-3)
    worst = 0.0
    for q, v, target in random_states(panda, share, seed=200 + len(name)):
        state = panda.state(q, v)
        expected = equations(panda, state, target)
        # Rounding of the literal equations themselves grows with the condition of J and of M.
        if np.linalg.cond(state.J) > 100.0:
            continue
        worst = max(worst, relative(law.torque(q, v, target), expected))
    assert 0.0 < worst < 1e-9


def test_minor_measure_gradient_equals_the_inverses_at_many_states(panda):
    worst, columns = 0.0, panda.minor_columns
    for q, _, _ in random_states(panda, 300, seed=210):
        J, dJ = panda.jacobian(q), panda.jacobian_derivative(q)
        sizes = np.abs(minors(J, columns))
        if sizes.min() < 1e-4 * sizes.max():
            continue
        expected = literal.minor_measure_gradient(J, dJ, columns)
        worst = max(worst, relative(minor_measure_gradient(J, dJ, columns), expected))
    assert 0.0 < worst < 1e-9


@pytest.mark.parametrize(("m", "n"), [(1, 3), (2, 3), (3, 7), (6, 7), (5, 8)])
def test_gradient_of_any_shape_equals_the_inverses(m, n):
    rng = np.random.default_rng(211)
    J, dJ = rng.normal(size=(m, n)), rng.normal(size=(m, n, n))
    expected = literal.minor_measure_gradient(J, dJ, literal.all_minors(n, m))
    assert relative(minor_measure_gradient(J, dJ), expected) < 1e-10


def test_laplace_expansion_shares_smaller_minors():
    # 35 minors of three rows, 21 of two, 7 of one; 3, 2 and 1 terms each.
    assert laplace_expansion(literal.all_minors(7, 3)).shape == (5, 3 * 35 + 2 * 21 + 7)


def test_laplace_expansion_is_bounded():
    with pytest.raises(ValueError, match="more than 2,000,000 terms"):
        laplace_expansion(literal.all_minors(24, 22))


# Near and at rank loss


def nearly_singular(smallest, seed, shape=(3, 7)):
    """A matrix of known singular values 1, 0.5 and the smallest, with its pseudoinverse."""
    rng = np.random.default_rng(seed)
    U = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    V = np.linalg.qr(rng.normal(size=(shape[1], 3)))[0]
    s = np.array([1.0, 0.5, smallest])
    return (U * s) @ V.T, (V / s) @ U.T


@pytest.mark.parametrize("smallest", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10])
def test_pseudoinverse_keeps_the_condition_of_the_matrix_near_rank_loss(smallest):
    for seed in range(50):
        A, expected = nearly_singular(smallest, seed)
        error = relative(pseudoinverse(A), expected)
        # Eq. (26) by itself would lose the square of the condition number: 1e-16 / smallest².
        assert error < 1e-14 / smallest
        # No worse than numpy.linalg.pinv, but for a factor that a single rounding makes.
        assert error < 20.0 * relative(np.linalg.pinv(A), expected) + 1e-14


@pytest.mark.parametrize("smallest", [1e-1, 1e-3, 1e-4, 1e-5, 1e-8, 1e-10])
def test_least_norm_solutions_are_those_of_the_pseudoinverse(smallest):
    rng = np.random.default_rng(215)
    for seed in range(50):
        A, A_pinv = nearly_singular(smallest, seed)
        B = rng.normal(size=(4, 3))
        expected = B @ A_pinv.T
        X = least_norm(A, B)
        # Each row by itself: a right-hand side does not depend on its neighbours.
        for x, x_expected, b in zip(X, expected, B, strict=True):
            assert np.linalg.norm(x - x_expected) < 1e-14 / smallest * np.linalg.norm(A_pinv, 2) * np.linalg.norm(b)
            np.testing.assert_array_equal(x, least_norm_solution(A, b))


def test_least_norm_solutions_of_what_cannot_be_reached_are_bounded():
    for seed in range(20):
        A, _ = nearly_singular(1e-15, seed)
        assert np.linalg.norm(least_norm(A, np.eye(3)), 2) < 2.5
    tall = np.random.default_rng(216).normal(size=(5, 2))
    np.testing.assert_allclose(least_norm(tall, np.eye(5)), np.linalg.pinv(tall).T, rtol=0, atol=1e-13)
    with pytest.raises(ValueError, match="shapes of a linear system"):
        least_norm(np.ones((2, 3)), np.ones((1, 3)))


def test_pseudoinverse_is_bounded_at_rank_loss():
    for seed in range(50):
        A, _ = nearly_singular(1e-14, seed)
        lost, _ = nearly_singular(1e-17, seed)
        for matrix in (A, lost, lost.T.copy()):
            X = pseudoinverse(matrix)
            assert np.linalg.norm(X, 2) < 2.5
            np.testing.assert_allclose(matrix @ X @ matrix, matrix, rtol=0, atol=1e-13)


@pytest.mark.filterwarnings("ignore::aspect_control.exceptions.UndefinedCriterionWarning")
@pytest.mark.parametrize("name", [name for name in controllers.available() if name != "qp"])
def test_torque_is_bounded_at_a_stretched_arm(planar, name):
    law = controllers.create(name, planar, **({"kappa": 0.0} if name == "jmdc" else {}))
    law.reset(np.zeros(3), np.zeros(3), 1e-3)
    x = planar.task_position(np.zeros(3))
    tau = law.torque(np.zeros(3), np.zeros(3), Target(x, np.zeros(2), np.array([1.0, 1.0])))
    assert np.abs(tau).max() < 1e3


# Memory layouts and types


def test_functions_take_c_and_fortran_order_and_strides(panda):
    (q, v, _) = next(random_states(panda, 1, seed=212))
    s, b, dJ = panda.state(q, v), np.ones(3), panda.jacobian_derivative(q)
    wide = np.zeros((14, 14))
    wide[::2, ::2] = s.M
    for order in (np.ascontiguousarray, np.asfortranarray):
        for law in (pseudoinverse_torque, minimum_torque):
            np.testing.assert_array_equal(law(order(s.M), s.nle, order(s.J), b), law(s.M, s.nle, s.J, b))
        np.testing.assert_array_equal(pseudoinverse(order(s.J)), pseudoinverse(s.J))
        gradient = minor_measure_gradient(order(s.J), order(dJ), panda.minor_columns)
        np.testing.assert_array_equal(gradient, minor_measure_gradient(s.J, dJ, panda.minor_columns))
    np.testing.assert_array_equal(minimum_torque(wide[::2, ::2], s.nle, s.J, b), minimum_torque(s.M, s.nle, s.J, b))
    np.testing.assert_array_equal(pseudoinverse([[1, 0], [0, 2]]), [[1.0, 0.0], [0.0, 0.5]])
    named = minimum_torque(b=b, J=s.J, nle=s.nle, M=s.M)
    np.testing.assert_array_equal(named, minimum_torque(s.M, s.nle, s.J, b))


def test_shapes_that_do_not_fit_are_refused(panda):
    s = panda.state(np.zeros(7), np.zeros(7))
    for call in (
        lambda: pseudoinverse_torque(s.M, s.nle, s.J, np.ones(4)),
        lambda: minimum_torque(s.M[:6, :6], s.nle, s.J, np.ones(3)),
        lambda: minimum_torque(s.M, s.nle[:6], s.J, np.ones(3)),
    ):
        with pytest.raises(ValueError, match=r"shape|broadcast"):
            call()


# How little a tick does


def calls_of(function):
    """Calls of Python and of C functions that a call makes."""
    count = 0

    def seen(frame, event, argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(seen)
    try:
        function()
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize(
    ("name", "most"), [*((name, 10) for name in literal.LAWS if name != "jmdc"), ("jmdc", 20)], ids=str
)
def test_a_tick_makes_few_calls(panda, name, most):
    q, v, target = next(random_states(panda, 1, seed=213))
    law = controllers.create(name, panda)
    law.reset(q, v, 1e-3)
    law.torque(q, v, target)
    # Calls are counted, not timed: the same on every machine. The literal laws make several hundred.
    assert calls_of(lambda: law.torque(q, v, target)) <= most


@pytest.mark.parametrize("solver", ["osqp", "daqp"])
def test_a_tick_of_the_quadratic_program_makes_few_calls(panda, solver):
    pytest.importorskip(solver)
    # A state at which the joint of the largest torque can do with less.
    q, v, target = next(random_states(panda, 6, seed=213))
    least = np.abs(controllers.create("null-space-vector", panda).torque(q, v, target))
    binding = 2.0 * least + 10.0
    binding[np.argmax(least)] = 0.98 * least.max()
    for limit, message in ((least + 1.0, NO_LIMIT), (binding, SAME_LIMITS)):
        law = controllers.QPTorque(panda, solver=solver, torque_limit=limit)
        law.reset(q, v, 1e-3)
        law.torque(q, v, target)
        assert calls_of(lambda law=law: law.torque(q, v, target)) <= 16
        assert (law.status.outcome, law.status.message) == ("optimal", message)


def test_a_literal_tick_makes_many_more_calls(panda):
    q, v, target = next(random_states(panda, 1, seed=213))
    equations = literal.LAWS["null-space-vector"][0]
    assert calls_of(lambda: equations(panda, panda.state(q, v), target)) > 80


@pytest.mark.parametrize("name", literal.LAWS)
def test_no_tick_compiles_anything(panda, name, monkeypatch):
    import numba

    q, v, target = next(random_states(panda, 1, seed=214))
    law = controllers.create(name, panda)
    law.reset(q, v, 1e-3)

    def compiled_now(*_, **__):
        pytest.fail("a tick compiled something")

    monkeypatch.setattr(numba, "njit", compiled_now)
    law.torque(q, v, target)


@pytest.mark.parametrize("solver", ["osqp", "daqp"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"torque_limit": 30.0},
        {"torque_limit": "urdf", "speed_limit": "urdf", "position_limit": "urdf", "acceleration_limit": 30.0},
        {"torque_limit": 60.0, "stability": "maciejewski"},
    ],
    ids=["free", "torque", "every limit", "stability"],
)
def test_no_tick_of_the_quadratic_program_compiles_anything(solver, options):
    pytest.importorskip(solver)
    code = f"""
import numba, numpy as np
from aspect_control import Arm, Target, controllers
arm = Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
law = controllers.QPTorque(arm, solver={solver!r}, **{options!r})
def now(*_, **__):
    raise SystemExit("a tick compiled something")
numba.njit = now
rng = np.random.default_rng(218)
lower, upper = arm.position_limits
outcomes = set()
law.reset(arm.configuration(lower), np.zeros(7), 1e-3)
for i in range(60):
    q, v = rng.uniform(lower, upper), rng.normal(0.0, 0.5, 7)
    law.torque(q, v, Target(arm.task_position(q) + 0.1, rng.normal(size=3), (1 + i % 3) ** 3 * rng.normal(size=3)))
    outcomes.add(law.status.outcome)
print(*sorted(outcomes))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "optimal" in done.stdout


def test_a_tick_spawns_no_thread(panda):
    code = """
import os, numpy as np
from aspect_control import Arm, Target, controllers
arm = Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
law = controllers.create("jmdc", arm)
q, v = np.full(7, 0.3), np.zeros(7)
law.reset(q, v, 1e-3)
target = Target(arm.task_position(q), np.zeros(3), np.zeros(3))
def busy():
    used = 0
    for task in os.listdir("/proc/self/task"):
        fields = open(f"/proc/self/task/{task}/stat").read().rsplit(")", 1)[1].split()
        used += int(task) != os.getpid() and int(fields[11]) + int(fields[12])
    return len(os.listdir("/proc/self/task")), used
before = busy()
for _ in range(20000):
    law.torque(q, v, target)
print(before == busy())
"""
    if not sys.platform.startswith("linux"):
        pytest.skip("reads /proc")
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert output.strip() == "True"


# The compiled text


def test_importing_the_package_does_not_import_numba():
    code = "import json, sys, aspect_control; print('numba' in sys.modules)"
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert output.strip() == "False"


def test_laws_work_where_nothing_can_be_written(tmp_path):
    code = """
from pathlib import Path
from aspect_control.redundancy import compiled
compiled._is_writable = lambda folder: False
import numpy as np
from aspect_control.redundancy import pseudoinverse
print(pseudoinverse(np.array([[3.0, 4.0]])).ravel().tolist())
"""
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert json.loads(output) == pytest.approx([0.12, 0.16])


def test_first_command_on_a_machine_says_that_it_compiles(tmp_path):
    pty = pytest.importorskip("pty")
    code = """
import time, numpy as np
from aspect_control.redundancy.products import times
from aspect_control.views.screen import progress_bar
with progress_bar() as progress:
    time.sleep(0.3)
    times(np.eye(2), np.ones(2))
    progress("done", 1.0)
"""
    place = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "TERM": "xterm", "COLUMNS": "120"}
    shown = []
    for _ in range(2):
        ours, theirs = pty.openpty()
        with subprocess.Popen([sys.executable, "-c", code], stderr=theirs, env=place) as process:
            os.close(theirs)
            text = b""
            try:
                while part := os.read(ours, 4096):
                    text += part
            except OSError:
                pass  # what Linux says when the other end is closed
        os.close(ours)
        assert process.returncode == 0, text.decode()
        shown.append("compiling the laws for this machine, once" in text.decode())
    assert shown == [True, False]


def test_overflow_is_an_error_and_no_warning(panda):
    from aspect_control.exceptions import NonFiniteError

    law = controllers.create("null-space-vector", panda)
    target = Target(np.zeros(3), np.zeros(3), np.zeros(3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(NonFiniteError, match="overflows"):
            law.torque(np.full(7, 0.3), np.full(7, 1e200), target)
        with pytest.raises(NonFiniteError, match="q must be finite"):
            law.torque(np.full(7, np.nan), np.zeros(7), target)


def test_a_subclass_with_a_command_of_its_own_is_checked():
    class Mine(controllers.Pseudoinverse):
        def command(self, state, target):
            return super().command(state, target) * np.inf

    from aspect_control.exceptions import NonFiniteError

    arm = arms.planar()
    assert controllers.Pseudoinverse.is_compiled
    assert not Mine.is_compiled
    with pytest.raises(NonFiniteError):
        Mine(arm).torque(np.ones(3), np.zeros(3), Target(np.ones(2), np.zeros(2), np.zeros(2)))


def test_switching_on_compiled_text_is_the_law_as_printed(panda):
    law, equations = controllers.create("modified-null-space-vector", panda), literal.modified_null_space_vector
    both = {True: 0, False: 0}
    for q, v, target in random_states(panda, 300, seed=217):
        state = panda.state(q, v)
        if np.linalg.cond(state.J) > 100.0:
            continue
        tau = law.torque(q, v, target)
        assert relative(tau, equations(panda, state, target)) < 1e-9
        both[relative(tau, literal.pseudoinverse(panda, state, target)) < 1e-9] += 1
    assert min(both.values()) > 30


# The benchmark


def test_a_call_is_timed_when_it_has_been_called_before(monkeypatch):
    from aspect_control.benchmark.timing import in_turn

    # A clock that only the calls move: 0.1 ms each, but ten times that for the first two after another call's turn.
    now, last, cold = 0.0, "", 0
    calls = {"one": 0, "other": 0}

    def call(name):
        nonlocal now, last, cold
        cold = 2 if name != last else max(cold - 1, 0)
        now, last = now + (1e-3 if cold else 1e-4), name
        calls[name] += 1

    monkeypatch.setattr("aspect_control.benchmark.timing.time.perf_counter", lambda: now)
    seconds = in_turn({name: lambda name=name: call(name) for name in calls}, 7)
    for name, times in seconds.items():
        np.testing.assert_allclose(times, np.full(7, 1e-4), rtol=1e-6)
        # Ten timed and three before in every round, besides those that tell how many.
        assert 7 * 13 <= calls[name] <= 7 * 13 + 40
    # A call that returns seconds is taken at its word.
    np.testing.assert_array_equal(in_turn({"measured": lambda: 2.0}, 4)["measured"], np.full(4, 2.0))


def test_benchmark_has_a_row_a_law():
    from aspect_control.benchmark.targets import verdicts
    from aspect_control.benchmark.ticks import ticks

    rows = ticks("Panda, xyz: short", arms.panda(), 3)
    assert {row.name for row in rows} >= {"floor", *literal.LAWS}
    assert all(np.isfinite(row.seconds).all() and (row.seconds > 0.0).all() for row in rows)
    # A wide margin, on purpose: this is no measurement of speed, and a busy machine must not fail it.
    found = {row.name: row for row in rows}
    assert found["jmdc, literal"].ratio > found["jmdc"].ratio
    assert all(each.met is None for each in verdicts([]))


def test_benchmark_tells_ticks_apart_by_what_the_limits_do():
    from aspect_control.benchmark.programs import FREE, HELD, SCALED, SEARCHED, programs
    from aspect_control.benchmark.targets import verdicts

    rows = programs(arms.panda(), 3)
    assert {row.group for row in rows} == {FREE, HELD, SEARCHED, SCALED}
    judged = [each for each in verdicts(rows) if each.measured is not None]
    assert {each.target for each in judged} >= {
        "qp, a torque limit binds: osqp ≤ 10 × floor",
        "qp, no limit in the way: osqp ≤ 10 × floor",
    }
    # A wide margin, on purpose.
    found = {(row.group, row.name): row.ratio for row in rows}
    assert found[HELD, "osqp"] < found[HELD, "plain qpsolvers, osqp"]


def test_bench_tells_at_once_that_a_python_has_no_placo(tmp_path):
    program = ["-c", "import sys; from aspect_control.cli import main; main()", "bench", "--out", str(tmp_path)]
    for python in ("/nowhere/python", *([] if find_spec("placo") else [sys.executable])):
        result = subprocess.run(
            [sys.executable, *program, "--rounds", "3", "--placo-python", python], capture_output=True, text=True
        )
        assert result.returncode == 2
        assert "must be a Python that has PlaCo, got" in result.stderr
        assert "Traceback" not in result.stderr


def test_a_law_whose_file_has_changed_does_not_meet_its_old_machine_code(tmp_path):
    text = """
from aspect_control.redundancy.feedback import task_space_law

@task_space_law()
def torque(M, nle, J, b, v):
    return {factor} * nle
"""
    call = (
        "import numpy as np, law; o, tau = np.ones, np.zeros(3); "
        "law.torque(np.eye(3), o(3), o((2, 3)), o(2), o(2), o(3), o((3, 2)), o((2, 2, 2)), tau); print(*tau)"
    )
    place = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kept"), "PYTHONPATH": str(tmp_path)}
    for factor in ("2.0", "3.0"):
        (tmp_path / "law.py").write_text(text.format(factor=factor))
        done = subprocess.run([sys.executable, "-c", call], env=place, capture_output=True, text=True, check=True)
        assert done.stdout.split() == [factor] * 3
