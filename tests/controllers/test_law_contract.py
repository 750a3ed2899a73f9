"""One contract a tick: what every registered law takes, refuses, remembers and hands on."""

import copy
import json
import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest

from aspect_control import Arm, Target, controllers, criteria
from aspect_control.controllers import TaskSpaceController
from aspect_control.exceptions import AspectControlError, NonFiniteError, ParameterError, ShapeError
from aspect_control.guard import Blend
from example_arms import example_arm

LAWS = (*controllers.available(), "blend")
DT = 1e-3
BAD_CALLS = 100_000

every_law = pytest.mark.parametrize("name", LAWS)


@pytest.fixture(scope="module")
def panda():
    return example_arm("panda", "xyz")


@pytest.fixture(scope="module")
def continuous():
    """An arm with continuous joints: q holds their cosine and sine."""
    return example_arm("kinova", "xyz")


def options(name):
    """Parameters that give a law as much to remember as it can."""
    chosen = {"modified-null-space-vector": {"switching": "dead-beat"}, "jmdc": {"kappa": 0.1}}
    return {"qp": {"torque_limit": 60.0, "stability": "dead-beat"}, **chosen}.get(name, {})


def two_laws(arm, **parameters):
    """What a blend goes between: both with as much to remember as they can have."""
    names = ("modified-null-space-vector", "jmdc")
    return tuple(controllers.create(name, arm, **{**options(name), **parameters}) for name in names)


class BlendOfArm(Blend):
    """A blend that is made for an arm, as other laws are, and soon under way."""

    def __init__(self, arm, **parameters):
        super().__init__(*two_laws(arm, **parameters), duration=0.02, switch_at=0.005)


def class_of(name):
    return BlendOfArm if name == "blend" else controllers.find(name)


def made(name, arm, **parameters):
    if name == "blend":
        return Blend(*two_laws(arm, **parameters), duration=0.02, switch_at=0.005)
    return controllers.create(name, arm, **parameters)


def motion(arm, count, seed=0):
    """States and targets along a smooth motion, as a loop would measure them."""
    rng = np.random.default_rng(seed)
    middle, speed = rng.uniform(-0.8, 0.8, arm.nv), rng.uniform(-1.5, 1.5, arm.nv)
    for i in range(count):
        q = arm.configuration(middle + speed * i * DT)
        x = arm.task_position(q)
        yield q, speed + 0.01 * rng.normal(size=arm.nv), Target(x + 1e-3, rng.normal(size=3), rng.normal(size=3))


def started(name, arm, **parameters):
    law = made(name, arm, **{**options(name), **parameters})
    q, v, _ = next(motion(arm, 1))
    law.reset(q, v, DT)
    return law


def arrays_of(owner):
    """The public arrays of a law or an arm: gains and limits."""
    for name in dir(type(owner)) + list(vars(owner)):
        if not name.startswith("_") and name != "memory":
            value = getattr(owner, name)
            for each in value if isinstance(value, tuple) else (value,):
                if isinstance(each, np.ndarray):
                    yield name, each


# What is taken, and what is refused


def layouts(vector):
    """The same numbers in other types and memory orders."""
    wide = np.zeros((len(vector), 2))
    wide[:, 0] = vector
    read_only = vector.copy()
    read_only.setflags(write=False)
    return {
        "big-endian": vector.astype(">f8"),
        "strided": wide[:, 0],
        "reversed": vector[::-1].copy()[::-1],
        "read-only": read_only,
        "long double": vector.astype(np.longdouble),
        "list": vector.tolist(),
        "tuple of scalars": tuple(vector),
        "float32": vector.astype(np.float32),
        "integers": np.round(vector).astype(np.int64),
        "small integers": np.round(vector).astype(np.int8),
    }


@every_law
def test_any_dtype_and_layout_gives_the_torque_of_the_plain_array(panda, name):
    q, v, target = next(motion(panda, 1))
    for given_q, given_v in zip(layouts(q).values(), layouts(v).values(), strict=True):
        one, other = started(name, panda), started(name, panda)
        plain = np.array(given_q, dtype=np.float64), np.array(given_v, dtype=np.float64)
        for _ in range(3):
            tau = one.torque(given_q, given_v, target)
            np.testing.assert_array_equal(tau, other.torque(*plain, target))
            assert (tau.dtype, tau.shape, tau.dtype.isnative) == (np.float64, (7,), True)


