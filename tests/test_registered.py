"""What holds for everything registered, of every kind: laws, criteria, trajectories, events, integrators and plants."""

import copy
import inspect
import pickle
import re
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings

import aspect_control as ac
from aspect_control.controllers import Controller
from aspect_control.criteria import Criterion
from aspect_control.exceptions import ParameterError, UnknownNameError
from aspect_control.plants import Plant, RigidBodyPlant
from aspect_control.simulation import Event, Integrator, Sample
from garbage import anything, assert_works_or_is_refused

KINDS = {
    "controllers": ac.controllers,
    "criteria": ac.criteria,
    "trajectories": ac.trajectories,
    "events": ac.simulation.events,
    "integrators": ac.simulation.integrators,
    "plants": ac.plants,
}
NEEDED = {
    "force-compatibility": {"direction": [1.0, 0.0]},
    "velocity-compatibility": {"direction": [1.0, 0.0]},
    "potential": {"spheres": [{"centre": [1.5, 1.5, 0.0], "radius": 0.1}]},
    "circle": {"radius": 0.1, "duration": 1.0},
    "hold": {"duration": 1.0},
    "straight-line": {"displacement": [0.1, 0.2], "duration": 1.0},
    "waypoints": {"points": [[0.1, 0.2], [0.0, 0.3]], "duration": 1.0},
    "singular": {"manipulability": 0.1},
    "torque-limit": {"limit": 5.0},
}
"""Parameters for what cannot be made without."""

ARM = ac.Arm.from_example("planar3r", frame="tool", task="xy", gravity=(0.0, 0.0, 0.0))
Q, V, TAU = np.array([-0.9, 2.4, -2.3]), np.array([0.3, -0.2, 0.5]), np.array([1.0, -20.0, 3.0])
X = ARM.task_position(Q)
DT = 1e-3

UNIT = re.compile(r"(?<!\w)(rad|m|s|N m|J|kg|m²)(?!\w)|unit|dimensionless|0 to 1")


class Part(NamedTuple):
    """One class that is registered."""

    kind: str
    name: str

    @property
    def home(self):
        return KINDS[self.kind]

    @property
    def cls(self):
        return self.home.find(self.name)

    def create(self, **parameters):
        return self.home.create(self.name, ARM, **{**NEEDED.get(self.name, {}), **parameters})


PARTS = [Part(kind, name) for kind, home in KINDS.items() for name in home.available()]
every_part = pytest.mark.parametrize("part", PARTS, ids=lambda part: f"{part.kind}-{part.name}")


def what_it_does(made):
    """What an object computes: the numbers that a copy of it must give, too."""
    if isinstance(made, Controller):
        made.reset(Q, V, DT)
        return made.torque(Q, V, ac.Target(X + 1e-3, [0.1, 0.2], [0.3, -0.4]))
    if isinstance(made, Criterion):
        state = ARM.state(Q, V)
        return [made.value(state), *made.gradient(state)]
    if isinstance(made, ac.Trajectory):
        targets = [made.target(t, X) for t in (-1.0, 0.0, 0.2, 0.5, 0.9, 1.0, 2.0)]
        return [(target.x, target.dx, target.ddx) for target in targets] + [made.breakpoints, made.duration]
    if isinstance(made, Event):
        return [made.status, made.check(Sample(ARM, 0.5, Q, V, TAU, ac.Target(X + 1.0, [0.0, 0.0], [0.0, 0.0])))]
    if isinstance(made, Integrator):
        return made.step(RigidBodyPlant(ARM), Q, V, TAU, DT)
    assert isinstance(made, Plant)
    return [made.acceleration(Q, V, TAU), made.integrate(Q, DT * V)]


# What is registered, and under which name


def test_every_kind_has_something_registered():
    assert {part.kind for part in PARTS} == set(KINDS)


@every_part
def test_its_name_is_its_name_in_the_registry(part):
    assert part.cls.name == part.name
    assert part.create().name == part.name
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", part.name)


@every_part
def test_it_is_exported_where_its_kind_is_found(part):
    assert part.cls.__name__ in part.home.__all__
    assert getattr(part.home, part.cls.__name__) is part.cls


# Pickles and copies


