"""Maciejewski's condition over configurations: against Eq. (12), free self-motions and a closed-form arm."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline

from aspect_control import Hold, Target, aspects, controllers, simulate
from aspect_control.analysis.self_motion_of_run import self_motion_of_run
from aspect_control.arm import Arm
from aspect_control.exceptions import ParameterError
from aspect_control.plants import RigidBodyPlant
from aspect_control.redundancy import (
    homogeneous_acceleration,
    homogeneous_velocity,
    minimum_torque,
    null_vector,
    null_vector_derivative,
    pseudoinverse_torque,
)
from aspect_control.studies.paper import trajectory_a as paper
from example_arms import example_arm, random_posture
from oracles.planar_reference import inertia, jacobian, nonlinear_effects

POSTURES = {
    "planar3r": np.deg2rad([-50.0, 140.0, -140.0]),
    "panda": np.array([0.3, -0.3, 0.2, -1.9, 0.3, 1.8, 0.5]),
    "xarm7": np.array([0.3, -0.3, 0.2, 1.2, 0.3, 0.8, 0.5]),
}


def weightless(name):
    frames = {"planar3r": ("tool", "xy"), "panda": ("panda_hand_tcp", "pose"), "xarm7": ("link7", "pose")}
    frame, task = frames[name]
    return Arm.from_example(name, frame=frame, task=task, gravity=(0.0, 0.0, 0.0))


def apart(one, other):
    """The largest difference of angles modulo a turn."""
    return np.abs(np.remainder(one - other + np.pi, 2.0 * np.pi) - np.pi).max(axis=-1)


@pytest.fixture(scope="module", params=list(POSTURES))
def case(request):
    return weightless(request.param), POSTURES[request.param]


def test_null_vector_turns_along_the_self_motion_as_its_derivative_says(case):
    arm, q = case
    z = null_vector(arm.jacobian(q))
    dz = null_vector_derivative(arm.jacobian(q), arm.state(q, z).drift)
    h = 1e-5
    ahead, behind = (null_vector(arm.jacobian(arm.integrate(q, step * z))) for step in (h, -h))
    np.testing.assert_allclose(dz, (ahead - behind) / (2.0 * h), atol=1e-8)
    assert abs(z @ dz) < 1e-13
    opposite = null_vector_derivative(arm.jacobian(q), arm.state(q, -z).drift)
    np.testing.assert_allclose(opposite, dz, atol=1e-13)


@pytest.mark.parametrize("name", list(POSTURES))
@pytest.mark.parametrize("speed", [0.7, -0.7, 3.0])
def test_eq_12_at_pure_self_motion_is_minus_c_times_the_cube_of_the_speed(name, speed):
    arm, rng = weightless(name), np.random.default_rng(11)
    for _ in range(8):
        q = random_posture(arm, rng)
        state = arm.state(q, speed * null_vector(arm.jacobian(q)))
        b = -state.drift
        theta_ddot_H = homogeneous_acceleration(
            state.M,
            minimum_torque(state.M, state.nle, state.J, b),
            pseudoinverse_torque(state.M, state.nle, state.J, b),
        )
        product = homogeneous_velocity(state.J, state.v) @ theta_ddot_H
        c = aspects.stability(arm, q)
        assert product == pytest.approx(-c * speed**3, rel=1e-7, abs=1e-9)


def test_gravity_does_not_enter():
    heavy, light = example_arm("panda", "pose"), weightless("panda")
    q = POSTURES["panda"]
    assert aspects.stability(heavy, q) == pytest.approx(aspects.stability(light, q), rel=1e-9)


def test_planar_coefficient_is_that_of_the_closed_form_arm(planar):
    """From Lagrange's equations: z from the printed minors, z′ by differences, N by Christoffel symbols."""

    def direction(q):
        J = jacobian(q)
        z = np.cross(J[0], J[1])
        return z / np.linalg.norm(z)

    rng, h = np.random.default_rng(5), 1e-5
    for _ in range(20):
        q = rng.uniform(-3.0, 3.0, 3)
        z, M = direction(q), inertia(q)
        dz = (direction(q + h * z) - direction(q - h * z)) / (2.0 * h)
        c = (M @ z) @ (M @ dz + nonlinear_effects(q, z)) / (M @ z @ M @ z)
        assert aspects.stability(planar, q) == pytest.approx(c, rel=1e-6, abs=1e-7)