@every_law
def test_what_is_no_vector_of_real_numbers_is_refused(panda, name):
    law, (q, v, target) = started(name, panda), next(motion(panda, 1))
    masked = np.ma.masked_array(q, mask=np.arange(7) == 3)
    for bad in (
        q.astype(complex),
        q > 0.0,
        [True] * 7,
        [*q[:6], True],
        masked,
        q[:, None],
        q[None],
        q[:6],
        q.astype(str),
        q.astype(object),
        [10**400] * 7,
        "home",
        None,
        {1: 2},
        3.0,
        np.array("2020-01-01", dtype="datetime64[D]"),
        np.zeros(7, dtype=[("a", float)]),
    ):
        for arguments, which in (((bad, v), "q"), ((q, bad), "v")):
            with pytest.raises(ShapeError, match=rf"^{which} must (be a vector of numbers|have shape \(7,\)), got"):
                law.torque(*arguments, target)


@every_law
@pytest.mark.parametrize("entry", [np.nan, np.inf, -np.inf, 1e51, -1e200, 1e308])
def test_what_is_not_finite_or_no_number_of_an_arm_is_refused(panda, name, entry):
    law, (q, v, target) = started(name, panda), next(motion(panda, 1))
    for i in (0, 6):
        bad = q.copy()
        bad[i] = entry
        with pytest.raises(NonFiniteError, match=r"^q must be (finite|at most 1e\+50)"):
            law.torque(bad, v, target)
        with pytest.raises(NonFiniteError, match=r"^v must be (finite|at most 1e\+50)"):
            law.torque(q, bad, target)


@every_law
def test_a_target_that_is_none_is_refused(panda, name):
    law, (q, v, target) = started(name, panda), next(motion(panda, 1))
    for bad in (None, 3.0, q[:3], (target.x, target.dx, target.ddx)):
        with pytest.raises(ParameterError, match=r"target must be a Target\(x, dx, ddx\), got"):
            law.torque(q, v, bad)
    with pytest.raises(ShapeError, match="must have an array as x and 3 rates"):
        law.torque(q, v, Target(np.zeros(2), np.zeros(2), np.zeros(2)))


@every_law
@pytest.mark.filterwarnings("ignore::aspect_control.exceptions.AspectBorderWarning")
def test_cosine_and_sine_have_length_one(continuous, name):
    law = made(name, continuous, **options(name))
    q, v, target = next(motion(continuous, 1))
    law.reset(q, v, DT)
    assert np.isfinite(law.torque(q, v, target)).all()
    joint = next(i for i in range(continuous.nv) if continuous.model.joints[i + 1].nq == 2)
    first = continuous.model.joints[joint + 1].idx_q
    for factor in (0.5, 1.01, -3.0, 1e48):
        bad = q.copy()
        bad[first : first + 2] *= factor
        with pytest.raises(ParameterError, match="cosine and sine of each continuous joint, which must have length 1"):
            law.torque(bad, v, target)
    bad = q.copy()
    bad[first] = 1e200
    with pytest.raises(NonFiniteError):
        law.torque(bad, v, target)


# What a law raises


class Broken(Exception):
    """What a law of somebody's raises."""


@every_law
@pytest.mark.parametrize("error", [Broken("mine"), np.linalg.LinAlgError("mine"), FloatingPointError("mine")])
def test_an_exception_in_command_reaches_the_caller_once_and_unchanged(panda, name, error):
    calls = []

    class Raising(class_of(name)):
        def command(self, state, target):
            calls.append(super().command(state, target))
            raise error

    law, (q, v, target) = Raising(panda, **options(name)), next(motion(panda, 1))
    law.reset(q, v, DT)
    with pytest.raises(type(error)) as caught:
        law.torque(q, v, target)
    assert caught.value is error
    assert len(calls) == 1


class Stubborn(criteria.Manipulability):
    """A criterion that raises whenever it is told to."""

    told = False

    def gradient(self, state):
        if self.told:
            raise Broken("criterion")
        return super().gradient(state)


@pytest.mark.parametrize("name", ["jmdc", "resolved-motion"])
def test_an_exception_in_a_criterion_reaches_the_caller_and_leaves_no_trace(panda, name):
    stubborn = Stubborn(panda)
    law, twin = started(name, panda, criterion=stubborn), started(name, panda, criterion=criteria.Manipulability(panda))
    for q, v, target in motion(panda, 5):
        stubborn.told = True
        with pytest.raises(Broken, match=r"^criterion$"):
            law.torque(q, v, target)
        stubborn.told = False
        np.testing.assert_array_equal(law.torque(q, v, target), twin.torque(q, v, target))


@every_law
@pytest.mark.parametrize(
    ("result", "error"),
    [
        (np.full(7, np.nan), NonFiniteError),
        (np.array([0.0] * 6 + [np.inf]), NonFiniteError),
        (np.zeros(6), ShapeError),
        (np.zeros((7, 1)), ShapeError),
        (None, (ShapeError, NonFiniteError)),
        ("strong", ShapeError),
    ],
)
def test_a_law_that_returns_no_torque_is_told_so(panda, name, result, error):
    class Wrong(class_of(name)):
        def command(self, state, target):
            super().command(state, target)
            return result

    law, (q, v, target) = Wrong(panda, **options(name)), next(motion(panda, 1))
    law.reset(q, v, DT)
    memory = law.memory
    with pytest.raises(error, match=f"^{name}: "):
        law.torque(q, v, target)
    assert law.memory is memory


