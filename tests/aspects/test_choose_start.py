"""Choosing a start: against a search of the closed form, on real arms, on the command line."""

import json
import sys
import warnings

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.cli import main
from aspect_control.exceptions import AspectControlError, ParameterError, UnknownNameError, UnreachableError
from example_arms import example_arm
from oracles.planar_reference import minor_measure as planar_minor_measure
from oracles.planar_reference import position, postures

READY = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
PAPER = np.deg2rad([-50.0, 140.0, -140.0])
READY_SETTING = f"start.positions={READY.tolist()}"


@pytest.fixture
def start(monkeypatch, capsys):
    """The command in this process: exit status, standard output and standard error."""
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["aspect-control", "start", *map(str, arguments)])
        with pytest.raises(SystemExit) as raised:
            main()
        return raised.value.code or 0, *capsys.readouterr()

    return run


@pytest.fixture(scope="module")
def planar_start(planar):
    return ac.aspects.choose_start(planar, position(PAPER), reference=PAPER)


@pytest.fixture(scope="module")
def panda_start():
    arm = example_arm("panda", "pose")
    return ac.aspects.choose_start(arm, arm.task_position(READY), reference=READY)


def test_planar_start_is_the_best_of_the_closed_form(planar_start):
    x = position(PAPER)
    grid = np.linspace(-np.pi, np.pi, 40_001)
    best = max(planar_minor_measure(each) for first in grid for each in postures(x, first))
    assert planar_start.value == pytest.approx(best, abs=1e-7)
    assert planar_start.value >= best - 1e-12
    assert planar_start.value == pytest.approx(planar_minor_measure(planar_start.q), rel=1e-12)
    assert planar_start.reference_value == pytest.approx(planar_minor_measure(PAPER), rel=1e-12)
    assert planar_start.improvement == planar_start.value - planar_start.reference_value
    np.testing.assert_allclose(position(planar_start.q), x, atol=1e-11)


def test_of_mirror_images_the_nearest_is_chosen(planar):
    """The arm's mirror image at the line from base to tip has the same minors but for their signs."""
    x = np.array([1.6, 0.0])
    for side in (1.0, -1.0):
        reference = side * postures(x, 0.3)[0]
        chosen = ac.aspects.choose_start(planar, x, reference=reference)
        mirrored = np.abs(np.remainder(-chosen.q - reference + np.pi, 2 * np.pi) - np.pi)
        assert np.linalg.norm(chosen.change) <= np.linalg.norm(mirrored) + 1e-9


def test_panda_start_keeps_pose_and_limits_and_is_best_on_its_curves(panda_start):
    arm = panda_start.arm
    arm.require_within_limits(panda_start.q)
    error = arm.coordinates.error(arm.task_position(READY), arm.task_position(panda_start.q))
    assert np.linalg.norm(error) < 1e-9
    assert len(panda_start.curves) == 2
    for curve in panda_start.curves:
        assert curve.minor_measure[curve.within_limits].max() <= panda_start.value + 1e-12
    values = np.array([np.linalg.det(arm.jacobian(panda_start.q)[:, each]) for each in arm.minor_columns])
    assert panda_start.value == pytest.approx(np.abs(values).prod() ** (1 / 7), rel=1e-9)
    assert panda_start.signature == tuple(np.sign(values).astype(int))
    assert panda_start.smallest_minor == pytest.approx((np.abs(values) / arm.minor_scales).min())
    np.testing.assert_allclose(READY + panda_start.change, panda_start.q, atol=1e-12)


@pytest.mark.parametrize(("task", "on_border", "of", "gain"), [("xyz", 10, 19, 0.008), ("pose", 3, 7, 0.05)])
def test_a_small_move_takes_the_ready_pose_of_panda_off_its_borders(task, on_border, of, gain):
    arm = example_arm("panda", task)
    assert (len(arm.minors_on_border(READY)), len(arm.minor_columns)) == (on_border, of)
    chosen = ac.aspects.choose_start(arm, arm.task_position(READY), reference=READY, within=0.1)
    assert np.abs(chosen.change).max() <= 0.1
    assert chosen.reference_smallest_minor < 1e-12
    assert chosen.smallest_minor > gain
    assert len(arm.minors_on_border(chosen.q)) == 0
    farther = ac.aspects.choose_start(arm, arm.task_position(READY), reference=READY, within=0.2)
    assert farther.value > chosen.value > 100 * chosen.reference_value


@pytest.mark.parametrize(
    ("robot", "task", "positions"),
    [("ur5", "xyz", [0.3, -0.9, 1.2, 1.2, 0.3, 0.8]), ("kinova", "xyz", [0.3, 2.6, 1.2, 0.5, 1.0, 0.3])],
)
def test_start_of_several_joints_to_spare_is_a_peak_inside_the_limits(robot, task, positions):
    arm = example_arm(robot, task)
    q = arm.configuration(positions)
    chosen = ac.aspects.choose_start(arm, arm.task_position(q), reference=q, count=150)
    arm.require_within_limits(chosen.q)
    np.testing.assert_allclose(arm.task_position(chosen.q), arm.task_position(q), atol=1e-9)
    assert chosen.sample is not None
    assert chosen.value > chosen.sample.minor_measure.max()
    assert chosen.value > chosen.reference_value
    again = ac.aspects.choose_start(arm, arm.task_position(q), reference=q, count=150)
    assert again.q.tobytes() == chosen.q.tobytes()


