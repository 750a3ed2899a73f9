import mujoco
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from aspect_control import Arm, StraightLine, controllers, simulate
from aspect_control.exceptions import NonFiniteError, ParameterError, ShapeError, UnknownNameError
from aspect_control.plants import RigidBodyPlant
from aspect_control.resources import model_path
from aspect_control.simulation import Diverged, Integrator, RungeKutta4, SemiImplicitEuler, integrators

ARM = Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0, 0, 0))
HANGING = Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0, -9.81, 0))
A = StraightLine([1.5, 1.0], duration=2.0)
Q0 = np.deg2rad([-50.0, 140.0, -140.0])
LAWS = ("pseudoinverse", "null-space-vector", "modified-null-space-vector", "jmdc")

angles = st.lists(st.floats(-np.pi, np.pi), min_size=3, max_size=3).map(np.array)
speeds = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3).map(np.array)
torques = st.lists(st.floats(-50.0, 50.0), min_size=3, max_size=3).map(np.array)


class Idle(controllers.Controller):
    """No torque at all; remembers how it was called."""

    name = "idle"

    def __init__(self, arm):
        super().__init__(arm, arm.nv, 0.0, 0.0)
        self.resets, self.targets = [], []

    def start(self, q, v, dt):
        self.resets.append((q, v, dt))

    def command(self, state, target):
        self.targets.append(target)
        return np.zeros(self.arm.nv)


def law(name, **parameters):
    return controllers.create(name, ARM, **parameters)


def three_rods(q, v, tau):
    """Joint acceleration of the paper's arm by Lagrange's equations in the rods' absolute angles, without gravity.

    A rod of 10 kg and 1 m about its middle has 10/12 kg m²; for such a chain M_ij = A_ij cos(φ_i − φ_j) and the
    centrifugal terms are A_ij sin(φ_i − φ_j) φ̇_j².
    """
    A_ij = 10.0 * np.array([[7 / 3, 3 / 2, 1 / 2], [3 / 2, 4 / 3, 1 / 2], [1 / 2, 1 / 2, 1 / 3]])
    phi, omega = np.cumsum(q), np.cumsum(v)
    between = phi[:, None] - phi[None, :]
    force = tau - np.append(tau[1:], 0.0) - A_ij * np.sin(between) @ omega**2
    return np.diff(np.linalg.solve(A_ij * np.cos(between), force), prepend=0.0)


def integrate(integrator, plant, q, v, tau, dt, steps):
    for _ in range(steps):
        q, v = integrator.step(plant, q, v, tau, dt)
        yield q, v


def free_motion(integrator, plant, q, v, dt, duration):
    return list(integrate(integrator, plant, q, v, np.zeros(3), dt, round(duration / dt)))


def energy_error(integrator, plant, q, v, dt, duration):
    start = plant.energy(q, v)
    return max(abs(plant.energy(*state) - start) for state in free_motion(integrator, plant, q, v, dt, duration))


# The plant


@given(q=angles, v=speeds, tau=torques)
def test_plant_acceleration_solves_the_equation_of_motion(q, v, tau):
    state = HANGING.state(q, v)
    expected = np.linalg.solve(state.M, tau - state.nle)
    # Backward stable both ways: the error is the condition number of M, at most 310 for this arm, times rounding.
    tolerance = 310 * 20 * np.finfo(float).eps * (np.abs(expected).max() + np.abs(tau).max() + np.abs(state.nle).max())
    np.testing.assert_allclose(RigidBodyPlant(HANGING).acceleration(q, v, tau), expected, rtol=0, atol=tolerance)


@given(q=angles, v=speeds, tau=torques)
def test_plant_acceleration_is_that_of_three_uniform_rods(q, v, tau):
    expected = three_rods(q, v, tau)
    tolerance = 310 * 20 * np.finfo(float).eps * (np.abs(expected).max() + np.abs(tau).max() + 100.0)
    np.testing.assert_allclose(RigidBodyPlant(ARM).acceleration(q, v, tau), expected, rtol=0, atol=tolerance)


