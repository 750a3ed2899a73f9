"""The mathematics as plain NumPy and compiled by Numba: against the literal equations, and against each other."""

import os
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

import kernel_checks
from aspect_control import controllers
from aspect_control.redundancy import kernels_compiled, minor_measure_gradient
from aspect_control.redundancy.laplace import laplace_expansion
from kernel_checks import CLOSED_FORMS, COMPARED, SMALLEST, VARIANTS, nearly_singular, relative
from oracles import literal

needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="needs Numba, the extra fast")
both_modes = pytest.mark.parametrize("mode", ["NumPy", pytest.param("compiled", marks=needs_numba)])


@pytest.fixture(scope="session")
def plain():
    return kernel_checks.everything()


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """The same of a process of its own, which compiles; this one stays plain NumPy."""
    path = tmp_path_factory.mktemp("kernels") / "compiled.npz"
    done = subprocess.run([sys.executable, kernel_checks.__file__, str(path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(path) as file:
        return dict(file)


@pytest.fixture
def results(mode, request):
    return request.getfixturevalue("plain" if mode == "NumPy" else "compiled")


def run_python(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, **environment}
    )


# Equal to the literal equations, in both modes


@both_modes
def test_the_mode_is_what_it_says(results, mode):
    assert results["is compiled"] == (mode == "compiled")


@both_modes
@pytest.mark.parametrize("name", literal.LAWS)
def test_torques_equal_the_literal_equations_at_10000_states(results, name):
    errors = results[f"error {name}"]
    # Some states have a minor so small that the gradient of the minor measure cannot be compared.
    assert len(errors) > (1400 if name in CLOSED_FORMS else 900)
    assert 0.0 < errors.max() < 1e-9


def test_the_laws_share_10000_states(plain):
    assert sum(len(plain[f"error {name}"]) for name in literal.LAWS) > 9_000


@both_modes
def test_switching_takes_both_torques(results):
    switched, least, plain_torque = (
        results[f"torques {name}"] for name in ("modified-null-space-vector", "null-space-vector", "pseudoinverse")
    )
    is_least, is_plain = (np.isclose(switched, each, rtol=1e-9, atol=0).all(axis=1) for each in (least, plain_torque))
    assert np.all(is_least ^ is_plain)
    assert min(is_least.sum(), is_plain.sum()) > 10


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


# Near and at rank loss, in both modes


@both_modes
@pytest.mark.parametrize("smallest", SMALLEST)
def test_the_condition_of_the_matrix_is_not_squared_near_rank_loss(results, smallest):
    of_inverse, of_solution = results[f"near rank loss {smallest:g}"].T
    # Eq. (26) by itself would lose the square of the condition number: 1e-16 / smallest².
    assert 0.0 < of_inverse.max() < 1e-14 / smallest
    assert 0.0 < of_solution.max() < 1e-14 / smallest
    pairs = [nearly_singular(smallest, seed) for seed in range(len(of_inverse))]
    numpys = np.array([relative(np.linalg.pinv(A), expected) for A, expected in pairs])
    # No worse than numpy.linalg.pinv, but for a factor that a single rounding makes.
    assert np.all(of_inverse < 20.0 * numpys + 1e-14)


@both_modes
def test_pseudoinverse_is_bounded_at_rank_loss(results):
    for A, X, transposed in zip(
        kernel_checks.lost_matrices(), results["lost"], results["lost, transposed"], strict=True
    ):
        assert np.linalg.norm(X, 2) < 2.5
        np.testing.assert_allclose(A @ X @ A, A, rtol=0, atol=1e-13)
        np.testing.assert_allclose(transposed, X.T, rtol=0, atol=1e-13)


@both_modes
@pytest.mark.parametrize("name", controllers.available())
def test_torque_is_bounded_at_a_stretched_arm(results, name):
    assert np.abs(results[f"stretched {name}"]).max() < 1e3


# The two modes agree


@needs_numba
@pytest.mark.parametrize("label", VARIANTS)
def test_torques_of_the_two_modes_agree(plain, compiled, label):
    one, other = plain[f"torques {label}"], compiled[f"torques {label}"]
    assert one.shape == (COMPARED, 7)
    assert max(map(relative, other, one)) < 1e-10


@needs_numba
@pytest.mark.parametrize("name", kernel_checks.kernels())
def test_kernels_of_the_two_modes_agree(plain, compiled, name):
    one, other = plain[f"kernel {name}"], compiled[f"kernel {name}"]
    assert len(one) == COMPARED
    assert max(map(relative, other, one)) < 1e-10


@both_modes
def test_arrays_of_another_order_and_type_are_taken(results):
    # [1 2 0; 0 2 1]⁺ = Aᵀ(A Aᵀ)⁻¹ with A Aᵀ = [5 4; 4 5].
    expected = np.array([[5.0, -4.0], [2.0, 2.0], [-4.0, 5.0]]) / 9.0
    np.testing.assert_allclose(results["of another type"], expected, rtol=0, atol=1e-15)


@both_modes
def test_shapes_that_do_not_fit_are_refused(results):
    assert set(results["misfits"]) <= {"ValueError", "LinAlgError"}


# How little a tick does


@both_modes
@pytest.mark.parametrize("label", [label for label in VARIANTS if not label.startswith("qp")])
def test_a_tick_makes_few_calls(results, mode, label):
    resolves_velocities = VARIANTS[label][0] in ("jmdc", "resolved-motion")
    most = {"NumPy": (250, 300), "compiled": (70, 120)}[mode][resolves_velocities]
    assert 10 < results[f"calls {label}"] <= most


@needs_numba
@pytest.mark.parametrize("label", [label for label in VARIANTS if not label.startswith("qp")])
def test_a_compiled_tick_makes_fewer_calls(plain, compiled, label):
    assert compiled[f"calls {label}"] < 0.8 * plain[f"calls {label}"]


def test_a_tick_spawns_no_thread():
    if not sys.platform.startswith("linux"):
        pytest.skip("reads /proc")
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
for _ in range(10000):
    law.torque(q, v, target)
print(before == busy())
"""
    done = run_python(code)
    assert done.stdout.strip() == "True", done.stderr


# Compiled only where it is asked for


def test_no_law_imports_numba_by_itself():
    code = """
import sys, numpy as np
import aspect_control as ac
arm = ac.Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
q, v = np.full(7, 0.3), np.full(7, 0.1)
for name in ac.controllers.available():
    law = ac.controllers.create(name, arm)
    law.reset(q, v, 1e-3)
    law.torque(q, v, ac.Target(arm.task_position(q), np.zeros(3), np.ones(3)))
ac.simulate(law, ac.StraightLine([0.05, 0.0, 0.0], 0.01), q0=q)
print("numba" in sys.modules)
"""
    done = run_python(code)
    assert done.stdout.strip() == "False", done.stderr


def test_this_process_stays_plain_numpy(plain):
    assert not kernels_compiled()


@needs_numba
def test_no_tick_compiles_anything(compiled):
    ticks, asked = compiled["compiled in ticks"]
    assert (ticks, asked > 0) == (0, True)


def test_without_numba_it_says_what_to_install():
    code = """
import sys
sys.modules["numba"] = None  # what an import of a package that is not there ends in
import numpy as np
from aspect_control.redundancy import compile_kernels, kernels_compiled, pseudoinverse
try:
    compile_kernels()
except ImportError as error:
    print(error)
print(kernels_compiled(), pseudoinverse(np.array([[3.0, 4.0]])).ravel().round(12).tolist())
"""
    done = run_python(code)
    assert done.stdout.splitlines() == [
        "compile_kernels needs Numba: pip install 'aspect-control[fast]'",
        "False [0.12, 0.16]",
    ], done.stderr


@needs_numba
def test_kernels_compile_where_nothing_can_be_written():
    code = """
import numpy as np
from aspect_control.redundancy import pseudoinverse
pseudoinverse.compile()
print(pseudoinverse.is_compiled, pseudoinverse(np.array([[3.0, 4.0]])).ravel().round(12).tolist())
"""
    nowhere = os.devnull + "/there"
    done = run_python(code, NUMBA_CACHE_DIR=nowhere, XDG_CACHE_HOME=nowhere, HOME=nowhere)
    assert done.stdout.strip() == "True [0.12, 0.16]", done.stderr


@needs_numba
def test_kernels_of_a_module_that_is_imported_later_are_compiled_too(tmp_path):
    (tmp_path / "constants.py").write_text("FACTOR = 4.0\n")
    (tmp_path / "law.py").write_text(LAW.format(code="FACTOR * nle", docstring="A law."))
    code = """
from aspect_control.redundancy import compile_kernels, kernels_compiled
compile_kernels()
import aspect_control.controllers, law, numpy as np
print(kernels_compiled(), law.torque.is_compiled, law.torque(np.ones(2)).tolist())
"""
    paths = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    done = run_python(code, PYTHONPATH=paths)
    assert done.stdout.strip() == "True True [4.0, 4.0]", done.stderr


LAW = '''
from aspect_control.redundancy.kernels import kernel
from constants import FACTOR

@kernel
def torque(nle: "Vector") -> "Vector":
    """{docstring}"""
    return {code}
'''
TWICE = """
from aspect_control.redundancy.kernels import kernel

@kernel
def FACTOR(x: "Vector") -> "Vector":
    return {factor} * x
"""


@needs_numba
def test_machine_code_is_kept_for_the_code_and_not_for_its_docstring(tmp_path):
    place, kept = tmp_path / "package", tmp_path / "kept"
    place.mkdir()

    def run(code, constants="FACTOR = 3.0", docstring="A law."):
        for name, text in (("law.py", LAW.format(code=code, docstring=docstring)), ("constants.py", constants)):
            if not (place / name).exists() or (place / name).read_text() != text:
                (place / name).write_text(text)
        text = "import numpy as np, law; law.torque.compile(); print(law.torque(np.ones(2)).tolist())"
        paths = os.pathsep.join(filter(None, [str(place), os.environ.get("PYTHONPATH")]))
        done = run_python(text, PYTHONPATH=paths, NUMBA_CACHE_DIR=str(kept), PYTHONDONTWRITEBYTECODE="1")
        assert done.returncode == 0, done.stderr
        return done.stdout.strip(), {path.name for path in kept.iterdir()}

    result, first = run("2.0 * nle")
    assert (result, len(first)) == ("[2.0, 2.0]", 1)
    assert any(kept.rglob("*.nbi"))
    assert run("2.0 * nle", docstring="The same law, in better words.") == ("[2.0, 2.0]", first)
    result, second = run("FACTOR * nle")
    assert (result, len(second)) == ("[3.0, 3.0]", 2)
    # Numba looks neither at the file that a number comes from nor at that of a kernel which is called.
    result, third = run("FACTOR * nle", "FACTOR = 5.0")
    assert (result, len(third)) == ("[5.0, 5.0]", 3)
    assert run("FACTOR * nle", "FACTOR = 5.0") == (result, third)
    assert run("FACTOR(nle)", TWICE.format(factor=2))[0] == "[2.0, 2.0]"
    assert run("FACTOR(nle)", TWICE.format(factor=7))[0] == "[7.0, 7.0]"