class NearHome:
    """−‖θ − θ₀‖², with its gradient: the constrained peak is where the rest of the gradient is a row of J."""

    def __init__(self, home):
        self.home = np.asarray(home)

    def value(self, state):
        return -float((state.q - self.home) @ (state.q - self.home))

    def gradient(self, state):
        return -2.0 * (state.q - self.home)


@pytest.mark.parametrize("with_gradient", [True, False])
def test_any_criterion_can_be_climbed(with_gradient):
    arm = example_arm("panda", "xyz")
    near_home = NearHome([0.2, -0.5, 0.1, -2.0, 0.2, 1.6, 0.5])
    criterion = near_home if with_gradient else near_home.value
    chosen = ac.aspects.choose_start(arm, arm.task_position(READY), criterion=criterion, reference=READY, count=60)
    state = arm.state(chosen.q, np.zeros(7))
    gradient = near_home.gradient(state)
    along_self_motion = gradient - np.linalg.pinv(state.J) @ state.J @ gradient
    assert np.abs(along_self_motion).max() < 1e-4
    assert chosen.value == near_home.value(state)
    assert chosen.value > chosen.reference_value


def test_without_a_reference_the_first_posture_found_is_compared_with(seven):
    x = seven.task_position(np.full(7, 0.4))
    chosen = ac.aspects.choose_start(seven, x, count=40)
    np.testing.assert_array_equal(chosen.reference_q, chosen.sample.positions[0])


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"x": [2.5, 2.5]}, UnreachableError, "out of reach of 'planar3r'.*leaves 0.536 m"),
        ({"reference": [7.0, 0.0, 0.0]}, ParameterError, "'joint1' at 7 is outside its limits"),
        ({"reference": [0.1, 0.2, 0.3]}, ParameterError, "reference posture is .* away from the task value"),
        ({"within": 0.1}, ParameterError, "give both"),
        ({"criterion": 3}, ParameterError, "a criterion has a 'value.state.' or is a function of the state, got 3"),
        ({"criterion": lambda state: np.nan}, ParameterError, "the criterion is not finite at any of"),
        ({"seed": -1}, ParameterError, "seed must be a whole number of at least 0"),
    ],
)
def test_bad_input_of_a_choice(planar, options, error, words):
    with pytest.raises(error, match=words) as raised:
        ac.aspects.choose_start(planar, **{"x": [1.0, 1.0], "count": 5, **options})
    assert isinstance(raised.value, AspectControlError)


# The command


def test_start_prints_what_changes_and_writes_what_it_says(tmp_path, start):
    status, shown, error = start("panda-pose", "--set", READY_SETTING, "--out", tmp_path / "out")
    assert (status, error) == (0, "")
    assert {each.name for each in (tmp_path / "out").iterdir()} == {"start.json", "self-motion.png", "self-motion.svg"}
    record = json.loads((tmp_path / "out" / "start.json").read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert record["minors_on_border_at_reference"] == [3, 5, 7]
    assert record["minors_on_border"] == []
    assert max(curve["largest_task_error"] for curve in record["self_motions"]) < 1e-9
    lines = {" ".join(line.split()) for line in shown.splitlines()}
    assert "minors on a border, of 7 3 0" in lines
    assert f"minor-measure 0 {record['value']:.4g}" in lines
    assert "best of 2 self-motion curves, inside the joint limits" in lines
    for name, before, after in zip(record["joints"], record["reference_positions"], record["positions"], strict=True):
        before, after = np.rad2deg([before, after])
        assert f"{name} {before:.1f}° {after:.1f}° {after - before:.1f}°" in lines
    pasted = next(line for line in lines if line.startswith("start.positions = "))
    chosen = np.array(json.loads(pasted.removeprefix("start.positions = ")))
    np.testing.assert_allclose(chosen, record["positions"], atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["planar3"], "no such scenario file: planar3; did you mean 'planar3r'"),
        (["planar3r", "--within", "-1"], "within must be a finite number above 0 rad, got -1.0"),
        (["planar3r", "--count", "0"], "count must be a whole number of at least 1, got 0"),
        (
            ["panda-pose", "--set", "start.positions=[0, 3, 0, -2, 0, 2, 0]"],
            "'panda_joint2' at 3 is outside its limits",
        ),
        (["planar3r", "--out", "file/below"], "cannot write to folder file/below"),
    ],
)
def test_bad_input_of_start_is_one_line_and_status_2(tmp_path, monkeypatch, start, arguments, words):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.chdir(tmp_path)
    status, shown, error = start(*arguments)
    assert (status, shown) == (2, "")
    assert len(error.splitlines()) == 1
    assert words in error


def test_a_criterion_goes_by_its_name_and_is_what_climbs():
    arm = example_arm("panda", "pose")
    chosen = ac.aspects.choose_start(
        arm, arm.task_position(READY), criterion="joint-range", reference=READY, count=20, within=0.5
    )
    criterion = ac.criteria.create("joint-range", arm)
    rest = np.zeros(arm.nv)
    assert chosen.criterion == "joint-range"
    assert chosen.value == pytest.approx(criterion.value(arm.state(chosen.q, rest)))
    assert chosen.reference_value == pytest.approx(criterion.value(arm.state(READY, rest)))
    assert chosen.value > chosen.reference_value
    with pytest.raises(UnknownNameError, match="joint-range"):
        ac.aspects.choose_start(arm, arm.task_position(READY), criterion="joint-rang")