def test_plant_does_not_disturb_the_arm_s_buffers():
    before = ARM.state(Q0, np.ones(3))
    M, J = before.M.copy(), before.J.copy()
    RigidBodyPlant(ARM).acceleration(-Q0, np.zeros(3), np.ones(3))
    np.testing.assert_array_equal(before.M, M)
    np.testing.assert_array_equal(before.J, J)


# Energy


@settings(max_examples=40)
@given(q=angles, v=speeds)
def test_rk4_keeps_the_energy_of_a_free_arm(q, v):
    plant, dt = RigidBodyPlant(ARM), 1e-3
    energy, states = plant.energy(q, v), free_motion(RungeKutta4(), plant, q, v, dt, 0.25)
    # One step of RK4 misses by (ω dt)⁵/120 of the state and by twice that of the energy, which is quadratic in it, and
    # by rounding; 250 steps add up. The fastest rate ω of the motion is what its speeds and accelerations amount to.
    omega = max(
        np.abs(v).sum() + np.abs(plant.acceleration(q, v, np.zeros(3))).sum() ** 0.5 for q, v in [(q, v), *states]
    )
    tolerance = 250 * (2.0 * (omega * dt) ** 5 / 120 + 2.0 * np.finfo(float).eps)
    assert max(abs(plant.energy(*state) - energy) for state in states) <= tolerance * energy


def test_rk4_loses_energy_at_fourth_order_under_gravity():
    q, v, plant = np.array([0.3, 0.8, -0.5]), np.array([1.0, -2.0, 1.5]), RigidBodyPlant(HANGING)
    coarse, fine = (energy_error(RungeKutta4(), plant, q, v, dt, 0.24) for dt in (4e-3, 2e-3))
    assert np.log2(coarse / fine) == pytest.approx(4.0, abs=0.2)


@settings(max_examples=40)
@given(q=angles, v=speeds)
def test_semi_implicit_euler_misses_the_energy_at_first_order(q, v):
    plant = RigidBodyPlant(ARM)
    coarse, fine = (energy_error(SemiImplicitEuler(), plant, q, v, dt, 0.25) for dt in (1e-3, 5e-4))
    # Half the step halves the error up to its own second order. Where symmetry takes the first order away there is
    # less than half left, and of a steady rotation only rounding.
    assert fine <= 0.55 * coarse + 1e-12 * plant.energy(q, v)


def test_semi_implicit_euler_does_not_heat_up_a_swinging_arm():
    plant, rest, hanging = RigidBodyPlant(HANGING), np.zeros(3), np.array([-np.pi / 2, 0.0, 0.0])
    q = hanging + np.array([0.3, 0.2, -0.1])
    swing = plant.energy(q, rest) - plant.energy(hanging, rest)
    # The explicit Euler method, as far off after a single step, heats this swing up by 21 % in the same time.
    assert energy_error(SemiImplicitEuler(), plant, q, rest, 1e-3, 20.0) < 0.01 * swing


def test_semi_implicit_euler_moves_the_configuration_by_the_new_velocity():
    q, v, tau = np.array([0.3, 0.8, -0.5]), np.array([1.0, -2.0, 1.5]), np.array([10.0, -5.0, 3.0])
    plant = RigidBodyPlant(ARM)
    new_q, new_v = SemiImplicitEuler().step(plant, q, v, tau, 0.01)
    np.testing.assert_allclose(new_v, v + 0.01 * three_rods(q, v, tau), rtol=1e-12)
    np.testing.assert_allclose(new_q, q + 0.01 * new_v, rtol=1e-15)


# Order of convergence


@pytest.fixture(scope="module")
def reference_motion():
    tau, start = np.array([10.0, -5.0, 3.0]), np.array([0.3, 0.8, -0.5, 1.0, -2.0, 1.5])
    solution = solve_ivp(
        lambda _, y: np.concatenate([y[3:], three_rods(y[:3], y[3:], tau)]),
        (0.0, 0.5),
        start,
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    )
    return tau, start, solution.y[:, -1]