def test_c_is_a_logarithmic_derivative_and_the_pull_of_the_kinetic_energy(planar):
    """c = d ln‖Mz‖/ds − (Mz)·∇T/‖Mz‖², T = ½ zᵀM(θ)z at fixed z; the first part vanishes once round a closed curve."""
    q, h = POSTURES["planar3r"], 1e-5
    z, M = null_vector(jacobian(q)), inertia(q)
    pull = np.array([z @ (inertia(q + step) - inertia(q - step)) @ z for step in h * np.eye(3)]) / (4.0 * h)
    lengths = [np.linalg.norm(inertia(q + s * z) @ null_vector(jacobian(q + s * z))) for s in (h, -h)]
    expected = np.log(lengths[0] / lengths[1]) / (2.0 * h) - (M @ z) @ pull / (M @ z @ M @ z)
    assert aspects.stability(planar, q) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_free_self_motion_under_the_null_space_vector_law_grows_as_the_map_says(case, direction):
    """The closed loop in continuous time from ṡ₀ = ±0.5 rad/s, against the quadrature of c along the curve."""
    arm, q0 = case
    law, plant, n = controllers.NullSpaceVector(arm), RigidBodyPlant(arm), arm.nv
    target = Target(x=arm.task_position(q0), dx=np.zeros(arm.task_dim), ddx=np.zeros(arm.task_dim))

    def derivative(t, y):
        tau = law.torque(y[:n], y[n:], target)
        return np.concatenate([y[n:], plant.acceleration(y[:n], y[n:], tau)])

    v0 = 0.5 * direction * null_vector(arm.jacobian(q0))
    end = solve_ivp(derivative, (0.0, 2.0), np.concatenate([q0, v0]), method="DOP853", rtol=1e-10, atol=1e-10).y[:, -1]
    curve = aspects.self_motion(arm, q0)
    z = null_vector(arm.jacobian(end[:n]))
    # Where on the curve the motion has come to, less than a turn from its start.
    s = curve.s[apart(curve.positions, end[:n]).argmin()] - (curve.length if direction < 0.0 else 0.0)
    for _ in range(3):
        s += z @ np.remainder(end[:n] - curve.at(s) + np.pi, 2.0 * np.pi) - np.pi * z.sum()
    assert apart(curve.at(s), end[:n]) < 1e-7
    logarithm = -quad(lambda arc: aspects.stability(arm, arm.configuration(curve.at(arc))), 0.0, s, epsabs=1e-9)[0]
    assert np.log(direction * (z @ end[n:]) / 0.5) == pytest.approx(logarithm, abs=1e-7)
    assert abs(logarithm) > 0.05
    grown = aspects.growth(curve)
    place = s % curve.length
    turn = np.log(grown.factor) if s < 0.0 else 0.0
    assert CubicSpline(grown.s, grown.logarithm)(place) - turn == pytest.approx(logarithm, abs=1e-5)


def test_simulated_hold_converges_to_the_map_as_the_sampling_time_goes_to_zero(planar):
    q0 = POSTURES["planar3r"]
    errors = []
    for dt in (2e-3, 1e-3, 5e-4):
        law = controllers.NullSpaceVector(planar)
        run = simulate(law, Hold(1.0), q0=q0, v0=0.8 * null_vector(planar.jacobian(q0)), dt=dt)
        own = self_motion_of_run(run)
        expected = own.own_logarithm[-1]
        errors.append(abs(np.log(own.speed[-1] / own.speed[0]) - expected))
        assert abs(expected) > 0.1
    assert errors[0] > 1.8 * errors[1] > 3.2 * errors[2]
    assert errors[2] < 1e-3


def test_growth_once_round_is_the_same_from_every_posture_of_the_curve(planar):
    first = aspects.self_motion(planar, POSTURES["planar3r"])
    second = aspects.self_motion(planar, first.at(7.3))
    one, other = aspects.growth(first), aspects.growth(second)
    assert one.factor == pytest.approx(other.factor, rel=1e-9)
    assert one.largest_factor == pytest.approx(other.largest_factor, rel=1e-3)
    assert one.factor == pytest.approx(3.703, abs=1e-3)
    assert one.largest_factor > one.factor


def test_peak_of_the_null_space_vector_method_is_that_of_its_own_self_motion():
    """What the map adds to the paper's last remark: the peak of Eq. (12) is |c| times the cube of a grown speed."""
    run = paper.run_law("null-space-vector", 1e-3)
    own, peak = self_motion_of_run(run), run.maciejewski_product.argmax()
    assert own.own_product[peak] / run.maciejewski_product[peak] == pytest.approx(0.989, abs=0.005)
    by_itself = np.exp(own.own_logarithm[1790] - own.own_logarithm[1600])
    assert own.speed[1790] / own.speed[1600] == pytest.approx(by_itself, rel=0.02)


def test_c_is_for_one_joint_to_spare():
    arm = example_arm("panda", "xyz")
    with pytest.raises(ParameterError, match="leaves 4 redundant degrees of freedom of 7 joints"):
        aspects.stability(arm, POSTURES["panda"])
