import pickle

import numpy as np
import pytest

from aspect_control import Arm, StraightLine, controllers, plants, simulate
from aspect_control.exceptions import ParameterError, UnknownNameError
from aspect_control.plants import Plant, RigidBodyPlant
from aspect_control.resources import model_path

A = StraightLine([1.5, 1.0], duration=2.0)
Q0 = np.deg2rad([-50.0, 140.0, -140.0])


def planar(gravity=(0.0, 0.0, 0.0)):
    return Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=gravity)


class Damped(Plant):
    """Rigid bodies in a viscous bath: a plant of somebody else's."""

    def __init__(self, arm, damping):
        super().__init__(arm)
        self.rigid, self.damping = RigidBodyPlant(arm), damping

    def acceleration(self, q, v, tau):
        return self.rigid.acceleration(q, v, tau - self.damping * v)


def run_on(plant, arm, **options):
    return simulate(controllers.create("pseudoinverse", arm), A, q0=Q0, dt=0.01, plant=plant, **options)


def test_a_plant_says_how_it_accelerates():
    with pytest.raises(TypeError, match="acceleration"):
        Plant(planar())


def test_ideal_rigid_bodies_are_what_moves_unless_told_otherwise():
    arm = planar()
    np.testing.assert_array_equal(run_on(None, arm).q, run_on(RigidBodyPlant(arm), arm).q)


@pytest.mark.parametrize("integrator", ["rk4", "semi-implicit-euler"])
def test_another_plant_moves_as_it_accelerates(integrator):
    arm = planar()
    ideal, undamped, damped = (
        run_on(plant, arm, integrator=integrator) for plant in (None, Damped(arm, 0.0), Damped(arm, 5.0))
    )
    np.testing.assert_allclose(undamped.q, ideal.q, rtol=0, atol=1e-12)
    assert np.abs(damped.q - ideal.q).max() > 1e-3


def test_a_plant_of_the_same_arm_made_again_is_taken():
    arm = planar()
    assert run_on(RigidBodyPlant(pickle.loads(pickle.dumps(arm))), arm).status == "finished"


def test_a_plant_of_another_arm_is_refused(seven):
    for other in (seven, planar(gravity=(0.0, -9.81, 0.0))):
        with pytest.raises(ParameterError, match=r"the plant must be one of the law's arm Arm\(.*got one of Arm\("):
            run_on(RigidBodyPlant(other), planar())


@pytest.mark.parametrize("nothing", ["rigid", RigidBodyPlant, 1.0])
def test_what_is_no_plant_is_refused(nothing):
    with pytest.raises(UnknownNameError, match=r"unknown plant .*available: 'rigid-body'"):
        run_on(nothing, planar())


def test_a_plant_is_found_by_its_name():
    arm = planar()
    assert plants.available() == ("rigid-body",)
    assert plants.create("rigid-body", arm).arm is arm
    for given in ("rigid-body", {"name": "rigid-body"}):
        np.testing.assert_array_equal(run_on(given, arm).q, run_on(None, arm).q)


@pytest.mark.parametrize("nothing", [None, "planar3r", 3.0])
def test_a_plant_is_made_for_an_arm(nothing):
    with pytest.raises(ParameterError, match="'rigid-body' is made for an Arm, got"):
        plants.create("rigid-body", nothing)
    with pytest.raises(ParameterError, match="a plant is made for an Arm, got"):
        RigidBodyPlant(nothing)