@pytest.mark.parametrize(
    ("integrator", "order", "steps"),
    [(RungeKutta4(), 4.0, (100, 200, 400)), (SemiImplicitEuler(), 1.0, (500, 1000, 2000))],
    ids=lambda value: getattr(value, "name", None),
)
def test_integrators_converge_at_their_order(reference_motion, integrator, order, steps):
    tau, start, end = reference_motion
    errors = []
    for count in steps:
        *_, (q, v) = integrate(integrator, RigidBodyPlant(ARM), start[:3], start[3:], tau, 0.5 / count, count)
        errors.append(np.linalg.norm(np.concatenate([q, v]) - end))
    measured = np.log2(np.divide(errors[:-1], errors[1:]))
    # What the measured order is off by is of the order of the step, which halves from one pair to the next.
    np.testing.assert_allclose(measured, order, atol=0.1)
    assert abs(measured[1] - order) < abs(measured[0] - order)


# The loop


@pytest.mark.parametrize("duration", [0.3, 0.6, 1.4])
@pytest.mark.parametrize(("dt", "per_tenth"), [(1e-3, 100), (5e-4, 200), (1e-4, 1000)])
def test_number_of_samples_is_the_duration_over_dt_plus_one(duration, dt, per_tenth):
    run = simulate(Idle(ARM), StraightLine([0.1, 0.1], duration), q0=Q0, dt=dt)
    assert len(run.t) == round(duration * 10) * per_tenth + 1


def test_the_last_sample_is_the_last_one_inside_the_motion():
    run = simulate(Idle(ARM), A, q0=Q0, dt=0.7e-3, events=())
    assert len(run.t) == 2858
    assert run.t[-1] <= 2.0 < run.t[-1] + 0.7e-3


@settings(max_examples=50)
@given(mantissa=st.integers(1, 999), exponent=st.integers(1, 6), steps=st.integers(1, 60))
def test_rounding_never_changes_the_number_of_samples(mantissa, exponent, steps):
    line = StraightLine([0.1, 0.1], duration=float(f"{mantissa * steps}e-{exponent}"))
    assert len(simulate(Idle(ARM), line, q0=Q0, dt=float(f"{mantissa}e-{exponent}")).t) == steps + 1


def test_a_single_step_may_be_as_long_as_the_motion():
    np.testing.assert_array_equal(simulate(Idle(ARM), A, q0=Q0, dt=2.0).t, [0.0, 2.0])


def test_all_recorded_arrays_have_the_documented_shapes(runs):
    run = runs["pseudoinverse"]
    assert run.t.shape == (2001,)
    assert {run.q.shape, run.v.shape, run.tau.shape} == {(2001, 3)}
    assert {run.x_desired.shape, run.dx_desired.shape, run.ddx_desired.shape} == {(2001, 2)}


@pytest.mark.parametrize("integrator", integrators.available())
@pytest.mark.parametrize("name", LAWS)
def test_replaying_the_recorded_torque_gives_the_recorded_motion_back(name, integrator):
    run = simulate(law(name), StraightLine([0.3, 0.2], 0.4), q0=Q0, v0=[0.1, -0.2, 0.3], dt=2e-3, integrator=integrator)
    plant, method = RigidBodyPlant(ARM), integrators.create(integrator)
    for i in range(len(run.t) - 1):
        q, v = method.step(plant, run.q[i], run.v[i], run.tau[i], 2e-3)
        np.testing.assert_array_equal([q, v], [run.q[i + 1], run.v[i + 1]])


def test_the_recorded_torque_is_the_law_s_at_the_recorded_state():
    run, again = simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02), law("pseudoinverse")
    start = ARM.task_position(Q0)
    expected = [again.torque(q, v, A.target(t, start)) for t, q, v in zip(run.t, run.q, run.v, strict=True)]
    np.testing.assert_array_equal(run.tau, expected)


