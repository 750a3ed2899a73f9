"""Studies: which runs there are, what makes two studies the same, and what is refused before the first run."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_study import SMALL, study_file

import aspect_control as ac
from aspect_control.exceptions import (
    AspectControlError,
    ParameterError,
    ScenarioError,
    ShapeError,
    StudyError,
    UnknownNameError,
)
from aspect_control.scenario import load_scenario
from aspect_control.studies.definition import MOST_POINTS, define
from aspect_control.studies.estimate import time_estimate
from aspect_control.studies.identity import require_identity
from aspect_control.studies.rows import columns, make_row

LAWS = [{"name": "null-space-vector"}, {"name": "jmdc"}]


def study_of(**fields):
    return ac.Study({"scenarios": ["planar3r"], "laws": LAWS, **fields})


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return ac.Study.load(study_file(tmp_path_factory.mktemp("study")))


# Which runs there are


def test_every_combination_is_one_row(small):
    assert small.runs == 6 * 2 * 2
    places = [small.place(row) for row in range(small.runs)]
    assert len(set(places)) == small.runs
    assert {place.sample for place in places} == set(range(6))
    assert {(place.law, place.point) for place in places} == {
        (law, point) for law in ("null-space-vector", "jmdc") for point in (0, 1)
    }


def test_chunks_are_the_rows_in_order(small):
    assert [row for chunk in range(small.chunks) for row in small.rows_of(chunk)] == list(range(small.runs))


@given(st.integers(1, 10**7), st.integers(1, 40), st.integers(1, 12))
def test_chunks_of_any_study_hold_each_run_once(random, values, laws):
    chosen = [{"name": "jmdc", "label": f"law{i}"} for i in range(laws)]
    grid = [{"controller.kp": list(range(1, values + 1))}]
    study = study_of(motions={"random": random}, laws=chosen, grid=grid)
    assert study.runs == random * values * laws
    assert (study.chunks - 1) * study.chunk_size < study.runs <= study.chunks * study.chunk_size
    assert study.rows_of(study.chunks - 1)[-1] == study.runs - 1
    assert study.chunks <= 20_000
    assert study.place(study.runs - 1).sample == random - 1


@given(st.integers(1, 70), st.integers(1, 64))
def test_shards_share_the_chunks(random, number):
    study = study_of(motions={"random": random})
    number = min(number, study.chunks)
    shards = [study.chunks_of(f"{index}/{number}") for index in range(1, number + 1)]
    assert sorted(chunk for shard in shards for chunk in shard) == list(range(study.chunks))


def test_a_law_is_not_run_again_where_the_grid_changes_another():
    study = study_of(grid=[{"controller.jmdc.kappa": [0.0, 0.001, 0.01]}])
    assert [(case.law, case.point) for case in study.cases("planar3r")] == [
        ("null-space-vector", 0),
        ("jmdc", 0),
        ("jmdc", 1),
        ("jmdc", 2),
    ]
    assert study.cases("planar3r")[0].changes == {}
    with pytest.raises(StudyError, match="'null-space-vector' is not run at grid point 2, but at \\[0\\]"):
        study.record("planar3r", 0, "null-space-vector", 2)


def test_tables_of_the_grid_follow_one_another():
    study = study_of(grid=[{"simulation.dt": [0.01, 0.02]}, {"controller": {"kp": [50, 100], "kv": [10]}}])
    assert study.points == [
        {"simulation.dt": 0.01},
        {"simulation.dt": 0.02},
        {"controller.kp": 50, "controller.kv": 10},
        {"controller.kp": 100, "controller.kv": 10},
    ]
    setups = [study.setup("planar3r", point) for point in range(4)]
    assert [setup.dt for setup in setups] == [0.01, 0.02, 1e-3, 1e-3]
    assert [setup.laws["jmdc"].kp[0, 0] for setup in setups] == [100.0, 100.0, 50.0, 100.0]
    assert [setup.laws["jmdc"].kv[0, 0] for setup in setups] == [20.0, 20.0, 10.0, 10.0]


def test_laws_and_motions_of_the_scenario_are_the_default():
    study, scenario = ac.Study({"scenarios": ["planar3r", "panda-xyz"]}), load_scenario("panda-xyz")
    assert study.laws("panda-xyz") == tuple(each.run_label for each in scenario.controllers)
    motion, setup = study.motion("panda-xyz", 0), scenario.build()
    np.testing.assert_array_equal(motion.q0, setup.q0)
    np.testing.assert_array_equal(motion.trajectory.displacement, setup.trajectory.displacement)
    assert study.runs == sum(len(study.laws(name)) for name in study.scenarios)


def test_given_motions_take_the_place_of_the_scenarios_own():
    given_motions = [
        {
            "start": {"degrees": [-50, 140, -140]},
            "trajectory": {"kind": "line", "displacement": [0.2, 0], "duration": 1},
        },
        {"start": {"positions": [0.1, 1.0, 1.0]}, "trajectory": {"kind": "circle", "radius": 0.1, "duration": 1.0}},
    ]
    study = study_of(motions={"given": given_motions})
    assert study.motions == 2
    np.testing.assert_allclose(study.motion("planar3r", 0).q0, np.deg2rad([-50, 140, -140]))
    np.testing.assert_array_equal(study.motion("planar3r", 1).q0, [0.1, 1.0, 1.0])
    assert study.motion("planar3r", 1).trajectory.name == "circle"
    assert make_row(study, 2)["path_length"] is None


# Random motions


def test_a_motion_depends_on_the_seed_and_its_number_alone(small):
    again = ac.Study(small.definition.model_copy(update={"scenarios": ["planar3r"]}))
    backwards = [again.motion("planar3r", sample) for sample in reversed(range(6))][::-1]
    for sample, other in enumerate(backwards):
        motion = small.motion("planar3r", sample)
        np.testing.assert_array_equal(motion.q0, other.q0)
        np.testing.assert_array_equal(motion.trajectory.displacement, other.trajectory.displacement)
    seeded = ac.Study(
        {**small.definition.model_dump(exclude={"folder"}, exclude_unset=True), "motions": {"random": 6, "seed": 4}}
    )
    assert not np.array_equal(seeded.motion("planar3r", 0).q0, small.motion("planar3r", 0).q0)


@pytest.mark.parametrize("scenario", ["planar3r", "panda-xyz"])
@pytest.mark.parametrize("legs", [1, 3])
def test_random_motions_lead_through_points_that_can_be_reached(scenario, legs):
    study = ac.Study({"scenarios": [scenario], "motions": {"random": 10, "seed": 5, "legs": legs}})
    setup = study.setup(scenario)
    arm, own = setup.arm, setup.trajectory
    rows = arm.coordinates.position_rows
    for sample in range(10):
        motion = study.motion(scenario, sample)
        start, times = arm.task_position(motion.q0), [0.0, motion.trajectory.duration]
        if legs > 1:
            times = [0.0, *motion.trajectory.times]
        reached = [motion.trajectory.target(t, start, arm.coordinates).x for t in times]
        lengths = [np.linalg.norm(arm.coordinates.error(b, a)[rows]) for a, b in itertools.pairwise(reached)]
        ratio = np.array(lengths) / np.linalg.norm(own.displacement[rows])
        assert np.all((ratio > 0.5 - 1e-9) & (ratio < 1.5 + 1e-9))
        np.testing.assert_allclose(np.diff(times), own.duration * np.sqrt(ratio), rtol=1e-9)
        assert len(arm.minors_on_border(motion.q0)) == 0
        lower, upper = arm.position_limits
        assert np.all((arm.positions(motion.q0) >= lower) & (arm.positions(motion.q0) <= upper))
        # A spline through the points, and nothing but a line between two.
        np.testing.assert_allclose(motion.v0, 0.0)


# What makes two studies the same


def test_the_hash_is_that_of_what_decides_the_runs(tmp_path):
    text = SMALL.replace("seed = 3", "seed = 3\n")
    hashes = {ac.Study.load(study_file(tmp_path, text, "a")).hash, ac.Study.load(study_file(tmp_path, SMALL, "b")).hash}
    described = 'description = "words"\nreport = "summary"\n' + SMALL
    hashes.add(ac.Study.load(study_file(tmp_path, described, "c")).hash)
    assert len(hashes) == 1
    for old, new in (("seed = 3", "seed = 4"), ("[50, 100]", "[50, 101]"), ('"jmdc"', '"qp"'), ("= false", "= true")):
        changed = ac.Study.load(study_file(tmp_path, SMALL.replace(old, new), "d")).hash
        if old != "= false":  # the scenario has no saturation
            assert changed not in hashes


def test_another_robot_file_makes_another_study(tmp_path, planar_path):
    text = load_text("planar3r").replace('example = "planar3r"', 'urdf = "arm.urdf"')
    (tmp_path / "mine.toml").write_text(text)
    (tmp_path / "arm.urdf").write_text(planar_path.read_text())
    path = study_file(tmp_path, SMALL.replace('"planar3r"', '"mine.toml"'))
    first = ac.Study.load(path)
    (tmp_path / "arm.urdf").write_text(planar_path.read_text().replace('mass value="', 'mass value="1'))
    assert ac.Study.load(path).hash != first.hash
    with pytest.raises(StudyError, match="has other robot files than the machine that started the study"):
        require_identity(first)


def load_text(name):
    from aspect_control.resources import scenario_paths

    return scenario_paths()[name].read_text()


# Rows


def test_a_row_says_what_was_run_and_what_came_of_it(small):
    row = small.runs - 1
    place, made = small.place(row), make_row(small, row)
    run = small.record(*place)
    assert list(made) != []
    assert set(made) <= set(columns(small))
    assert (made["study"], made["row"], made["law"], made["point"]) == (small.hash, row, place.law, place.point)
    assert made["controller.kp"] == 100
    assert made["simulation.dt"] == made["dt"] == run.info.dt == 0.01
    assert json.loads(made["parameters"])["kp"] == 100.0
    assert {name: made[name] for name in run.metrics()} == run.metrics()
    assert made["status"] == run.status
    assert made["duration"] == pytest.approx(run.t[-1], abs=0.01)
    assert made["path_length"] == pytest.approx(np.linalg.norm(run.x_desired[-1] - run.x[0]), rel=0.01)


def test_a_run_that_raises_is_a_row(small):
    study = study_of(
        laws=[{"name": "jmdc"}],
        motions={
            "given": [
                {
                    "start": {"degrees": [0, 0, 0]},
                    "trajectory": {"kind": "line", "displacement": [-1, 0], "duration": 1},
                },
            ]
        },
        grid=[{"simulation.dt": [5.0]}],
    )
    row = make_row(study, 0)
    assert row["status"] == "error"
    assert "dt must not be longer than the motion" in row["message"]
    assert "peak_torque" not in row


def test_recording_at_another_sampling_time(small):
    place = small.place(0)
    assert small.record(*place, dt=0.005).info.dt == 0.005
    assert len(small.record(*place, dt=0.005).t) == pytest.approx(2 * len(small.record(*place).t), abs=2)


def test_the_time_a_study_takes_grows_with_it():
    few, many = study_of(motions={"random": 10}), study_of(motions={"random": 1000})
    assert time_estimate(many, 1) > 10 * time_estimate(few, 1) > 0.0


# What is refused


@pytest.mark.parametrize(
    ("fields", "error", "words"),
    [
        ({"scenarios": []}, StudyError, ["scenarios"]),
        ({"scenarios": ["planar4r"]}, ScenarioError, ["planar4r", "did you mean 'planar3r'"]),
        ({"scenarios": ["planar3r", "planar3r"]}, StudyError, ["'planar3r' is given twice"]),
        ({"motion": {}}, StudyError, ["unknown field 'motion'", "did you mean 'motions'"]),
        ({"motions": {"randm": 3}}, StudyError, ["unknown field 'motions.randm'", "random"]),
        ({"motions": {"random": 0}}, StudyError, ["motions.random", "greater than or equal to 1"]),
        ({"motions": {"random": 1, "given": [{}]}}, StudyError, ["motions.given"]),
        ({"laws": [{"name": "jmdc", "label": "a b"}]}, StudyError, ["laws"]),
        ({"laws": [{"name": "jmdc"}, {"name": "jmdc"}]}, ScenarioError, ["jmdc more than once"]),
        ({"grid": [{"controller.kp": 50}]}, StudyError, ["grid", "controller.kp must be a list"]),
        ({"grid": [{"controller.kp": []}]}, StudyError, ["controller.kp must be a list of at least one value"]),
        (
            {"grid": [{"a": list(range(400)), "b": list(range(400))}]},
            StudyError,
            ["160,000 points", f"{MOST_POINTS:,}"],
        ),
        ({"endings": ["diverge"]}, StudyError, ["endings", "did you mean 'diverged'"]),
        ({"folder": "x"}, StudyError, ["unknown field 'folder'"]),
    ],
)
def test_what_is_no_study_is_refused(fields, error, words):
    with pytest.raises(error) as raised:
        study_of(**fields)
    for word in words:
        assert word in str(raised.value)


@pytest.mark.parametrize(
    ("fields", "error", "words"),
    [
        ({"laws": [{"name": "jmcd"}]}, AspectControlError, "did you mean 'jmdc'"),
        ({"grid": [{"controller.jmdc.kapa": [1.0]}]}, AspectControlError, "did you mean 'kappa'"),
        ({"grid": [{"controller.kp": [100, -1]}]}, ParameterError, "kp"),
        ({"grid": [{"simulation.dt": [0.0]}]}, ScenarioError, "planar3r, grid point 0: simulation.dt"),
        ({"grid": [{"simulaton.dt": [0.1]}]}, ScenarioError, "simulaton"),
        (
            {"motions": {"random": 3}, "grid": [{"trajectory.displacement": [[90.0, 0.0]]}]},
            ParameterError,
            "no line was",
        ),
        ({"motions": {"random": 3}, "grid": [{"trajectory.displacement": [[1.0]]}]}, ShapeError, "task coordinates"),
    ],
)
def test_what_cannot_be_built_is_found_before_the_first_run(fields, error, words, tmp_path):
    study = study_of(**fields)
    with pytest.raises(error, match=words):
        study.run(tmp_path / "out")
    assert not list((tmp_path / "out" / "shards").glob("*"))


@pytest.mark.parametrize("text", ["scenarios = [", "scenarios = 3", "x" * 10, ""])
def test_a_file_that_holds_no_study_is_refused(text, tmp_path):
    with pytest.raises(StudyError, match=r"small\.toml"):
        ac.Study.load(study_file(tmp_path, text))


@pytest.mark.parametrize("path", ["no-such.toml", "", "a\0b", "\ud800", "."])
def test_a_file_that_is_not_there_is_refused(path):
    with pytest.raises(StudyError):
        ac.Study.load(path)


@pytest.mark.parametrize("shard", ["0/3", "4/3", "1", "a/b", "1/2/3", 3, "", "-1/2", "70/70"])
def test_what_is_no_shard_is_refused(small, shard):
    with pytest.raises(StudyError, match="shard"):
        small.chunks_of(shard)


@pytest.mark.parametrize(
    ("place", "error"),
    [
        (("planar4r", 0, "jmdc", 0), UnknownNameError),
        (("planar3r", 6, "jmdc", 0), ParameterError),
        (("planar3r", -1, "jmdc", 0), ParameterError),
        (("planar3r", 0, "jmcd", 0), UnknownNameError),
        (("planar3r", 0, "jmdc", 2), StudyError),
        (("planar3r", 0.5, "jmdc", 0), ParameterError),
    ],
)
def test_a_run_that_is_not_in_the_study_is_refused(small, place, error):
    with pytest.raises(error):
        small.record(*place)


@pytest.mark.parametrize("row", [-1, 24, 1.0, True, "0", math.nan])
def test_a_row_that_is_not_in_the_study_is_refused(small, row):
    with pytest.raises(ParameterError):
        small.place(row)


def test_a_definition_may_be_a_mapping():
    assert define("mine", {"scenarios": ["planar3r"]}).motions.count == 1
