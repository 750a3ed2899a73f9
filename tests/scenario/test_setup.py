"""What a scenario builds: the parts, as its file says, once."""

import copy
import dataclasses

import numpy as np
import pytest

from aspect_control.exceptions import ParameterError, ShapeError, UnknownNameError, WorkspaceWarning
from aspect_control.plants import RigidBodyPlant
from aspect_control.scenario import load_scenario
from aspect_control.simulation import Diverged, JointLimit, TorqueLimit, simulate

FAST = ["simulation.dt=0.02"]
ALL = [*FAST, 'simulation.saturation="urdf"', "limits.torque=50", "limits.joints=true", "start.velocities=[0.1, 0, 0]"]


@pytest.fixture(scope="module")
def setup():
    return load_scenario("planar3r", ALL).build()


def test_the_parts_are_what_the_file_says(setup):
    scenario = load_scenario("planar3r", ALL)
    assert setup.arm.description.frame == scenario.robot.frame
    np.testing.assert_allclose(setup.arm.positions(setup.q0), np.deg2rad(scenario.start.degrees), rtol=1e-15)
    assert setup.v0.tolist() == [0.1, 0.0, 0.0]
    assert setup.trajectory.duration == scenario.trajectory.duration
    assert list(setup.laws) == [each.run_label for each in scenario.controllers]
    assert {type(event) for event in setup.events} >= {Diverged, TorqueLimit, JointLimit}
    assert isinstance(setup.plant, RigidBodyPlant)
    assert setup.dt == 0.02
    assert setup.integrator.name == "rk4"
    assert setup.saturation.tolist() == setup.arm.torque_limit.tolist()
    assert setup.description == scenario.description


def test_a_start_at_rest_and_motors_without_limits_unless_given():
    setup = load_scenario("planar3r").build()
    assert setup.v0.tolist() == [0.0, 0.0, 0.0]
    assert setup.saturation is None


def test_all_parts_share_one_arm(setup):
    assert all(law.arm is setup.arm for law in setup.laws.values())
    assert setup.plant.arm is setup.arm


def test_it_is_frozen_and_its_arrays_are_read_only(setup):
    with pytest.raises(dataclasses.FrozenInstanceError):
        setup.dt = 1.0
    for array in (setup.q0, setup.v0):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_a_run_is_that_of_its_parts_and_comes_out_again_to_the_last_bit(setup):
    first, again = setup.run(), setup.run()
    for label, law in setup.laws.items():
        alone = simulate(
            copy.deepcopy(law),
            setup.trajectory,
            q0=setup.q0,
            v0=setup.v0,
            dt=setup.dt,
            saturation=setup.arm.torque_limit,
            events=setup.events,
        )
        for run in (first[label], again[label]):
            assert run.message == alone.message
            assert run.tau.tobytes() == alone.tau.tobytes()
            assert run.q.tobytes() == alone.q.tobytes()


def test_only_the_laws_that_are_asked_for_are_built():
    scenario = load_scenario("planar3r", ["controller.jmdc.kappa=-1"])
    with pytest.raises(ParameterError, match="kappa"):
        scenario.build()
    assert list(scenario.build(laws=["pseudoinverse"]).laws) == ["pseudoinverse"]
    assert scenario.build(laws=()).laws == {}


def test_a_label_that_the_scenario_does_not_have_is_refused():
    with pytest.raises(UnknownNameError, match="jmdc"):
        load_scenario("planar3r").build(laws=["jdmc"])


@pytest.mark.parametrize(
    ("setting", "error", "words"),
    [
        ("start.velocities=[1, 2]", ShapeError, r"start\.velocities must have shape \(3,\), got \(2,\)"),
        ("simulation.saturation=[1, 2]", ShapeError, "saturation must be"),
        ("limits.torque=[1, 2]", ShapeError, "limit must be"),
        ('simulation.integrator="rk5"', UnknownNameError, "unknown integrator 'rk5'"),
    ],
)
def test_what_does_not_fit_is_refused_when_it_is_built(setting, error, words):
    scenario = load_scenario("planar3r", [setting])
    with pytest.raises(error, match=words):
        scenario.build()


# Reach


def test_where_the_path_leaves_the_workspace_is_said_once_before_the_runs():
    setup = load_scenario("planar3r", [*FAST, "trajectory.displacement=[3.0, 0.0]"]).build()
    reach = setup.reach()
    assert not reach.reachable
    runs = []
    with pytest.warns(WorkspaceWarning) as caught:
        setup.run_each(lambda label, run: runs.append(run), before=lambda label, law: runs.append(len(caught)))
    assert [str(each.message) for each in caught] == [reach.message]
    assert runs[0] == 1, "the warning comes first"
    assert {run.status for run in runs[1::2]} <= {"workspace left", "diverged"}
    assert {"workspace left"} <= {run.status for run in runs[1::2]}


def test_a_path_in_reach_is_nothing_to_warn_of(setup):
    assert setup.reach().reachable


def test_a_path_beyond_joint_limits_alone_is_said_and_run_to_its_end():
    # Joint 2 would have to lean farther than it can.
    start = np.deg2rad([-73.0, 94.0, 8.0, -78.0, 96.0, 146.0, 120.0]).tolist()
    changes = ["robot.frame=panda_hand", f"start.positions={start}", "trajectory.displacement=[0.008, 0.226, -0.106]"]
    setup = load_scenario("panda-xyz", ["simulation.dt=5e-3", *changes]).build(laws=["pseudoinverse"])
    with pytest.warns(WorkspaceWarning, match="with joint 'panda_joint2' at its limit; .* inside its joint limits$"):
        (run,) = setup.run().values()
    assert run.status == "finished"