def test_the_motion_starts_at_q0_and_v0():
    run = simulate(Idle(ARM), A, q0=Q0, v0=[0.1, -0.2, 0.3], dt=0.5)
    np.testing.assert_array_equal([run.q[0], run.v[0]], [Q0, [0.1, -0.2, 0.3]])


def test_without_v0_it_starts_at_rest():
    np.testing.assert_array_equal(simulate(Idle(ARM), A, q0=Q0, dt=0.5).v[0], np.zeros(3))


def test_the_trajectory_starts_where_q0_puts_the_tool():
    run = simulate(Idle(ARM), A, q0=Q0, dt=0.5)
    np.testing.assert_array_equal(run.x_desired[0], ARM.task_position(Q0))


def test_the_law_is_reset_once_with_the_start():
    idle = Idle(ARM)
    simulate(idle, A, q0=Q0, v0=[0.1, -0.2, 0.3], dt=0.5)
    ((q, v, dt),) = idle.resets
    np.testing.assert_array_equal([q, v], [Q0, [0.1, -0.2, 0.3]])
    assert dt == 0.5


def test_a_law_with_memory_runs_twice_alike():
    jmdc = law("jmdc")
    assert simulate(jmdc, A, q0=Q0, dt=0.02) == simulate(jmdc, A, q0=Q0, dt=0.02)


def test_the_caller_s_arrays_are_left_alone():
    q0, v0 = Q0.copy(), np.array([0.1, -0.2, 0.3])
    run = simulate(law("jmdc"), A, q0=q0, v0=v0, dt=0.02)
    np.testing.assert_array_equal([q0, v0], [Q0, [0.1, -0.2, 0.3]])
    assert not np.shares_memory(run.q, q0)


def test_progress_grows_to_one():
    parts = []
    simulate(Idle(ARM), A, q0=Q0, events=(), progress=parts.append)
    assert parts == sorted(parts)
    assert 0.0 < parts[0] < 0.05
    assert parts[-1] == 1.0
    assert 90 <= len(parts) <= 110


def test_progress_ends_at_one_for_a_run_that_diverges():
    parts = []
    run = simulate(law("null-space-vector"), A, q0=Q0, dt=0.2, events=[Diverged()], progress=parts.append)
    assert run.status == "diverged"
    assert parts == sorted(parts)
    assert parts[-1] == 1.0


@pytest.mark.parametrize("integrator", [RungeKutta4, SemiImplicitEuler])
def test_an_integrator_is_taken_by_name_and_by_instance(integrator):
    by_name = simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, integrator=integrator.name)
    assert by_name.info.integrator == integrator.name
    assert by_name == simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, integrator=integrator())


def test_an_integrator_of_one_s_own_can_be_given():
    class Frozen(Integrator):
        name = "frozen"

        def step(self, plant, q, v, tau, dt):
            return q, v

    run = simulate(law("pseudoinverse"), A, q0=Q0, dt=0.02, integrator=Frozen(), events=())
    assert run.info.integrator == "frozen"
    np.testing.assert_array_equal(run.q, np.tile(Q0, (101, 1)))


def test_how_the_run_came_about_is_recorded():
    info = simulate(law("jmdc", kappa=0.002), A, q0=Q0, dt=0.02).info
    assert (info.controller, info.dt, info.integrator, info.status) == ("jmdc", 0.02, "rk4", "finished")
    assert info.parameters == {"kp": 100.0, "kv": 20.0, "kappa": 0.002, "criterion": "minor-measure"}
    assert info.trajectory == repr(A)
    assert set(info.versions) == {"python", "aspect-control", "pin", "numpy"}


def test_a_simulation_is_silent(capfd):
    simulate(law("null-space-vector"), A, q0=Q0, dt=0.2)
    assert capfd.readouterr() == ("", "")