# A refused call leaves no trace


def bad_calls(arm, rng, good):
    """Calls that are refused, without end: a q, a v and a target of which at least one is wrong."""
    q, v, target = good
    wrong_targets = (None, Target(np.zeros(2), np.zeros(2), np.zeros(2)), 3.0)
    while True:
        index, entry = rng.integers(arm.nq), (np.nan, np.inf, 1e60, -1e300)[rng.integers(4)]
        bad = q.copy()
        bad[index] = entry
        kinds = (
            (bad, v, target),
            (q, bad, target),
            (rng.normal(size=rng.integers(0, 7)), v, target),
            (q, rng.normal(size=(7, 1)), target),
            (rng.normal(size=7), rng.normal(size=7), wrong_targets[rng.integers(3)]),
            (q.astype(complex), v, target),
            (q > 0.0, v, target),
            (None, v, target),
        )
        yield kinds[rng.integers(len(kinds))]


@every_law
def test_refused_calls_leave_no_trace(panda, name):
    rng = np.random.default_rng(7)
    law, twin = started(name, panda), started(name, panda)
    samples = 100
    share = BAD_CALLS // (len(LAWS) * samples) + 1
    for good in motion(panda, samples):
        refused = bad_calls(panda, rng, good)
        for _ in range(share):
            with pytest.raises(AspectControlError):
                law.torque(*next(refused))
        for bad in (
            (good[0], good[1], 0.0),
            (good[0], good[1], np.nan),
            (None, good[1], DT),
            (good[0], [1e99] * 7, DT),
        ):
            with pytest.raises(AspectControlError):
                law.reset(*bad)
        np.testing.assert_array_equal(law.torque(*good), twin.torque(*good))


@every_law
def test_a_torque_that_is_refused_leaves_no_trace(panda, name):
    """Gains so high that the torque overflows where the error is large, and works where it is not."""
    law, twin = (started(name, panda, kp=1e49, kv=1e49) for _ in range(2))
    for q, v, _ in motion(panda, 20):
        calm = Target(panda.task_position(q), panda.jacobian(q) @ v, np.zeros(3))
        far = Target(np.full(3, 1e49), np.full(3, -1e49), np.full(3, 1e49))
        before = law.memory
        try:
            law.torque(q, v, far)
        except AspectControlError:
            assert law.memory is before
            np.testing.assert_array_equal(law.torque(q, v, calm), twin.torque(q, v, calm))
        else:
            twin.torque(q, v, far)


# Copies are the same law


def copies(law):
    yield "pickle", pickle.loads(pickle.dumps(law))
    yield "deepcopy", copy.deepcopy(law)


@every_law
@pytest.mark.parametrize("begun", [0, 1, 25])
def test_a_copy_gives_the_same_torque_to_the_last_bit(panda, name, begun):
    law, samples = started(name, panda), list(motion(panda, 60))
    for sample in samples[:begun]:
        law.torque(*sample)
    twins = dict(copies(law))
    for sample in samples[begun:]:
        expected = law.torque(*sample)
        for kind, twin in twins.items():
            np.testing.assert_array_equal(twin.torque(*sample), expected, err_msg=kind)
    for kind, twin in twins.items():
        assert twin.parameters == law.parameters, kind
        for name, array in arrays_of(twin):
            assert not array.flags.writeable, f"{kind}: {name}"


