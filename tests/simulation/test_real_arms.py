"""Robots as they are sold, under gravity, in closed loop."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from aspect_control import Arm, StraightLine, controllers, simulate
from aspect_control.analysis import summarize
from aspect_control.plants import RigidBodyPlant
from aspect_control.simulation import RungeKutta4, SemiImplicitEuler, integrators

DT = 2e-3
LAWS = ("pseudoinverse", "modified-null-space-vector", "jmdc")


class Motion(NamedTuple):
    """A robot, its task, a bent start inside its limits, and a line of 0.2 m, with a turn of 0.54 rad for the pose."""

    robot: str
    frame: str
    task: str
    start: tuple[float, ...]
    displacement: tuple[float, ...]


PANDA_START = (0.3, -0.6, 0.4, -2.0, 0.5, 1.8, 0.6)
MOTIONS = {
    "panda": Motion("panda", "panda_hand", "xyz", PANDA_START, (0.1, 0.15, -0.087)),
    "panda pose": Motion("panda", "panda_hand", "pose", PANDA_START, (0.1, 0.15, -0.087, 0.2, -0.3, 0.4)),
    "xarm7": Motion("xarm7", "link7", "xyz", (0.3, -0.5, 0.4, 1.2, 0.5, 1.3, 0.2), (0.1, 0.1, 0.14)),
    "ur5": Motion("ur5", "tool0", "xyz", (0.3, -1.2, 1.5, -0.8, -1.3, 0.4), (-0.1, 0.1, 0.14)),
    "kinova": Motion("kinova", "j2s6s200_end_effector", "xyz", (0.4, 2.8, 1.6, 0.6, 2.0, 3.0), (0.1, 0.1, 0.14)),
}
CASES = [(motion, law) for motion in MOTIONS for law in LAWS]


@cache
def arm_of(name):
    motion = MOTIONS[name]
    return Arm.from_example(motion.robot, frame=motion.frame, task=motion.task)


@cache
def run_of(name, law, integrator="rk4", dt=DT):
    arm, motion = arm_of(name), MOTIONS[name]
    line = StraightLine(motion.displacement, 1.0, profile="quintic")
    controller = controllers.create(law, arm)
    return simulate(controller, line, q0=arm.configuration(motion.start), dt=dt, integrator=integrator)


def joint_steps(run):
    return np.array([run.arm.difference(a, b) for a, b in zip(run.q[:-1], run.q[1:], strict=True)])


def work_and_gain(run):
    """The work of the recorded torques, held from sample to sample, the gain in energy, and the sum of all |work|."""
    plant, work = RigidBodyPlant(run.arm), run.tau[:-1] * joint_steps(run)
    gain = plant.energy(run.q[-1], run.v[-1]) - plant.energy(run.q[0], run.v[0])
    return work.sum(), gain, np.abs(work).sum()


# The motions


@pytest.mark.parametrize("name", MOTIONS)
def test_the_start_is_inside_the_limits_and_off_every_border_and_gravity_is_on(name):
    arm, motion = arm_of(name), MOTIONS[name]
    arm.require_within_limits(arm.configuration(motion.start))
    assert arm.minors_on_border(arm.configuration(motion.start)).size == 0
    assert np.linalg.norm(motion.displacement[:3]) == pytest.approx(0.2, abs=2e-3)
    np.testing.assert_array_equal(arm.gravity, [0.0, 0.0, -9.81])


@pytest.mark.parametrize("integrator", integrators.available())
@pytest.mark.parametrize(("name", "law"), CASES)
def test_the_line_is_tracked(name, law, integrator):
    run = run_of(name, law, integrator)
    assert (run.status, len(run.t)) == ("finished", 501)
    # Measured: 0.23 mm at most. JMDC follows the velocity one sample late: 0.375 m/s for 2 ms is 0.75 mm; 1.1 mm.
    assert run.tracking_error.max() < (1.3e-3 if law == "jmdc" else 0.4e-3)
    # Measured: 0.48 mrad and 2.7 mrad; at 1.01 rad/s one sample is 2.0 mrad.
    assert run.orientation_error.max() < (3.5e-3 if law == "jmdc" else 0.8e-3)


@pytest.mark.parametrize("law", LAWS)
def test_the_pose_s_turn_is_made(law):
    run = run_of("panda pose", law)
    turned = run.arm.coordinates.decode(run.x[-1]).rotation @ run.arm.coordinates.decode(run.x[0]).rotation.T
    angle = np.arccos((np.trace(turned) - 1.0) / 2.0)
    assert angle == pytest.approx(np.linalg.norm([0.2, -0.3, 0.4]), abs=3.5e-3)
    assert run.orientation_error.max() > 0.0


@pytest.mark.parametrize(("name", "law"), CASES)
def test_the_motors_of_the_robot_could_do_it(name, law):
    run = run_of(name, law)
    # Measured: 86 % at most.
    assert np.all(np.abs(run.tau) < run.arm.torque_limit)


@pytest.mark.parametrize(("name", "law"), CASES)
def test_the_start_is_held_against_gravity(name, law):
    run = run_of(name, law)
    np.testing.assert_allclose(run.v[0], 0.0)
    state = run.arm.state(run.q[0], run.v[0])
    # The quintic sets off without acceleration, so that gravity is all there is in the range of Jᵀ.
    assert np.abs(np.linalg.solve(state.M, run.tau[0] - state.nle) @ state.J.T).max() < 1e-9


@pytest.mark.parametrize(("name", "law"), CASES)
def test_the_summary_of_a_real_arm_is_plain_and_finite(name, law):
    summary = summarize(run_of(name, law))
    assert summary["minors"] == len(arm_of(name).minor_columns)
    assert summary["minors_on_border_at_start"] == []
    assert np.isfinite([*summary["peak_torque"], summary["maciejewski_product_max"]]).all()
    assert summary["aspect_preserved"] == (summary["minor_zero_crossings"] == [])


# Energy


@pytest.mark.parametrize(("name", "law"), CASES)
def test_the_work_of_the_torques_is_the_gain_in_energy(name, law):
    work, gain, turnover = work_and_gain(run_of(name, law))
    assert turnover > 4.0
    # RK4's fourth order: 3e-9 J measured, of up to 17 J that the motors turn over.
    assert work == pytest.approx(gain, rel=0, abs=2e-8)


@pytest.mark.parametrize("name", MOTIONS)
def test_semi_implicit_euler_misses_the_energy_at_first_order(name):
    misses = []
    for dt in (DT, DT / 2):
        work, gain, turnover = work_and_gain(run_of(name, "jmdc", "semi-implicit-euler", dt))
        misses.append(abs(work - gain))
        assert misses[-1] < 2e-3 * turnover
    assert misses[0] / misses[1] == pytest.approx(2.0, abs=0.2)


# Integrators


@pytest.mark.parametrize("name", MOTIONS)
def test_the_integrators_agree_at_first_order_in_closed_loop(name):
    """JMDC controls every joint, so that nothing lets the two drift apart; other laws leave the self-motion free."""
    differences = []
    for dt in (DT, DT / 2):
        one, other = (run_of(name, "jmdc", integrator, dt) for integrator in integrators.available())
        pairs = zip(one.q, other.q, strict=True)
        differences.append(max(np.abs(one.arm.difference(a, b)).max() for a, b in pairs))
    assert differences[0] < 6e-3
    assert differences[0] / differences[1] == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize(("name", "law"), [case for case in CASES if case[1] != "jmdc"])
def test_the_integrators_agree_in_the_task(name, law):
    one, other = (run_of(name, law, integrator) for integrator in integrators.available())
    # Either is within 0.4 mm of the same line.
    assert np.linalg.norm(one.x[:, :3] - other.x[:, :3], axis=1).max() < 0.5e-3


@pytest.mark.parametrize("name", MOTIONS)
def test_fine_euler_steps_converge_to_the_recorded_motion_under_the_recorded_torque(name):
    run, plant, misses = run_of(name, "jmdc"), RigidBodyPlant(arm_of(name)), []
    for parts in (4, 8, 16):
        q, v = run.q[0], run.v[0]
        for tau in run.tau[:100]:
            for _ in range(parts):
                q, v = SemiImplicitEuler().step(plant, q, v, tau, DT / parts)
        misses.append(np.linalg.norm(run.arm.difference(run.q[100], q)))
    np.testing.assert_allclose(np.divide(misses[:-1], misses[1:]), 2.0, atol=0.1)


def test_rk4_converges_at_fourth_order_on_continuous_joints():
    arm, plant = arm_of("kinova"), RigidBodyPlant(arm_of("kinova"))
    tau = arm.state(arm.configuration(MOTIONS["kinova"].start), np.zeros(6)).nle

    def end(steps):
        q, v = arm.configuration(MOTIONS["kinova"].start), np.array([2.0, 0.3, -0.4, 3.0, 0.5, -2.0])
        for _ in range(steps):
            q, v = RungeKutta4().step(plant, q, v, tau, 0.04 / steps)
        return q

    fine = end(320)
    misses = [np.linalg.norm(arm.difference(end(steps), fine)) for steps in (10, 20, 40)]
    np.testing.assert_allclose(np.log2(np.divide(misses[:-1], misses[1:])), 4.0, atol=0.3)


# Continuous joints


@pytest.mark.parametrize("integrator", integrators.available())
@pytest.mark.parametrize("law", LAWS)
def test_cosines_and_sines_keep_their_length(law, integrator):
    run = run_of("kinova", law, integrator)
    assert run.q.shape == (501, 9)
    circles = [joint.idx_q for joint in run.arm.model.joints[1:] if joint.nq == 2]
    assert len(circles) == 3
    for index in circles:
        # Measured: one unit in the last place.
        np.testing.assert_allclose(np.hypot(run.q[:, index], run.q[:, index + 1]), 1.0, rtol=0, atol=1e-15)


def test_many_turns_of_a_continuous_joint_do_not_wear_it_out():
    arm, plant = arm_of("kinova"), RigidBodyPlant(arm_of("kinova"))
    q, step = arm.configuration(MOTIONS["kinova"].start), np.array([0.1, 0.0, 0.0, -0.3, 0.0, 0.7])
    for _ in range(20_000):
        q = plant.integrate(q, step)
    positions = arm.positions(q)
    expected = arm.positions(arm.configuration(np.array(MOTIONS["kinova"].start) + 20_000 * step))
    # Every step rounds an angle of order 1.
    np.testing.assert_allclose(np.sin(positions - expected), 0.0, atol=20_000 * np.finfo(float).eps)
    np.testing.assert_allclose([np.hypot(*q[:2]), np.hypot(*q[4:6]), np.hypot(*q[7:])], 1.0, rtol=0, atol=1e-15)
