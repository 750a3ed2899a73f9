"""States at many samples at once, against each state by itself."""

import numpy as np
import pytest

from aspect_control import Arm
from aspect_control.exceptions import AspectControlError, NonFiniteError, ParameterError, ShapeError
from example_arms import example_arm


def random_samples(arm, count=5):
    random = np.random.default_rng(3)
    q = np.array([arm.configuration(random.uniform(-2.0, 2.0, arm.nv)) for _ in range(count)])
    return q, random.normal(size=(count, arm.nv))


def arms():
    yield pytest.param(lambda: Arm.from_example("planar3r", frame="tool", task=["y"], locked={"joint2": 0.3}), id="y")
    yield pytest.param(
        lambda: Arm.from_example("planar3r", frame="tool", task=["y"], locked={"joint2": 0.3, "joint3": 0.1}), id="one"
    )
    yield pytest.param(lambda: Arm.from_example("panda", frame="panda_hand_tcp", task=["rz", "x"]), id="rz x")
    for name in ("panda", "pr2", "ur5", "kinova"):
        for task in ("xyz", "pose"):
            yield pytest.param(lambda name=name, task=task: example_arm(name, task), id=f"{name} {task}")


@pytest.mark.parametrize("make", list(arms()))
def test_many_states_are_each_state(make):
    arm = make()
    q, v = random_samples(arm)
    samples = arm.kinematics.state_samples(q, v)
    for i in range(len(q)):
        state = arm.state(q[i], v[i])
        scale = np.abs(state.M).max()
        np.testing.assert_allclose(samples.M[i], state.M, rtol=0, atol=1e-14 * scale)
        np.testing.assert_allclose(samples.nle[i], state.nle, rtol=0, atol=1e-13 * np.abs(state.nle).max())
        np.testing.assert_allclose(samples.J[i], state.J, rtol=0, atol=1e-14)
        np.testing.assert_allclose(samples.dJ[i], arm.jacobian_derivative(q[i]) @ v[i], rtol=0, atol=1e-13)
        np.testing.assert_array_equal(samples.x[i], arm.coordinates.encode(state.x))
    assert not any(array.flags.writeable for array in samples)


def test_no_samples_are_states_of_the_right_shapes():
    arm = example_arm("panda", "pose")
    samples = arm.kinematics.state_samples(np.empty((0, 7)), np.empty((0, 7)))
    assert [array.shape for array in samples] == [(0, 7, 7), (0, 7), (0, 6, 7), (0, 6, 7), (0, 7)]


@pytest.mark.parametrize(
    ("name", "change", "error"),
    [
        ("panda", lambda q: q[:, 1:], ShapeError),
        ("panda", lambda q: np.where(q == q[2, 3], np.nan, q), NonFiniteError),
        ("panda", lambda q: 1e60 * q, NonFiniteError),
        ("kinova", lambda q: 2.0 * q, ParameterError),
    ],
)
def test_a_sample_that_no_state_is_computed_of_is_refused(name, change, error):
    arm = example_arm(name)
    q, v = random_samples(arm)
    with pytest.raises(error):
        arm.kinematics.state_samples(change(q), v)
    assert issubclass(error, AspectControlError)
