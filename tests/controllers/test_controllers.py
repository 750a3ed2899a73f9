"""The torque laws against the paper's equations as printed, and what they say to bad input."""

import contextlib
import itertools

import numpy as np
import pytest

from aspect_control import Arm, Target, controllers
from aspect_control.exceptions import (
    AspectBorderWarning,
    ControllerNotFoundError,
    NonFiniteError,
    NotRedundantError,
    NotResetError,
    ParameterError,
    ShapeError,
    UnknownNameError,
)
from oracles import planar_reference as reference
from oracles.literal import Printed

LAWS = {
    "jmdc": controllers.JMinorDynamicControl,
    "modified-null-space-vector": controllers.ModifiedNullSpaceVector,
    "null-space-vector": controllers.NullSpaceVector,
    "pseudoinverse": controllers.Pseudoinverse,
}
TASK_SPACE_LAWS = [name for name in LAWS if name != "jmdc"]

every_law = pytest.mark.parametrize("law", LAWS)
every_task_space_law = pytest.mark.parametrize("law", TASK_SPACE_LAWS)

DT = 1e-3
REST = Target(np.zeros(2), np.zeros(2), np.zeros(2))
INSIDE = np.array([0.3, 0.4, 0.5])  # a posture of the planar arm off the borders of its aspects


def random_samples(arm, count, seed):
    """Measured states and targets, away from singularities: I − J⁺J rounds like cond J."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q, v = rng.uniform(-np.pi, np.pi, arm.nv), rng.normal(0.0, 2.0, arm.nv)
        if np.linalg.cond(arm.jacobian(q)) < 100.0:
            yield q, v, Target(*rng.normal(0.0, 2.0, (3, arm.task_dim)))


def torques(controller, samples):
    """The law's torques at one sample after another, from rest at the first."""
    samples = list(samples)
    controller.reset(samples[0][0], np.zeros(controller.arm.nv), DT)
    return np.array([controller.torque(q, v, target) for q, v, target in samples])


def gain_dim(arm, law):
    return arm.nv if law == "jmdc" else arm.task_dim


def rounding(printed):
    """Every law subtracts or adds torques of this size, and rounds accordingly."""
    return 1e-10 * np.linalg.norm(printed.tau_tilde)


def gains(size):
    """Two positive definite matrices, neither symmetric."""
    rng = np.random.default_rng(0)
    p, v = rng.normal(0.0, 2.0, (2, size, size))
    return np.diag(rng.uniform(50.0, 150.0, size)) + p - p.T, np.diag(rng.uniform(10.0, 30.0, size)) + v - v.T


# The laws


def test_pseudoinverse_law_is_equation_7(arm):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.Pseudoinverse(arm, kp=Kp, kv=Kv)
    for q, v, target in random_samples(arm, 200, seed=1):
        printed = Printed(arm, q, v, target, Kp, Kv)
        np.testing.assert_allclose(controller.torque(q, v, target), printed.tau_tilde, rtol=0, atol=rounding(printed))


def test_null_space_vector_law_is_equation_11(arm):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.NullSpaceVector(arm, kp=Kp, kv=Kv)
    for q, v, target in random_samples(arm, 200, seed=2):
        printed = Printed(arm, q, v, target, Kp, Kv)
        np.testing.assert_allclose(controller.torque(q, v, target), printed.tau_minimum, rtol=0, atol=rounding(printed))


def test_modified_law_takes_equation_13_or_14_by_the_sign_of_equation_12(arm):
    Kp, Kv = gains(arm.task_dim)
    controller = controllers.ModifiedNullSpaceVector(arm, kp=Kp, kv=Kv)
    taken = {13: 0, 14: 0}
    for q, v, target in random_samples(arm, 400, seed=3):
        printed = Printed(arm, q, v, target, Kp, Kv)
        equation, expected = (13, printed.tau_tilde) if printed.product >= 0.0 else (14, printed.tau_minimum)
        np.testing.assert_allclose(controller.torque(q, v, target), expected, rtol=0, atol=rounding(printed))
        taken[equation] += 1
    assert min(taken.values()) > 50


def test_modified_law_applies_no_null_space_torque_at_rest(arm):
    controller, plain = controllers.ModifiedNullSpaceVector(arm), controllers.Pseudoinverse(arm)
    for q, _, target in random_samples(arm, 50, seed=4):
        rest = np.zeros(arm.nv)
        np.testing.assert_array_equal(controller.torque(q, rest, target), plain.torque(q, rest, target))