# Runs that diverge


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("null-space-vector", {"dt": 0.2}),
        ("pseudoinverse", {"dt": 0.2}),
        ("jmdc", {"dt": 0.2}),
        ("null-space-vector", {"v0": [1e3, 0.0, 0.0]}),
        ("modified-null-space-vector", {"v0": [1e3, 0.0, 0.0]}),
    ],
)
def test_a_run_that_diverges_ends_there_and_says_when(name, options):
    run = simulate(law(name), A, q0=Q0, events=[Diverged()], **options)
    assert run.status == "diverged"
    assert run.message.startswith(f"diverged at t = {run.t[-1]:.6g} s: joint ")
    recorded = (run.q, run.v, run.tau, run.x_desired, run.dx_desired, run.ddx_desired)
    assert all(len(array) == len(run.t) < 2001 for array in recorded)
    assert all(np.isfinite(array).all() for array in recorded)


@pytest.mark.parametrize("name", LAWS)
def test_only_the_last_sample_of_a_diverged_run_is_beyond_the_speed(name):
    run = simulate(law(name), A, q0=Q0, dt=0.2, events=[Diverged()])
    assert run.status == "diverged"
    assert np.abs(run.v[:-1]).max() <= Diverged().speed < np.abs(run.v[-1]).max()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("name", LAWS)
def test_the_fastest_start_diverges_without_a_warning(name, sign):
    # Warnings are errors in this test suite.
    run = simulate(law(name), A, q0=Q0, v0=np.full(3, sign * Diverged().speed))
    assert (run.status, len(run.t)) == ("diverged", 2)
    assert np.isfinite(run.tau).all()


@pytest.mark.parametrize("speed", [1e6, -1e40])
@pytest.mark.parametrize("name", LAWS)
def test_a_start_faster_than_any_arm_diverges_without_a_warning_if_no_event_ends_it(name, speed):
    run = simulate(law(name), A, q0=Q0, v0=np.full(3, speed), events=())
    assert run.status == "diverged"
    assert all(np.isfinite(array).all() for array in (run.q, run.v, run.tau))


# What is refused


@pytest.mark.parametrize("q0", [[0.0, 0.0], [0.0] * 4, [[0.0, 0.0, 0.0]], 0.0, "home", None])
def test_a_start_of_the_wrong_shape_is_refused(q0):
    with pytest.raises(ShapeError, match="q0 must"):
        simulate(Idle(ARM), A, q0=q0)


@pytest.mark.parametrize("v0", [[0.0, 0.0], [0.0] * 4, [[0.0, 0.0, 0.0]], 0.0, "fast"])
def test_a_starting_velocity_of_the_wrong_shape_is_refused(v0):
    with pytest.raises(ShapeError, match="v0 must"):
        simulate(Idle(ARM), A, q0=Q0, v0=v0)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["q0", "v0"])
def test_a_start_that_is_not_finite_is_refused(name, value):
    with pytest.raises(NonFiniteError, match=f"{name} must be finite"):
        simulate(Idle(ARM), A, **{"q0": Q0, name: [0.0, value, 0.0]})


@pytest.mark.parametrize("v0", [[1.1e3, 0.0, 0.0], [0.0, -1.1e6, 0.0]])
def test_a_start_that_has_diverged_already_is_a_run_of_one_sample(v0):
    run = simulate(Idle(ARM), A, q0=Q0, v0=v0)
    assert (run.status, len(run.t)) == ("diverged", 1)
    np.testing.assert_array_equal(run.v, [v0])


@pytest.mark.parametrize("speed", [1e160, 1e308])
@pytest.mark.parametrize("name", LAWS)
def test_a_start_at_which_the_torque_overflows_is_refused(name, speed):
    with pytest.raises(NonFiniteError, match=r"v0 must be at most 1e\+50 in magnitude, got \[1e\+\d+"):
        simulate(law(name), A, q0=Q0, v0=np.full(3, speed))


@pytest.mark.parametrize("dt", [0.0, -1e-3, np.nan, np.inf, 2.1, 1e-12, 5e-324, "short", None])
def test_a_sampling_time_that_makes_no_sense_is_refused(dt):
    with pytest.raises(ParameterError, match="dt"):
        simulate(Idle(ARM), A, q0=Q0, dt=dt)


