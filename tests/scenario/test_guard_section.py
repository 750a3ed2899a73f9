"""A guard in a scenario file."""

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.exceptions import ParameterError, ScenarioError
from aspect_control.scenario import load_scenario


def test_every_law_gets_a_guard_of_its_own():
    setup = load_scenario("panda-xyz", ["guard.torque_rate=2000.0", "guard.tracking=0.05", "guard.speed=inf"]).build()
    assert all(isinstance(law, ac.Guard) for law in setup.laws.values())
    assert len({id(law.law) for law in setup.laws.values()}) == len(setup.laws)
    limits = setup.laws["jmdc"].limits
    np.testing.assert_array_equal(limits.rate, 2000.0)
    np.testing.assert_array_equal(limits.torque, setup.arm.torque_limit)
    assert (limits.tracking, limits.speed.min()) == (0.05, np.inf)


def test_without_the_section_there_is_none():
    assert not any(isinstance(law, ac.Guard) for law in load_scenario("panda-xyz").build().laws.values())


def test_runs_that_a_guard_stops_say_so():
    settings = ["guard.jump=0.05", "simulation.dt=2e-3"]
    runs = load_scenario("panda-xyz", settings).build(laws=["null-space-vector", "jmdc"]).run()
    assert runs["jmdc"].status == "finished"
    assert runs["null-space-vector"].status == "stopped"
    assert "its speed limit is 2.61 rad/s" in runs["null-space-vector"].message


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("guard.tork=1.0", "unknown field 'guard.tork', did you mean 'torque'"),
        ("guard.torque=0.0", "guard.torque"),
        ("guard.position=[1.0]", "guard.position"),
        ("guard.jump=-1.0", "guard.jump"),
        ("guard=3", "guard: must be a table"),
    ],
)
def test_a_wrong_field_is_named(setting, words):
    with pytest.raises(ScenarioError, match=words.replace("[", r"\[")):
        load_scenario("panda-xyz", [setting])


def test_a_limit_that_does_not_fit_the_arm_is_refused():
    with pytest.raises(ParameterError, match="lower limit below the upper"):
        load_scenario("panda-xyz", ["guard.position=[1.0, -1.0]"]).build()