def printed_jmdc(samples, q0, v0, Kp, Kv, kappa):
    """Equations (17)–(21) on the closed-form arm, by lists indexed with i as in the paper."""
    theta_d, dtheta_d = [q0], [v0]
    for i, (q, v, target) in enumerate(samples):
        ddtheta_d = (dtheta_d[i] - dtheta_d[i - 1]) / DT if i > 0 else np.zeros(3)
        feedback = Kv @ (dtheta_d[i] - v) + Kp @ (theta_d[i] - q)
        yield reference.inertia(q) @ (ddtheta_d + feedback) + reference.nonlinear_effects(q, v)
        J = reference.jacobian(q)
        J_pinv = np.linalg.pinv(J)
        climb = (np.eye(3) - J_pinv @ J) @ reference.minor_measure_gradient(q)
        theta_d.append(theta_d[i] + dtheta_d[i] * DT)
        dtheta_d.append(J_pinv @ target.dx + kappa * climb)


@pytest.mark.parametrize("kappa", [0.0, 0.001, 2.0])
@pytest.mark.parametrize("v0", [np.zeros(3), np.array([0.5, -1.0, 2.0])], ids=["from rest", "moving"])
def test_jmdc_is_equations_17_to_21(planar, kappa, v0):
    Kp, Kv = gains(3)
    controller = controllers.JMinorDynamicControl(planar, kp=Kp, kv=Kv, kappa=kappa)
    samples = list(random_samples(planar, 100, seed=5))
    q0 = np.array([0.1, 0.2, 0.3])
    controller.reset(q0, v0, DT)
    for (q, v, target), expected in zip(samples, printed_jmdc(samples, q0, v0, Kp, Kv, kappa), strict=True):
        # θ̈_d divides a difference of speeds by dt, and with it their rounding: 1e3 times 1e-16 and some to spare.
        tolerance = 1e-12 * (1.0 + np.linalg.norm(expected))
        np.testing.assert_allclose(controller.torque(q, v, target), expected, rtol=0, atol=tolerance)


def test_jmdc_starts_afresh_at_every_reset(arm):
    samples = list(random_samples(arm, 5, seed=6))
    controller = controllers.JMinorDynamicControl(arm)
    first = torques(controller, samples)
    np.testing.assert_array_equal(torques(controller, samples), first)


def test_jmdc_ignores_the_targets_position_and_acceleration(planar):
    samples = list(random_samples(planar, 5, seed=7))
    moved = [(q, v, Target(target.x + 1.0, target.dx, target.ddx - 1.0)) for q, v, target in samples]
    controller = controllers.JMinorDynamicControl(planar)
    np.testing.assert_array_equal(torques(controller, samples), torques(controller, moved))


def test_jmdc_holds_a_resting_arm_still_without_the_minor_measure(planar):
    q, rest = np.array([0.3, 0.7, -1.1]), np.zeros(3)
    controller = controllers.JMinorDynamicControl(planar, kappa=0.0)
    np.testing.assert_array_equal(torques(controller, [(q, rest, REST)] * 5), np.zeros((5, 3)))


def test_jmdc_climbs_the_minor_measure_from_the_second_sample_on(planar):
    q, rest = np.array([0.3, 0.7, -1.1]), np.zeros(3)
    tau = torques(controllers.JMinorDynamicControl(planar, kappa=0.1), [(q, rest, REST)] * 2)
    np.testing.assert_array_equal(tau[0], 0.0)
    acceleration = np.linalg.solve(reference.inertia(q), tau[1])
    assert acceleration @ reference.minor_measure_gradient(q) > 0.0
    np.testing.assert_allclose(reference.jacobian(q) @ acceleration, 0.0, rtol=0, atol=1e-9)


def test_jmdc_needs_no_gradient_when_kappa_is_zero(planar, monkeypatch):
    monkeypatch.setattr(Arm, "jacobian_derivative", None)
    controller = controllers.JMinorDynamicControl(planar, kappa=0.0)
    assert np.isfinite(torques(controller, random_samples(planar, 3, seed=8))).all()


# Gains and parameters