def test_a_sampling_time_that_is_too_short_is_refused_with_one_that_is_not():
    with pytest.raises(ParameterError, match="give at least 1e-07 s"):
        simulate(Idle(ARM), A, q0=Q0, dt=1e-12)


def test_a_trajectory_for_another_task_is_refused():
    with pytest.raises(ShapeError, match="trajectory has 3 task coordinates"):
        simulate(Idle(ARM), StraightLine([1.0, 0.0, 0.0], 2.0), q0=Q0)


def test_an_unknown_integrator_is_refused_with_those_that_exist():
    with pytest.raises(UnknownNameError, match=r"'rk5'.*did you mean 'rk4'.*'semi-implicit-euler'"):
        simulate(Idle(ARM), A, q0=Q0, integrator="rk5")


# Trajectory A, the paper's Figs. 2 to 4: 1 kHz, the torque held between samples


@pytest.fixture(scope="module")
def runs():
    return {name: simulate(law(name), A, q0=Q0) for name in LAWS}


def crossings(run):
    """Times at which each minor has just changed its sign."""
    return [run.t[1:][np.diff(np.sign(minor)) != 0] for minor in run.minors.T]


@pytest.mark.parametrize("name", LAWS)
def test_trajectory_a_is_finished(runs, name):
    assert (runs[name].status, runs[name].message) == ("finished", "finished at t = 2 s")


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("pseudoinverse", 1e-4),
        ("modified-null-space-vector", 1e-4),
        ("null-space-vector", 0.01),  # holding 39 kN m for 1 ms
        ("jmdc", 0.01),  # follows the velocity one sample late: at most 1.8 m/s for 1 ms in each direction
    ],
)
def test_every_law_tracks_trajectory_a(runs, name, error):
    assert runs[name].tracking_error.max() < error


@pytest.mark.parametrize(("window", "paper", "joint_1"), [((1.1, 1.4), 1.25, 1738.03), ((1.6, 2.0), 1.8, 39111.6)])
def test_null_space_vector_torque_explodes_twice_just_after_a_zero_of_a_minor(runs, window, paper, joint_1):
    run = runs["null-space-vector"]
    size = np.abs(run.tau).max(axis=1)
    inside = np.flatnonzero((run.t >= window[0]) & (run.t <= window[1]))
    peak = inside[size[inside].argmax()]
    assert inside[0] < peak < inside[-1]
    assert run.t[peak] == pytest.approx(paper, abs=0.011)
    # What this sampling gives; the number itself is tested against the limit of continuous time below.
    assert size[peak] == pytest.approx(joint_1, rel=1e-3)
    delays = run.t[peak] - crossings(run)[1]
    assert np.any((delays > 0.0) & (delays < 0.12))


def test_null_space_vector_torque_is_low_between_its_two_peaks(runs):
    run = runs["null-space-vector"]
    between = (run.t > 1.4) & (run.t < 1.6)
    assert np.abs(run.tau[between]).max() < 0.02 * np.abs(run.tau[run.t < 1.4]).max()


def test_null_space_vector_torque_is_physically_unachievable(runs):
    assert np.abs(runs["null-space-vector"].tau).max() > 1e4


def test_null_space_vector_leaves_its_aspect(runs):
    assert all(len(times) > 0 for times in crossings(runs["null-space-vector"]))


@pytest.mark.parametrize(("name", "limit"), [("modified-null-space-vector", 20.0), ("jmdc", 17.0)])
def test_the_two_cures_keep_the_aspect_and_the_torque_low(runs, name, limit):
    assert all(len(times) == 0 for times in crossings(runs[name]))
    assert np.abs(runs[name].tau).max() < limit


def test_pseudoinverse_leaves_its_aspect_late(runs):
    first, second, third = crossings(runs["pseudoinverse"])
    assert (len(first), len(second)) == (0, 0)
    assert third == pytest.approx([1.79], abs=1.5e-3)
    assert np.abs(runs["pseudoinverse"].tau).max() == pytest.approx(46.5, abs=0.1)