def test_laws_in_a_spawned_process_give_the_same_torques_to_the_last_bit(panda, tmp_path):
    samples = list(motion(panda, 40))
    laws = {f"{name} {begun}": started(name, panda) for name in LAWS for begun in (0, 12)}
    for key, law in laws.items():
        for sample in samples[: int(key.split()[1])]:
            law.torque(*sample)
    plain = [(q, v, (target.x, target.dx, target.ddx)) for q, v, target in samples]
    (tmp_path / "laws").write_bytes(pickle.dumps((laws, plain)))
    code = """
import pathlib, pickle, sys
import aspect_control as ac
laws, samples = pickle.loads(pathlib.Path(sys.argv[1]).read_bytes())
taus = {}
for key, law in laws.items():
    begun = int(key.split()[1])
    taus[key] = [law.torque(q, v, ac.Target(*target)) for q, v, target in samples[begun:]]
pathlib.Path(sys.argv[2]).write_bytes(pickle.dumps(taus))
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "laws"), str(tmp_path / "taus")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    there = pickle.loads((tmp_path / "taus").read_bytes())
    for key, law in laws.items():
        here = [law.torque(*sample) for sample in samples[int(key.split()[1]) :]]
        np.testing.assert_array_equal(there[key], here, err_msg=key)


# What is recorded is what counts


@every_law
def test_parameters_are_fixed_when_a_law_is_made(panda, name):
    law = started(name, panda)
    recorded = json.dumps(law.parameters)
    for parameter in law.parameters:
        with pytest.raises(AttributeError):
            setattr(law, parameter, 1.0)
    assert json.dumps(law.parameters) == recorded
    assert {"kp", "kv"} <= {name for name, _ in arrays_of(law)}
    for _, array in arrays_of(law):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


@pytest.mark.parametrize("name", controllers.available())
def test_a_law_made_again_of_its_parameters_is_the_same_law(panda, name):
    law = started(name, panda)
    again = controllers.create(name, panda, **json.loads(json.dumps(law.parameters)))
    q, v, _ = next(motion(panda, 1))
    again.reset(q, v, DT)
    for sample in motion(panda, 10):
        np.testing.assert_array_equal(again.torque(*sample), law.torque(*sample))


@pytest.mark.parametrize("name", [name for name in LAWS if issubclass(class_of(name), TaskSpaceController)])
def test_an_override_of_the_commanded_acceleration_counts(panda, name):
    class Doubled(controllers.find(name)):
        def commanded_acceleration(self, state, target):
            return super().commanded_acceleration(state, target) + 1.0

    plain, doubled = (law(panda, **options(name)) for law in (controllers.find(name), Doubled))
    for q, v, target in motion(panda, 3):
        shifted = Target(target.x, target.dx, target.ddx + 1.0)
        for law in (plain, doubled):
            law.reset(q, v, DT)
        np.testing.assert_allclose(
            doubled.torque(q, v, target), plain.torque(q, v, shifted), rtol=1e-9, atol=1e-9, err_msg=name
        )


# The state


@pytest.mark.parametrize("task", ["xyz", "pose", ("x", "z"), ("y", "rz")])
def test_arrays_of_a_state_are_read_only_and_its_own(task):
    arm = example_arm("panda", task)
    q, v, _ = next(motion(example_arm("panda", "xyz"), 1))
    state = arm.state(q, v)
    arrays = {name: value for name, value in state._asdict().items() if isinstance(value, np.ndarray)}
    assert {"q", "v", "M", "nle", "J", "drift"} <= set(arrays)
    kept = {name: value.copy() for name, value in arrays.items()}
    for name, array in arrays.items():
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
        assert array.dtype == np.float64, name
        assert array.flags.c_contiguous, name
    arm.state(q + 0.3, v - 0.2)
    arm.jacobian_derivative(q - 0.5)
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, kept[name], err_msg=name)


def test_limits_of_an_arm_are_read_only(panda):
    again = pickle.loads(pickle.dumps(panda))
    for arm in (panda, again, copy.deepcopy(panda)):
        found = dict(arrays_of(arm))
        assert {"torque_limit", "velocity_limit", "position_limits", "minor_columns", "minor_scales"} <= set(found)
        for name in set(found) - {"gravity"}:
            assert not found[name].flags.writeable, name


def test_nothing_computed_before_changes_what_is_computed(panda):
    q, v, _ = next(motion(panda, 1))
    elsewhere = q + 0.4
    state = panda.state(q, v)
    fresh = {
        "jacobian_derivative": Arm.from_description(panda.description).jacobian_derivative(q),
        "task_position": Arm.from_description(panda.description).task_position(q),
    }
    for disturb in (
        lambda: panda.skeleton_jacobians(elsewhere),
        lambda: panda.skeleton(elsewhere),
        lambda: panda.jacobian(elsewhere),
        lambda: panda.state(elsewhere, v),
        lambda: panda.task_position(elsewhere),
    ):
        disturb()
        np.testing.assert_array_equal(panda.jacobian_derivative(state.q), fresh["jacobian_derivative"])
        disturb()
        np.testing.assert_array_equal(panda.task_position(state.q), fresh["task_position"])


def test_a_warning_that_is_an_error_refuses_the_reset(planar):
    """A start on a border of an aspect is a warning; where warnings are errors, the law is as it was."""
    law, twin = controllers.create("jmdc", planar), controllers.create("jmdc", planar)
    inside, border = np.array([0.3, 0.4, 0.5]), np.array([0.3, 0.4, 0.0])
    for each in (law, twin):
        each.reset(inside, np.zeros(3), DT)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning):
            law.reset(border, np.zeros(3), DT)
    target = Target(planar.task_position(inside), np.ones(2), np.zeros(2))
    for _ in range(3):
        np.testing.assert_array_equal(law.torque(inside, np.zeros(3), target), twin.torque(inside, np.zeros(3), target))