@every_law
def test_scalar_vector_and_matrix_gains_are_one_law(arm, law):
    size = gain_dim(arm, law)
    forms = [(90.0, 15.0), ([90.0] * size, np.full(size, 15.0)), (90.0 * np.eye(size), 15.0 * np.eye(size))]
    samples = list(random_samples(arm, 10, seed=9))
    scalar, vector, matrix = (torques(controllers.create(law, arm, kp=kp, kv=kv), samples) for kp, kv in forms)
    np.testing.assert_array_equal(scalar, vector)
    np.testing.assert_array_equal(scalar, matrix)


@every_law
def test_gains_are_100_and_20_by_default(planar, law):
    parameters = controllers.create(law, planar).parameters
    assert (parameters["kp"], parameters["kv"]) == (100.0, 20.0)


@every_law
@pytest.mark.parametrize("form", ["scalar", "vector", "matrix"])
def test_parameters_construct_the_law_again(arm, law, form):
    Kp, Kv = gains(gain_dim(arm, law))
    kp, kv = {"scalar": (90.0, 15.0), "vector": (np.diag(Kp), np.diag(Kv)), "matrix": (Kp, Kv)}[form]
    extra = {"kappa": 0.02} if law == "jmdc" else {}
    controller = controllers.create(law, arm, kp=kp, kv=kv, **extra)
    again = controllers.create(law, arm, **controller.parameters)
    assert again.parameters == controller.parameters
    samples = list(random_samples(arm, 10, seed=10))
    np.testing.assert_array_equal(torques(again, samples), torques(controller, samples))


@every_law
def test_parameters_are_plain_numbers_and_lists(planar, law):
    Kp, Kv = gains(gain_dim(planar, law))
    for value in controllers.create(law, planar, kp=Kp, kv=np.diag(Kv)).parameters.values():
        leaves = np.ravel(np.array(value, dtype=object)).tolist()
        assert {type(leaf) for leaf in leaves} <= {float, str}


def test_zero_gains_are_allowed(planar):
    controller = controllers.Pseudoinverse(planar, kp=0.0, kv=0.0)
    target = Target([9.0, 9.0], [9.0, 9.0], [0.0, 0.0])
    np.testing.assert_array_equal(controller.torque([0.3, 0.7, -1.1], np.zeros(3), target), np.zeros(3))


@every_law
@pytest.mark.parametrize("name", ["kp", "kv"])
def test_gains_are_not_changed_by_the_callers_array(planar, law, name):
    gain = 5.0 * np.eye(gain_dim(planar, law))
    controller = controllers.create(law, planar, **{name: gain})
    gain[0, 0] = -7.0
    assert controller.parameters[name] == 5.0


def test_target_is_not_changed_by_its_callers_arrays():
    x = np.array([1.0, 2.0])
    target = Target(x, x, x)
    x[:] = 7.0
    assert target.x.tolist() == [1.0, 2.0]


BAD_GAINS = {
    "negative": (-1.0, ParameterError, "must not be negative"),
    "negative entry": ([1.0, -1.0], ParameterError, "must not be negative"),
    "indefinite matrix": ([[1.0, 5.0], [5.0, 1.0]], ParameterError, "must not be negative"),
    "nan": (np.nan, NonFiniteError, "must be finite"),
    "infinite entry": ([1.0, np.inf], NonFiniteError, "must be finite"),
    "long vector": (np.ones(5), ShapeError, r"scalar or have shape \(2,\) or \(2, 2\), got shape \(5,\)"),
    "wide matrix": (np.ones((2, 5)), ShapeError, r"got shape \(2, 5\)"),
    "text": ("high", ShapeError, "must be a number, a vector or a matrix, got 'high'"),
    "ragged": ([[1.0], [1.0, 2.0]], ShapeError, "must be a number, a vector or a matrix"),
}


@every_task_space_law
@pytest.mark.parametrize("name", ["kp", "kv"])
@pytest.mark.parametrize(("gain", "error", "message"), BAD_GAINS.values(), ids=BAD_GAINS)
def test_bad_gain_is_an_error(planar, law, name, gain, error, message):
    with pytest.raises(error, match=f"{name}.*{message}"):
        controllers.create(law, planar, **{name: gain})


@pytest.mark.parametrize("gain", [np.ones(2), np.eye(2)])
def test_jmdc_takes_joint_space_gains(planar, gain):
    with pytest.raises(ShapeError, match=r"kp must be a scalar or have shape \(3,\) or \(3, 3\)"):
        controllers.JMinorDynamicControl(planar, kp=gain)


