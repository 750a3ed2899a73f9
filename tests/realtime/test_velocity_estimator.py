"""The velocity filter, measured from outside and held against SciPy's and the analogue filter."""

import numpy as np
import pytest
from scipy import signal

from aspect_control.exceptions import NonFiniteError, ParameterError, ShapeError
from aspect_control.realtime import RealTimeLoop, VelocityEstimator
from example_arms import example_arm
from plant_robot import PlantRobot

every_setting = pytest.mark.parametrize(("dt", "bandwidth"), [(1e-3, 50.0), (1e-3, 20.0), (2e-3, 100.0), (1e-2, 30.0)])


def response(arm, dt, bandwidth, frequency):
    """Complex gain from the velocity of a sine to its estimate, by least squares over whole late periods."""
    estimator, omega = VelocityEstimator(arm, dt, bandwidth), 2.0 * np.pi * frequency
    t = np.arange(0.0, 4.0 / frequency + 5.0 / bandwidth, dt)
    v = np.array([estimator.update([0.3 * np.sin(omega * each), 0.0, 0.0])[0] for each in t])
    late = t > 5.0 / bandwidth + 1.0 / frequency
    waves = np.stack([np.cos(omega * t[late]), -np.sin(omega * t[late])], axis=1)
    return complex(*np.linalg.lstsq(waves, v[late], rcond=None)[0]) / (0.3 * omega)


def reference(dt, bandwidth):
    """Numerator and denominator of the difference quotient before SciPy's own Butterworth filter, and the ideal s."""
    b, a = signal.butter(2, bandwidth, fs=1.0 / dt)
    return np.convolve(b, [1.0, -1.0]) / dt, a


@every_setting
def test_the_measured_response_is_that_of_scipys_filter(planar, dt, bandwidth):
    for frequency in np.array([0.1, 0.5, 1.0, 1.6]) * bandwidth:
        _, h = signal.freqz(*reference(dt, bandwidth), worN=[frequency], fs=1.0 / dt)
        expected = h[0] / (2j * np.pi * frequency)
        assert response(planar, dt, bandwidth, frequency) == pytest.approx(expected, abs=2e-4)


def test_the_bandwidth_is_where_the_filter_lets_half_of_the_power_pass(planar):
    measured = abs(response(planar, 1e-4, 50.0, 50.0))
    assert measured == pytest.approx(np.sqrt(0.5), rel=2e-4)
    analogue = [abs(50.0**2 / ((1j * f) ** 2 + np.sqrt(2.0) * 50.0 * 1j * f + 50.0**2)) for f in (10.0, 25.0, 80.0)]
    assert [abs(response(planar, 1e-4, 50.0, f)) for f in (10.0, 25.0, 80.0)] == pytest.approx(analogue, rel=2e-3)


@every_setting
def test_the_delay_is_the_one_stated(planar, dt, bandwidth):
    estimator = VelocityEstimator(planar, dt, bandwidth)
    b, a = signal.butter(2, bandwidth, fs=1.0 / dt)
    assert estimator.delay / dt == pytest.approx(signal.group_delay((b, a), w=[1e-4])[1][0] + 0.5, rel=1e-5)
    # A velocity that grows by 1 rad/s² is seen late by the delay.
    rate = [estimator.update([0.5 * (k * dt) ** 2, 0.0, 0.0])[0] for k in range(int(20.0 / bandwidth / dt) + 50)]
    assert (len(rate) - 1) * dt - rate[-1] == pytest.approx(estimator.delay, rel=1e-3)


def test_the_delay_at_50_hertz_and_1_kilohertz_is_the_one_in_the_text(planar):
    assert VelocityEstimator(planar, 1e-3, 50.0).delay == pytest.approx(5.0e-3, abs=5e-5)


def test_it_is_right_from_the_start_where_it_is_told_the_velocity(planar):
    estimator, v = VelocityEstimator(planar, 1e-3), np.array([1.0, -2.0, 0.5])
    estimator.reset(np.zeros(3), v)
    for k in range(1, 100):
        np.testing.assert_allclose(estimator.update(1e-3 * k * v), v, rtol=0, atol=1e-10)


def test_continuous_joints_have_a_velocity_across_the_end_of_their_turn():
    arm = example_arm("kinova")
    estimator, v = VelocityEstimator(arm, 1e-3), np.linspace(-3.0, 3.0, arm.nv)
    estimator.reset(arm.configuration(np.full(arm.nv, np.pi - 0.01)), v)
    for k in range(1, 50):
        found = estimator.update(arm.configuration(np.full(arm.nv, np.pi - 0.01) + 1e-3 * k * v))
        np.testing.assert_allclose(found, v, rtol=0, atol=1e-8)


def test_the_noise_of_an_encoder_is_damped(planar):
    step, rng = 2.0 * np.pi / 2**16, np.random.default_rng(1)
    angles = np.round((np.cumsum(rng.uniform(0.0, 1e-3, 2000))) / step) * step
    raw = np.diff(angles) / 1e-3
    estimator = VelocityEstimator(planar, 1e-3, 20.0)
    smooth = np.array([estimator.update([angle, 0.0, 0.0])[0] for angle in angles])[200:]
    assert smooth.std() < 0.25 * raw.std()
    assert smooth.mean() == pytest.approx(raw.mean(), rel=0.02)


def test_a_law_runs_on_a_robot_that_has_only_encoders(planar):
    from aspect_control import Hold, StraightLine, controllers

    class EncodersOnly(PlantRobot):
        estimator = VelocityEstimator(planar, 1e-3, 100.0)

        def read(self):
            q, _ = super().read()
            return q, self.estimator.update(q)

    robot = EncodersOnly(planar, np.deg2rad([-50.0, 140.0, -140.0]))
    loop = RealTimeLoop(robot, controllers.create("damped-null-space", planar))
    run = loop.follow(StraightLine([0.1, 0.1], duration=0.5, profile="quintic"))
    assert run.tracking_error.max() < 5e-3
    assert loop.follow(Hold(0.3)).tracking_error.max() < 5e-3


@pytest.mark.parametrize(
    ("dt", "bandwidth", "message"), [(1e-3, 500.0, "below 1"), (1e-3, 0.0, "bandwidth"), (-1.0, 5.0, "dt")]
)
def test_a_filter_that_cannot_be_is_refused(planar, dt, bandwidth, message):
    with pytest.raises(ParameterError, match=message):
        VelocityEstimator(planar, dt, bandwidth)


def test_a_refused_position_leaves_no_trace(planar):
    one, other = VelocityEstimator(planar, 1e-3), VelocityEstimator(planar, 1e-3)
    for k in range(20):
        for bad, error in (([0.0], ShapeError), ([np.nan, 0.0, 0.0], NonFiniteError)):
            with pytest.raises(error):
                one.update(bad)
        np.testing.assert_array_equal(one.update([0.1 * k, 0.0, k**2]), other.update([0.1 * k, 0.0, k**2]))
