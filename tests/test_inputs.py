"""What a caller may hand in by mistake, everywhere a number, a name, a text or a path is taken: one clear error."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from aspect_control import (
    Arm,
    Circle,
    Hold,
    Run,
    StraightLine,
    Waypoints,
    controllers,
    criteria,
    plants,
    simulate,
    simulation,
    trajectories,
)
from aspect_control.aspects import JointSlice, choose_start, compute_atlas
from aspect_control.checks import finite_number, known_name, non_negative, positive, unicode_text, whole_number
from aspect_control.exceptions import (
    ControllerNotFoundError,
    CriterionNotFoundError,
    FrameNotFoundError,
    JointNotFoundError,
    ModelError,
    OutputError,
    ParameterError,
    RunFileError,
    ScenarioError,
    ShapeError,
    TaskError,
    UnknownNameError,
    shown,
)
from aspect_control.files import output_folder, write_text
from aspect_control.resources import model_path
from aspect_control.scenario import load_scenario
from aspect_control.simulation import Diverged, Singular, TorqueLimit, TrackingLost
from aspect_control.views import animate, replay, run_figure, save_figure
from garbage import BEYOND_FLOATS, Unprintable, anything, assert_works_or_is_refused, nested

PATH = model_path("planar3r.urdf")
START = (0.1, 0.5, 0.7)
UNHASHABLE = [[], {}, set(), np.zeros(2), Unprintable()]
NO_FILE = ["a\0b", "\ud800", "", 3, None, b"run.npz", [], {}, np.zeros(2)]


def planar(**changes):
    return Arm.from_urdf(PATH, **({"frame": "tool", "task": "xy", "gravity": (0, 0, 0)} | changes))


def law():
    return controllers.create("pseudoinverse", planar())


def short_run(**changes):
    return simulate(law(), StraightLine([0.1, 0.1], 0.1), q0=START, **({"dt": 0.05} | changes))


@pytest.fixture(scope="module")
def run():
    return short_run()


# Numbers

NUMBERS = {
    "Circle(radius=)": lambda value: Circle(value, 1.0),
    "Circle(duration=)": lambda value: Circle(1.0, value),
    "Circle(turns=)": lambda value: Circle(1.0, 1.0, turns=value),
    "Hold(duration=)": Hold,
    "StraightLine(duration=)": lambda value: StraightLine([1.0, 1.0], value),
    "Waypoints(duration=)": lambda value: Waypoints([[1.0, 1.0]], value),
    "Diverged": Diverged,
    "TrackingLost": TrackingLost,
    "Singular": Singular,
    "dt": lambda value: short_run(dt=value),
    "locked": lambda value: planar(locked={"joint1": value}),
    "controller.kappa": lambda value: controllers.create("resolved-motion", planar(), kappa=value),
    "t": lambda value: StraightLine([1.0, 1.0], 1.0).target(value, np.zeros(2)),
}
ARRAYS = {
    "TorqueLimit": TorqueLimit,
    "saturation": lambda value: short_run(saturation=value),
    "Waypoints(points=)": lambda value: Waypoints([[value, 1.0]], 1.0),
}


@pytest.mark.parametrize("number", BEYOND_FLOATS, ids=["10^400", "-10^400", "10^5000", "fraction"])
@pytest.mark.parametrize("call", NUMBERS.values(), ids=NUMBERS)
def test_a_number_beyond_the_floats_is_refused(call, number):
    with pytest.raises(ParameterError, match=r"must be a finite number"):
        call(number)


@pytest.mark.parametrize("call", ARRAYS.values(), ids=ARRAYS)
def test_a_number_beyond_the_floats_in_an_array_is_refused(call):
    with pytest.raises(ShapeError, match=r"of (3 )?numbers, got \[*1000"):
        call(10**400)


@pytest.mark.parametrize("check", [finite_number, positive, non_negative])
def test_the_error_of_a_number_has_what_was_given_and_what_was_expected(check):
    with pytest.raises(ParameterError, match=r"^speed must be a finite number.*, got '3'$"):
        check("speed", "3")


@pytest.mark.parametrize("value", [2.0, True, "2", None, [2], 10**5000, -1], ids=shown)
def test_a_whole_number_of_a_range_is_an_integer_in_it(value):
    with pytest.raises(ParameterError, match="samples must be a whole number of at"):
        whole_number("samples", value, 1, 100)
    assert whole_number("samples", np.int64(100), 1, 100) == 100


def test_more_postures_than_anybody_waits_for_are_refused():
    arm, q = planar(), np.array(START)
    with pytest.raises(ParameterError, match=r"count must be a whole number of at most 1,000,000, got 1000"):
        choose_start(arm, arm.task_position(q), reference=q, count=10**400)
    with pytest.raises(ParameterError, match="does not fit into memory"):
        compute_atlas(JointSlice(arm, q, ("joint1", "joint2")), 10**5000)


@pytest.mark.parametrize("turns", [1e300, -1e300, 1e155])
def test_a_circle_without_a_finite_acceleration_is_refused(turns):
    with pytest.raises(ParameterError, match=r"finite acceleration, got turns="):
        Circle(1.0, 1.0, turns=turns)


# Names

NAMES = {
    "controllers.create": (lambda name: controllers.create(name, planar()), ControllerNotFoundError),
    "controllers.find": (controllers.find, ControllerNotFoundError),
    "criteria.create": (lambda name: criteria.create(name, planar()), CriterionNotFoundError),
    "frame": (lambda name: planar(frame=name), FrameNotFoundError),
    "task": (lambda name: planar(task=name), TaskError),
    "example": (lambda name: Arm.from_example(name, frame="tool", task="xy"), UnknownNameError),
    "profile": (lambda name: StraightLine([1.0, 1.0], 1.0, profile=name), UnknownNameError),
    "circle's profile": (lambda name: Circle(1.0, 1.0, profile=name), UnknownNameError),
    "plane": (lambda name: Circle(1.0, 1.0, plane=name), UnknownNameError),
    "trajectories.create": (trajectories.create, UnknownNameError),
    "events.create": (simulation.events.create, UnknownNameError),
    "integrators.create": (simulation.integrators.create, UnknownNameError),
    "plants.create": (lambda name: plants.create(name, planar()), UnknownNameError),
    "joint": (lambda name: JointSlice(planar(), START, ("joint1", name)), JointNotFoundError),
    "model_path": (model_path, ModelError),
}


@pytest.mark.parametrize("name", [*UNHASHABLE, None, 3, b"jmdc", "jmdc\0", "\ud800"], ids=shown)
@pytest.mark.parametrize(("call", "error"), NAMES.values(), ids=NAMES)
def test_what_is_no_name_is_unknown(call, error, name):
    with pytest.raises(error, match=re.escape(shown(name))):
        call(name)


def test_the_error_of_a_name_lists_those_that_exist():
    with pytest.raises(
        UnknownNameError, match=r"^unknown plane \['xy'\]: did you mean 'xy'\? available: 'xy', 'yz'$"
    ) as raised:
        known_name(["xy"], ("xy", "yz"), "plane")
    assert raised.value.name == ["xy"]
    assert raised.value.available == ("xy", "yz")


def test_a_law_is_made_for_an_arm():
    for create, name in ((controllers.create, "jmdc"), (criteria.create, "manipulability")):
        with pytest.raises(ParameterError, match=f"'{name}' is made for an Arm, got 'panda'"):
            create(name, "panda")


def test_a_criterion_has_parameters_by_name():
    with pytest.raises(ParameterError, match=r"names alone as keys, got \{'name': 'joint-range', 3: 1\}"):
        criteria.make(planar(), {"name": "joint-range", 3: 1})


# Paths and texts

READ = {
    "Arm.from_urdf": (lambda path: Arm.from_urdf(path, frame="tool", task="xy"), ModelError),
    "Run.load": (Run.load, RunFileError),
    "load_scenario": (load_scenario, ScenarioError),
    "output_folder": (output_folder, OutputError),
    "write_text": (lambda path: write_text(path, "text"), OutputError),
}


@pytest.mark.parametrize("path", NO_FILE, ids=shown)
@pytest.mark.parametrize(("call", "error"), READ.values(), ids=READ)
def test_what_is_no_path_is_refused(call, error, path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if call is output_folder and isinstance(path, str) and not path:
        return  # the present folder
    with pytest.raises(error):
        call(path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["a\0b.html", "\ud800.html", 3, []], ids=shown)
def test_what_is_no_path_is_not_written_to(run, path):
    figure = run_figure(run, "title")
    for write in (run.save, lambda path: replay(run, path), lambda path: save_figure(figure, path)):
        with pytest.raises(OutputError, match=re.escape(shown(path))):
            write(path)
    with pytest.raises(OutputError, match=re.escape(shown(path))):
        animate(run, path)


@pytest.mark.parametrize("name", ["figure", "figure.dog", ".png"])
def test_a_figure_has_a_suffix_that_names_its_format(run, tmp_path, name):
    with pytest.raises(UnknownNameError, match="unknown format of a figure"):
        save_figure(run_figure(run, "title"), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_file_whose_name_is_no_unicode_can_be_written_and_read(run, tmp_path):
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/run\xff.npz"))
    run.save(path)
    assert Run.load(path) == run


@pytest.mark.parametrize("text", ["a\0b", "a\ud800b", "\udc80"], ids=ascii)
def test_a_text_that_no_file_can_hold_is_refused(text, tmp_path):
    with pytest.raises(ParameterError, match="note must be text without the character"):
        unicode_text("note", text)
    with pytest.raises(ModelError, match="the given text must be text without the character"):
        Arm.from_urdf_text(PATH.read_text().replace("planar3r", text), frame="tool", task="xy")
    with pytest.raises(OutputError, match="without the character"):
        write_text(tmp_path / "report.md", text)
    with pytest.raises(ScenarioError, match="a setting must be text without the character"):
        load_scenario("planar3r", [f"robot.frame={text}"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", [None, 3, b"<robot/>", []])
def test_a_urdf_is_a_text(text):
    with pytest.raises(ModelError, match="the given text must be text, got"):
        Arm.from_urdf_text(text, frame="tool", task="xy")


@pytest.mark.parametrize("folders", [3, "meshes", b"meshes", {}, {"meshes"}, [3], [None], ["a\0b"], ["\ud800"], [[]]])
def test_package_dirs_are_a_list_of_folders(folders):
    with pytest.raises(ParameterError, match=r"package_dirs must be a list of folders, got|a folder must be"):
        planar(package_dirs=folders)


# Scenarios


def test_toml_that_is_nested_20000_deep_is_refused(tmp_path):
    (tmp_path / "deep.toml").write_text(f"a = {'[' * 20_000}{']' * 20_000}")
    with pytest.raises(ScenarioError, match=r"deep\.toml is not valid TOML: it is nested too deep"):
        load_scenario(tmp_path / "deep.toml")


@pytest.mark.parametrize(
    "setting",
    [f"start.positions={'[' * 100}{']' * 100}", f"{'a.' * 20_000}b=1", f"controller.kp={{{'a.' * 20_000}b=1}}"],
    ids=["list", "key", "value"],
)
def test_a_setting_that_is_nested_deep_is_refused(setting):
    with pytest.raises(ScenarioError, match="planar3r is nested more than 32 levels deep"):
        load_scenario("planar3r", [setting])


def test_a_setting_nested_deeper_than_can_be_parsed_is_a_text():
    with pytest.raises(ScenarioError, match=r"start\.positions: Input should be a valid list, got '\[\[\["):
        load_scenario("planar3r", [f"start.positions={'[' * 20_000}"])


def test_a_number_of_too_many_digits_is_refused(tmp_path):
    (tmp_path / "long.toml").write_text(f"a = {'1' * 5000}")
    with pytest.raises(ScenarioError, match=r"long\.toml is not valid TOML"):
        load_scenario(tmp_path / "long.toml")


@pytest.mark.parametrize("settings", ["robot.task=xy", None, 3, [3], [None], {"robot.task": "xy"}])
def test_settings_are_a_list_of_texts(settings):
    with pytest.raises(ScenarioError, match=r"settings must be a list of field=value, got|a setting must be text"):
        load_scenario("planar3r", settings)


# Anything

PARAMETERS = {
    "from_urdf(path)": lambda value: Arm.from_urdf(value, frame="tool", task="xy"),
    "from_urdf(frame=)": lambda value: planar(frame=value),
    "from_urdf(task=)": lambda value: planar(task=value),
    "from_urdf(task=[])": lambda value: planar(task=["x", value]),
    "from_urdf(locked=)": lambda value: planar(locked=value),
    "from_urdf(locked={})": lambda value: planar(locked={"joint1": value}),
    "from_urdf(package_dirs=)": lambda value: planar(package_dirs=value),
    "from_urdf(package_dirs=[])": lambda value: planar(package_dirs=[value]),
    "from_urdf_text(text)": lambda value: Arm.from_urdf_text(value, frame="tool", task="xy"),
    "from_example(name)": lambda value: Arm.from_example(value, frame="tool", task="xy"),
    "from_example(frame=)": lambda value: Arm.from_example("planar3r", frame=value, task="xy"),
    "from_pinocchio(model)": lambda value: Arm.from_pinocchio(value, frame="tool", task="xy"),
    "controllers.create(name)": lambda value: controllers.create(value, planar()),
    "controllers.create(arm)": lambda value: controllers.create("jmdc", value),
    "criteria.create(name)": lambda value: criteria.create(value, planar()),
    "criteria.create(arm)": lambda value: criteria.create("manipulability", value),
    "criteria.make": lambda value: criteria.make(planar(), value),
    "Run.load": Run.load,
    "load_scenario(path)": load_scenario,
    "load_scenario(settings)": lambda value: load_scenario("planar3r", value),
    "load_scenario([setting])": lambda value: load_scenario("planar3r", [value]),
    "Circle(plane=)": lambda value: Circle(1.0, 1.0, plane=value),
    "Circle(profile=)": lambda value: Circle(1.0, 1.0, profile=value),
    "StraightLine(profile=)": lambda value: StraightLine([1.0, 1.0], 1.0, profile=value),
    "Waypoints(points)": lambda value: Waypoints(value, 1.0),
    "simulate(integrator=)": lambda value: short_run(integrator=value),
    "simulate(plant=)": lambda value: short_run(plant=value),
    "simulate(events=)": lambda value: short_run(events=value),
    "simulate(events=[...])": lambda value: short_run(events=[value]),
    **{name: NUMBERS[name] for name in NUMBERS if name != "t"},
    "TorqueLimit": TorqueLimit,
    "simulate(saturation=)": lambda value: short_run(saturation=value),
}


@pytest.mark.parametrize("call", PARAMETERS.values(), ids=PARAMETERS)
@given(value=anything)
def test_anything_works_or_is_refused(call, value):
    assert_works_or_is_refused(call, value)


@given(value=anything)
def test_anything_can_be_shown_in_an_error(value):
    text = shown(value)
    assert 0 < len(text) <= 203
    assert text.isprintable()


def test_what_cannot_be_shown_is_named_by_its_type():
    assert shown(10**5000) == "a value of type int"
    assert shown(nested(10**5)) == "a value of type list"
    assert shown("x" * 1000) == f"'{'x' * 199}..."
    assert shown([1.5, "a"]) == "[1.5, 'a']"


@pytest.mark.parametrize("axis", [*UNHASHABLE, None, 3, "w", "x"], ids=shown)
def test_what_is_no_coordinate_is_no_part_of_a_task(axis):
    with pytest.raises(TaskError, match="unknown task"):
        planar(task=["x", axis])


@pytest.mark.parametrize("value", [3, None, "jmdc", controllers.Pseudoinverse])
def test_a_run_is_of_a_law_and_a_trajectory(value):
    arm = Arm.from_example("planar3r", frame="tool", task="xy")
    law, line = controllers.Pseudoinverse(arm), StraightLine([0.1, 0.0], 0.1)
    with pytest.raises(ParameterError, match="controller must be a Controller, got"):
        simulate(value, line, q0=[0.3, 0.4, 0.5])
    with pytest.raises(ParameterError, match="trajectory must be a Trajectory, got"):
        simulate(law, value, q0=[0.3, 0.4, 0.5])


@pytest.mark.parametrize("name", ["progress", "watch"])
def test_what_is_called_is_a_function(name):
    arm = Arm.from_example("planar3r", frame="tool", task="xy")
    with pytest.raises(ParameterError, match=f"{name} must be a function or None, got 3"):
        simulate(controllers.Pseudoinverse(arm), StraightLine([0.1, 0.0], 0.1), q0=[0.3, 0.4, 0.5], **{name: 3})


def test_a_switching_is_a_name():
    arm = Arm.from_example("planar3r", frame="tool", task="xy")
    for bad in (np.zeros(2), [], None, "soft"):
        with pytest.raises(UnknownNameError, match="unknown switching"):
            controllers.ModifiedNullSpaceVector(arm, switching=bad)