@pytest.mark.parametrize("kappa", [-0.001, np.nan, np.inf, "small", None])
def test_bad_kappa_is_an_error(planar, kappa):
    with pytest.raises(ParameterError, match="kappa must be a"):
        controllers.JMinorDynamicControl(planar, kappa=kappa)


@every_law
def test_task_that_takes_up_every_joint_is_an_error(planar_path, law):
    arm = Arm.from_urdf(planar_path, frame="tool", task="xyz")
    with pytest.raises(NotRedundantError, match=rf"{law} needs .*3 coordinates, 'planar3r' has 3 joints.*at most 2"):
        controllers.create(law, arm)


@every_law
@pytest.mark.parametrize("axis", ["x", "y"])
def test_task_may_have_one_coordinate(planar_path, law, axis):
    arm = Arm.from_urdf(planar_path, frame="tool", task=(axis,), gravity=(0.0, 0.0, 0.0))
    for tau in torques(controllers.create(law, arm), random_samples(arm, 5, seed=11)):
        assert tau.shape == (3,)


# The registry


def test_registry_holds_the_paper_s_laws():
    assert set(LAWS) <= set(controllers.available())
    assert controllers.available() == tuple(sorted(controllers.available()))


@every_law
def test_registry_finds_each_law_by_its_name(planar, law):
    assert controllers.find(law) is LAWS[law]
    assert type(controllers.create(law, planar)) is LAWS[law]
    assert LAWS[law].name == law


def test_only_the_modified_law_switches():
    assert [law for law in LAWS if LAWS[law].switches] == ["modified-null-space-vector"]


def test_parameter_names_leave_the_arm_out():
    assert controllers.parameter_names(controllers.Pseudoinverse) == ("kp", "kv")
    assert controllers.parameter_names(controllers.JMinorDynamicControl) == ("kp", "kv", "kappa", "criterion")


def test_unknown_law_names_the_nearest_and_lists_all(planar):
    with pytest.raises(ControllerNotFoundError, match="unknown controller 'jmcd': did you mean 'jmdc'") as caught:
        controllers.create("jmcd", planar)
    assert caught.value.name == "jmcd"
    assert caught.value.available == controllers.available()
    assert all(repr(law) in str(caught.value) for law in LAWS)


def test_unknown_parameter_lists_those_that_exist(planar):
    message = "unknown parameter 'kapa' in 'jmdc': did you mean 'kappa'.*available: 'kp', 'kv', 'kappa'"
    with pytest.raises(UnknownNameError, match=message):
        controllers.create("jmdc", planar, kapa=0.1)


# Bad states and targets


def test_jmdc_without_reset_is_an_error(planar):
    with pytest.raises(NotResetError, match=r"call reset\(q, v, dt\) before the first torque"):
        controllers.JMinorDynamicControl(planar).torque(np.zeros(3), np.zeros(3), REST)


@every_task_space_law
def test_laws_without_memory_need_no_reset(planar, law):
    assert controllers.create(law, planar).torque([0.3, 0.7, -1.1], np.zeros(3), REST).shape == (3,)


@every_law
@pytest.mark.parametrize("dt", [0.0, -1e-3, np.nan, np.inf, "fast", None])
def test_reset_with_a_bad_sampling_time_is_an_error(planar, law, dt):
    with pytest.raises(ParameterError, match="dt must be a"):
        controllers.create(law, planar).reset(np.zeros(3), np.zeros(3), dt)


@every_law
def test_reset_with_a_bad_state_is_an_error(planar, law):
    controller = controllers.create(law, planar)
    with pytest.raises(ShapeError, match=r"q must have shape \(3,\), got \(2,\)"):
        controller.reset(np.zeros(2), np.zeros(3), DT)
    with pytest.raises(NonFiniteError, match="v must be finite"):
        controller.reset(np.zeros(3), [0.0, np.nan, 0.0], DT)


@every_law
def test_target_of_another_dimension_is_an_error(planar, law):
    controller = controllers.create(law, planar)
    controller.reset(INSIDE, np.zeros(3), DT)
    message = r"the target for the task \('x', 'y'\) must have an array as x and 2 rates, got .* 3"
    with pytest.raises(ShapeError, match=message):
        controller.torque(np.zeros(3), np.zeros(3), Target(*np.zeros((3, 3))))