@every_part
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))])
def test_a_copy_does_what_the_original_does(part, copied):
    made = part.create()
    again = copied(made)
    assert type(again) is type(made)
    np.testing.assert_equal(what_it_does(again), what_it_does(made))
    np.testing.assert_equal(what_it_does(copied(made)), what_it_does(made))  # when it has been used


# What its documentation says


def public_methods(cls):
    """The names and functions of the public methods and properties, and all that their docstrings say, bases' too."""
    for name, member in inspect.getmembers(cls, lambda each: inspect.isfunction(each) or isinstance(each, property)):
        if not name.startswith("_"):
            found = [vars(base)[name] for base in cls.__mro__ if name in vars(base)]
            yield name, getattr(member, "fget", member), "\n".join(each.__doc__ or "" for each in found)


@every_part
def test_its_first_line_says_what_it_is(part):
    text = inspect.cleandoc(part.cls.__doc__ or "").partition("\n")[0]
    assert text.endswith(".")
    assert "__doc__" in vars(part.cls)


@every_part
def test_its_parameters_are_described_and_listed_with_their_defaults(part):
    assert ("arm" in part.home.parameter_names(part.cls)) is False
    listed = part.home.describe_parameters(part.cls)
    for name in part.home.parameter_names(part.cls):
        assert re.search(rf"^ +{name}: \S", part.cls.__init__.__doc__, re.MULTILINE), name
        assert re.search(rf"(^|, ){name}(,| = |$)", listed)


@every_part
def test_its_methods_say_shapes_and_units(part):
    silent = set()
    for name, function, text in public_methods(part.cls):
        annotations = " ".join(map(str, inspect.get_annotations(function).values()))
        arrays = re.search(r"\b(Array|ArrayLike|TaskValue)\b", annotations)
        numbers = arrays or re.search(r"\bfloat\b", annotations)
        if not text or (arrays and "shape (" not in text) or (numbers and not UNIT.search(text)):
            silent.add(name)
    assert not silent


# What it refuses


@every_part
def test_it_is_made_for_an_arm_or_of_parameters_alone(part):
    for_arm = next(iter(inspect.signature(part.cls).parameters), None) == "arm"
    for nothing in ("planar3r", 3.0, [], ARM.model):
        with pytest.raises(ParameterError, match=re.escape(f"'{part.name}' is made ")):
            part.home.create(part.name, nothing, **NEEDED.get(part.name, {}))
    if for_arm:
        with pytest.raises(ParameterError, match=f"'{part.name}' is made for an Arm, got None"):
            part.home.create(part.name, **NEEDED.get(part.name, {}))
    else:
        assert isinstance(part.home.create(part.name, **NEEDED.get(part.name, {})), part.cls)


@every_part
def test_it_refuses_a_parameter_that_it_does_not_have(part):
    with pytest.raises(UnknownNameError, match=f"^unknown parameter 'no_such' in '{part.name}': available: "):
        part.create(no_such=1.0)


@every_part
def test_it_names_the_parameters_that_are_missing(part):
    needed = [name for name, each in inspect.signature(part.cls).parameters.items() if each.default is each.empty]
    needed = [name for name in needed if name != "arm"]
    if needed:
        with pytest.raises(
            ParameterError, match=f"^'{part.name}' needs {', '.join(map(repr, needed))}; its parameters"
        ):
            part.home.create(part.name, ARM)


@every_part
@settings(max_examples=25)
@given(value=anything)
def test_any_value_of_a_parameter_works_or_is_refused(part, value):
    for name in part.home.parameter_names(part.cls):
        assert_works_or_is_refused(lambda given, name=name: part.create(**{name: given}), value)


@pytest.mark.parametrize("part", [part for part in PARTS if part.kind == "trajectories"], ids=lambda part: part.name)
@settings(max_examples=25)
@given(value=anything)
def test_any_time_and_start_of_a_trajectory_work_or_are_refused(part, value):
    made = part.create()
    assert_works_or_is_refused(lambda given: made.target(given, X), value)
    assert_works_or_is_refused(lambda given: made.target(0.5, given), value)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=25)
@given(value=anything)
def test_any_name_works_or_is_refused(kind, value):
    assert_works_or_is_refused(KINDS[kind].find, value)
    assert_works_or_is_refused(lambda given: KINDS[kind].create(given, ARM), value)