def test_modified_law_first_switches_the_null_space_term_on_at_the_jump(runs):
    run = runs["modified-null-space-vector"]
    assert run.t[run.null_space_term_on][0] == 1.0


def test_modified_law_chatters_once_the_self_motion_has_come_to_rest(runs):
    run = runs["modified-null-space-vector"]
    switched = run.t[1:][np.diff(run.null_space_term_on)]
    assert np.count_nonzero(switched < 1.17) == 1
    assert np.count_nonzero(switched > 1.17) > 50
    resting = np.linalg.norm(run.homogeneous_velocity[run.t > 1.17], axis=1).max()
    assert resting < 0.01 * np.linalg.norm(run.homogeneous_velocity, axis=1).max()


def test_modified_law_s_torque_jumps_while_it_chatters(runs):
    run = runs["modified-null-space-vector"]
    tau = run.tau[run.t > 1.17]
    # Sample to sample it jumps by about as much as it is large: between the torques of Eqs. (13) and (14).
    assert np.abs(tau).max() == pytest.approx(18.02, abs=0.01)
    assert np.abs(np.diff(tau, axis=0)).max() == pytest.approx(16.96, abs=0.05)


def test_jmdc_hardly_needs_the_minor_measure_on_trajectory_a(runs):
    with_it, without = runs["jmdc"], simulate(law("jmdc", kappa=0.0), A, q0=Q0)
    # κ = 0.001 against 0, as measured: 1.8e-4 rad at the end, 4.2e-4 m² of a minor, 0.042 N m of 17.
    assert np.abs(with_it.q - without.q).max() < 2e-4
    assert np.abs(with_it.minors - without.minors).max() < 5e-4
    # But for the second sample, where θ̇_d jumps from rest to κ(I − J⁺J)∇H within one dt: 1.07 N m.
    difference = np.abs(with_it.tau - without.tau).max(axis=1)
    assert difference[1] == pytest.approx(1.07, abs=0.01)
    assert np.delete(difference, 1).max() < 0.05


def test_mujoco_moves_the_same_way_under_the_same_torques(runs):
    run = runs["modified-null-space-vector"]
    # MuJoCo asks for positive principal inertias; turning about its own axis a rod of this arm never does.
    model = mujoco.MjModel.from_xml_string(ARM.description.urdf.replace('ixx="0"', 'ixx="0.001"'))
    model.opt.gravity[:], model.opt.timestep, model.opt.integrator = 0.0, 1e-3, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    data.qpos[:] = Q0
    for tau in run.tau[:-1]:
        data.qfrc_applied[:] = tau
        mujoco.mj_step(model, data)
    # The same method on the same equations: only rounding differs, 2000 steps of at most a few 1e-16 rad.
    np.testing.assert_allclose(data.qpos, run.q[-1], rtol=0, atol=2000 * 4 * np.finfo(float).eps)


# The limit of continuous time