@every_law
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_nonfinite_state_is_an_error(planar, law, bad):
    controller = controllers.create(law, planar)
    controller.reset(INSIDE, np.zeros(3), DT)
    with pytest.raises(NonFiniteError, match="q must be finite"):
        controller.torque([0.0, bad, 0.0], np.zeros(3), REST)
    with pytest.raises(NonFiniteError, match="v must be finite"):
        controller.torque(np.zeros(3), [0.0, 0.0, bad], REST)


@pytest.mark.parametrize("name", ["x", "dx", "ddx"])
def test_bad_target_is_an_error(name):
    good = {"x": np.zeros(2), "dx": np.zeros(2), "ddx": np.zeros(2)}
    with pytest.raises(NonFiniteError, match=rf"target\.{name} must be finite"):
        Target(**good | {name: [0.0, np.nan]})
    with pytest.raises(ShapeError, match="must have one shape"):
        Target(**good | {name: np.zeros(3)})
    with pytest.raises(ShapeError, match=rf"target\.{name} must have shape"):
        Target(**good | {name: 0.0})


# What holds for every law


@every_law
@pytest.mark.parametrize("q", list(itertools.product([0.0, np.pi], repeat=3)))
def test_torque_is_finite_at_singular_configurations(planar, law, q):
    v, target = np.array([1.0, -2.0, 3.0]), Target([1.0, 1.0], [1.0, -1.0], [1.0, 1.0])
    warned = pytest.warns(AspectBorderWarning, match="3 of 3 minors") if law == "jmdc" else contextlib.nullcontext()
    with warned:
        tau = torques(controllers.create(law, planar), [(q, v, target)] * 3)
    assert np.isfinite(tau).all()


@every_law
def test_torque_does_not_change_its_arguments(arm, law):
    (q, v, target), *_ = random_samples(arm, 5, seed=12)
    arrays = (q, v, target.x, target.dx, target.ddx)
    before = [array.copy() for array in arrays]
    controller = controllers.create(law, arm)
    controller.reset(q, v, DT)
    for _ in range(3):
        controller.torque(q, v, target)
    for array, copy in zip(arrays, before, strict=True):
        np.testing.assert_array_equal(array, copy)


@every_law
def test_law_does_not_keep_the_arrays_it_was_given(arm, law):
    samples = list(random_samples(arm, 4, seed=13))
    expected = torques(controllers.create(law, arm), samples)
    controller = controllers.create(law, arm)
    q_buffer, v_buffer = samples[0][0].copy(), np.zeros(arm.nv)
    controller.reset(q_buffer, v_buffer, DT)
    for (q, v, target), tau in zip(samples, expected, strict=True):
        q_buffer[:], v_buffer[:] = q, v
        np.testing.assert_array_equal(controller.torque(q_buffer, v_buffer, target), tau)


@every_law
@pytest.mark.parametrize("speed", [1e100, 1e150, 1e154, 1e155, 1e160, 1e200, 1e300])
def test_torque_is_finite_or_an_error_at_any_speed(planar, law, speed):
    q, v = np.array([0.3, 0.4, 0.5]), speed * np.array([1.0, -1.0, 1.0])
    controller = controllers.create(law, planar)
    controller.reset(q, np.zeros(3), DT)
    try:
        tau = controller.torque(q, v, REST)
    except NonFiniteError:
        return
    assert np.isfinite(tau).all()


@every_law
def test_overflow_is_an_error(planar, law):
    controller = controllers.create(law, planar)
    controller.reset(INSIDE, np.zeros(3), DT)
    with pytest.raises(NonFiniteError, match=r"v must be at most 1e\+50 in magnitude, got \[1e\+200"):
        controller.torque([0.3, 0.4, 0.5], [1e200, -1e200, 1e200], REST)


@every_law
def test_overflow_by_the_target_is_an_error(planar, law):
    controller = controllers.create(law, planar)
    q, huge = np.array([0.3, 0.4, 0.5]), np.full(2, 1e308)
    controller.reset(q, np.zeros(3), DT)

    def two_samples():
        for _ in range(2):
            controller.torque(q, np.zeros(3), Target(huge, huge, huge))

    with pytest.raises(NonFiniteError):
        two_samples()