class ContinuousNullSpaceVector:
    """Trajectory A under the literal Eq. (11), the torque following the state without delay."""

    def __init__(self):
        self.model = ARM.model
        self.data = self.model.createData()
        self.frame = self.model.getFrameId("tool")
        self.start = self.tool(Q0)
        options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-10, "dense_output": True}
        before = solve_ivp(lambda t, y: self.rate(t, y, 1), (0.0, 1.0), np.append(Q0, np.zeros(3)), **options)
        after = solve_ivp(lambda t, y: self.rate(t, y, -1), (1.0, 2.0), before.y[:, -1], **options)
        self.q_end, self.state_after_the_jump = after.y[:3, -1], after.sol

    def tool(self, q):
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.frame].translation[:2].copy()

    def law(self, t, y, half):
        """Return τ of Eq. (11) and θ̇_H·θ̈_H of Eqs. (15) and (16)."""
        q, v, aligned = y[:3], y[3:], pin.LOCAL_WORLD_ALIGNED
        M = pin.crba(self.model, self.data, q)
        M = np.triu(M) + np.triu(M, 1).T
        N = pin.nonLinearEffects(self.model, self.data, q, v)
        pin.computeJointJacobiansTimeVariation(self.model, self.data, q, v)
        x = self.tool(q)
        J = pin.getFrameJacobian(self.model, self.data, self.frame, aligned)[:2]
        dJ = pin.getFrameJacobianTimeVariation(self.model, self.data, self.frame, aligned)[:2]
        a = np.array([1.5, 1.0])
        x_d = self.start + (a * t**2 / 2 if half > 0 else a * (1.0 - (2.0 - t) ** 2 / 2))
        dx_d = a * t if half > 0 else a * (2.0 - t)
        J_pinv = np.linalg.pinv(J)
        P = np.eye(3) - J_pinv @ J
        tau_tilde = M @ J_pinv @ (half * a + 20.0 * (dx_d - J @ v) + 100.0 * (x_d - x) - dJ @ v) + N
        theta_ddot_H = -np.linalg.pinv(M @ P, rcond=1e-9) @ tau_tilde
        return tau_tilde + M @ theta_ddot_H, (P @ v) @ theta_ddot_H

    def rate(self, t, y, half):
        return np.append(y[3:], pin.aba(self.model, self.data, y[:3], y[3:], self.law(t, y, half)[0]))

    def peak(self, quantity):
        """Return time and value of the largest value of a quantity of the law about t = 1.8 s."""
        found = minimize_scalar(
            lambda t: -quantity(*self.law(t, self.state_after_the_jump(t), -1)),
            bounds=(1.79, 1.80),
            method="bounded",
            options={"xatol": 1e-8},
        )
        return found.x, -found.fun


def sampled_peak(t, values):
    """The top of the parabola through the largest sample and its neighbours."""
    i = int(values.argmax())
    a, b, c = np.polyfit(t[i - 1 : i + 2] - t[i], values[i - 1 : i + 2], 2)
    return c - b**2 / (4.0 * a)


@pytest.fixture(scope="module")
def continuous():
    return ContinuousNullSpaceVector()


@pytest.fixture(scope="module")
def ever_finer(runs):
    finer = [simulate(law("null-space-vector"), A, q0=Q0, dt=dt) for dt in (5e-4, 2.5e-4, 1.25e-4)]
    return [runs["null-space-vector"], *finer]


def assert_first_order(errors):
    """Each halving of dt halves the error, the better the smaller dt is.

    With the error c₁dt + c₂dt² + … the ratio is 2 − O(dt): not 2 at once, but nearer and nearer.
    """
    ratios = np.divide(errors[:-1], errors[1:])
    misses = np.abs(ratios - 2.0)
    assert np.all(np.diff(misses) < 0.0), ratios
    assert misses[-1] < 0.2, ratios


def test_the_torque_of_continuous_time_peaks_where_it_is_known_to(continuous):
    t, tau = continuous.peak(lambda tau, _: abs(tau[0]))
    # The known value was read off a grid of 1e-5 s, which misses a top that falls by 3 N m in 1e-5 s by up to 0.8 N m.
    assert t == pytest.approx(1.7956, abs=5e-5)
    assert tau == pytest.approx(45168.28, abs=1.0)


def test_the_product_of_continuous_time_peaks_where_it_is_known_to(continuous):
    t, product = continuous.peak(lambda _, product: product)
    assert t == pytest.approx(1.7949, abs=5e-5)
    assert product == pytest.approx(8.466e5, abs=50.0)


def test_the_end_of_the_null_space_vector_run_converges_to_continuous_time(continuous, ever_finer):
    assert_first_order([np.linalg.norm(run.q[-1] - continuous.q_end) for run in ever_finer])


def test_the_peak_of_maciejewski_s_product_converges_to_continuous_time(continuous, ever_finer):
    _, limit = continuous.peak(lambda _, product: product)
    assert_first_order([limit - sampled_peak(run.t, run.maciejewski_product) for run in ever_finer])
