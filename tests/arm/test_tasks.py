"""Task coordinates: choosing, comparing and storing them, and the laws on tasks with rotations."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aspect_control import Arm, Target, controllers
from aspect_control.arm.tasks import AXES, NAMED_TASKS, Task, task_of_value
from aspect_control.exceptions import NonFiniteError, ShapeError, TaskError
from aspect_control.redundancy import task_acceleration
from example_arms import example_arm, random_motions, random_postures, slopes

TASKS = {
    "xy": ("x", "y"),
    "xz": ("x", "z"),
    "yz": ("y", "z"),
    "xyz": ("x", "y", "z"),
    "pose": ("x", "y", "z", "rx", "ry", "rz"),
    ("z",): ("z",),
    ("rz",): ("rz",),
    ("z", "x"): ("z", "x"),
    ("rx", "ry"): ("rx", "ry"),
    ("x", "y", "rz"): ("x", "y", "rz"),
    ("rz", "y", "rx", "x"): ("rz", "y", "rx", "x"),
    AXES[::-1]: AXES[::-1],
}
ROTATING = [task for task, axes in TASKS.items() if set(axes) & {"rx", "ry", "rz"}]
POSITIONS = [task for task in TASKS if task not in ROTATING]

every_task = pytest.mark.parametrize("task", TASKS, ids=str)
every_rotating_task = pytest.mark.parametrize("task", ROTATING, ids=str)
every_position_task = pytest.mark.parametrize("task", POSITIONS, ids=str)
every_law = pytest.mark.parametrize("law", controllers.available())
task_space_laws = pytest.mark.parametrize(
    "law",
    [law for law in controllers.available() if issubclass(controllers.find(law), controllers.TaskSpaceController)],
)
tasks_of_laws = pytest.mark.parametrize("task", ["xyz", "pose", ("x", "y", "rz"), ("rx", "ry")], ids=str)

vectors = arrays(np.float64, 3, elements=st.floats(-2.0, 2.0))
rotation_vectors = arrays(np.float64, 3, elements=st.floats(-1.8, 1.8))  # at most 1.8 √3 = 3.12 < π

# The logarithm of a rotation by π − a rounds like ε / a²: 4e-13 and some to spare where a is π − 1.8 √3 = 0.024.
HALF_TURN_ROUNDING = 2e-12


@st.composite
def poses(draw):
    return pin.SE3(pin.exp3(draw(rotation_vectors)), draw(vectors))


def panda(task):
    return example_arm("panda", task)


def some_value(task):
    pose = pin.SE3(pin.exp3(np.array([0.3, -0.7, 1.1])), np.array([0.4, 0.5, 0.6]))
    return Task.parse(task).value(pose)


# Choosing


@every_task
def test_task_has_the_axes_given(task):
    parsed = Task.parse(task)
    assert parsed.axes == TASKS[task]
    assert parsed.dim == len(parsed.rows) == len(TASKS[task])
    assert [AXES[row] for row in parsed.rows] == list(TASKS[task])


def test_every_named_task_is_tested():
    assert set(NAMED_TASKS) == {task for task in TASKS if isinstance(task, str)}


@every_task
def test_task_tells_its_positions_from_its_rotations(task):
    parsed = Task.parse(task)
    axes = TASKS[task]
    assert [axes[row] for row in parsed.position_rows] == [axis for axis in axes if len(axis) == 1]
    assert [axes[row] for row in parsed.rotation_rows] == [axis for axis in axes if len(axis) == 2]
    assert parsed.has_rotation == (task in ROTATING)


def test_task_may_be_a_list():
    assert Task.parse(["rz", "x"]) == Task.parse(("rz", "x"))


@pytest.mark.parametrize(
    "task", ["", "x", "rx", "xyzz", "Pose", "pos", [], (), ("x", "x"), ("x", "rw"), ("xy",), ("x", 1), 3, None, {"x"}]
)
def test_unknown_task_lists_names_and_axes(task):
    message = r"available: 'xy', 'xz', 'yz', 'xyz', 'pose'; .*'x', 'y', 'z', 'rx', 'ry', 'rz'"
    with pytest.raises(TaskError, match=message):
        Task.parse(task)


def test_misspelt_task_names_the_nearest():
    with pytest.raises(TaskError, match="unknown task 'poes': did you mean 'pose'"):
        Arm.from_example("panda", frame="panda_hand_tcp", task="poes")


@pytest.mark.parametrize(("value", "task"), [(np.zeros(2), "xy"), (np.zeros(3), "xyz"), (pin.SE3.Identity(), "pose")])
def test_bare_value_suggests_its_task(value, task):
    assert task_of_value(value) == Task.parse(task)


# Rows of the arm's quantities


@every_task
def test_arm_has_the_tasks_rows_of_the_whole_pose(task):
    arm, whole = panda(task), panda("pose")
    rows = Task.parse(task).rows
    assert (arm.task, arm.task_dim, arm.redundancy) == (TASKS[task], len(rows), 7 - len(rows))
    for q, v in random_motions(whole, 5, seed=1):
        state, expected = arm.state(q, v), whole.state(q, v)
        for name in ("J", "drift"):
            np.testing.assert_array_equal(getattr(state, name), getattr(expected, name)[rows])
        np.testing.assert_array_equal(arm.jacobian(q), whole.jacobian(q)[rows])
        np.testing.assert_array_equal(arm.jacobian_derivative(q), whole.jacobian_derivative(q)[rows])
        # A product of fewer rows may be summed in another order.
        np.testing.assert_allclose(state.dx, expected.dx[rows], rtol=0, atol=1e-14)


@every_position_task
def test_value_of_a_task_of_positions_is_their_coordinates(task):
    for q in random_postures(panda(task), 5, seed=2):
        expected = panda("pose").task_position(q).translation[Task.parse(task).rows]
        np.testing.assert_array_equal(panda(task).task_position(q), expected)


@every_rotating_task
def test_value_of_a_task_with_rotations_is_the_pose(task):
    for q in random_postures(panda(task), 5, seed=3):
        assert panda(task).task_position(q) == panda("pose").task_position(q)


def test_pose_of_a_state_is_not_changed_by_the_next_one():
    (q, v), (other_q, other_v) = random_motions(panda("pose"), 2, seed=4)
    state = panda("pose").state(q, v)
    before = state.x.homogeneous.copy()
    panda("pose").state(other_q, other_v)
    panda("pose").task_position(other_q)
    np.testing.assert_array_equal(state.x.homogeneous, before)


@pytest.mark.parametrize("robot", ["panda", "kinova", "pr2"])
@pytest.mark.parametrize("task", ["xyz", "pose", ("rz", "y"), ("rx", "ry")], ids=str)
def test_jacobian_is_the_derivative_of_the_task_value(robot, task):
    arm = example_arm(robot, task)
    for q in random_postures(arm, 10, seed=5):
        x = arm.task_position(q)
        slope = slopes(arm, lambda q, x=x: arm.coordinates.error(arm.task_position(q), x), q)
        # step⁴ of truncation, 1e-16, and 1e-16 / step of rounding, 1e-12.
        np.testing.assert_allclose(arm.jacobian(q), slope, rtol=0, atol=1e-11)


@pytest.mark.parametrize("robot", ["panda", "kinova", "pr2"])
@pytest.mark.parametrize("task", ["xyz", "pose", ("rz", "y"), ("rx", "ry")], ids=str)
def test_drift_is_the_rate_of_change_of_the_jacobian_times_the_velocity(robot, task):
    arm, step = example_arm(robot, task), 1e-4
    for q, v in random_motions(arm, 10, seed=6):
        J = [arm.jacobian(arm.integrate(q, k * step * v)) for k in (-2, -1, 1, 2)]
        rate = (J[0] - 8.0 * J[1] + 8.0 * J[2] - J[3]) / (12.0 * step)
        # Truncation step⁴ |v|⁵ / 30 and rounding 1e-16 / step · |v|, at speeds of 2 rad/s a joint.
        np.testing.assert_allclose(arm.state(q, v).drift, rate @ v, rtol=0, atol=1e-10)


# Comparing


@every_position_task
def test_error_of_positions_is_their_difference(task):
    dim = Task.parse(task).dim
    desired, actual = np.arange(1.0, 1.0 + dim), np.full(dim, 0.25)
    np.testing.assert_array_equal(Task.parse(task).error(desired, actual), desired - actual)


@given(start=poses(), turn=rotation_vectors, shift=vectors)
def test_error_of_a_pose_is_the_rotation_vector_in_the_world(start, turn, shift):
    desired = pin.SE3(pin.exp3(turn) @ start.rotation, start.translation + shift)
    error = Task.parse("pose").error(desired, start)
    np.testing.assert_allclose(error, [*shift, *turn], rtol=0, atol=HALF_TURN_ROUNDING)


def test_error_is_the_shortest_rotation():
    turned = pin.SE3(pin.exp3(np.array([0.0, 0.0, 1.5 * np.pi])), np.zeros(3))
    error = Task.parse(("rz",)).error(turned, pin.SE3.Identity())
    np.testing.assert_allclose(error, [-0.5 * np.pi], rtol=0, atol=1e-14)


def test_error_at_half_a_turn_is_half_a_turn():
    for axis in np.eye(3):
        turned = pin.SE3(pin.exp3(np.pi * axis), np.zeros(3))
        error = Task.parse("pose").error(turned, pin.SE3.Identity())
        # arccos(−1 + ε) is only as exact as the square root of the machine precision.
        np.testing.assert_allclose(np.abs(error[3:]), np.pi * axis, rtol=0, atol=1e-7)


@every_task
@given(data=st.data())
def test_error_undoes_displaced(task, data):
    parsed = Task.parse(task)
    start = parsed.value(data.draw(poses()))
    displacement = np.concatenate([data.draw(vectors), data.draw(rotation_vectors)])[parsed.rows]
    displaced = parsed.displaced(start, displacement)
    np.testing.assert_allclose(parsed.error(displaced, start), displacement, rtol=0, atol=HALF_TURN_ROUNDING)


@given(start=poses(), end=poses())
def test_displaced_undoes_the_error_of_a_pose(start, end):
    task = Task.parse("pose")
    reached = task.displaced(start, task.error(end, start))
    # The logarithm of a rotation of π − a rounds like 1/a; its exponential is exact again to the square root at π.
    np.testing.assert_allclose(reached.homogeneous, end.homogeneous, rtol=0, atol=1e-7)


@every_task
def test_displaced_changes_nothing_in_its_start(task):
    parsed, start = Task.parse(task), some_value(task)
    before = parsed.encode(start).copy()
    displaced = parsed.displaced(start, np.full(parsed.dim, 0.5))
    np.testing.assert_array_equal(parsed.encode(start), before)
    assert not np.array_equal(parsed.encode(displaced), before)


@every_task
def test_nothing_is_no_displacement(task):
    parsed, start = Task.parse(task), some_value(task)
    # R Rᵀ is the identity to rounding.
    np.testing.assert_allclose(parsed.error(start, start), np.zeros(parsed.dim), rtol=0, atol=1e-15)
    displaced = parsed.displaced(start, np.zeros(parsed.dim))
    np.testing.assert_allclose(parsed.encode(displaced), parsed.encode(start), rtol=0, atol=1e-16)


# Storing


@every_task
@given(pose=poses())
def test_decode_undoes_encode(task, pose):
    parsed = Task.parse(task)
    value = parsed.value(pose)
    numbers = parsed.encode(value)
    assert numbers.shape == (parsed.encoded_size,) == ((7,) if task in ROTATING else (parsed.dim,))
    np.testing.assert_allclose(parsed.error(parsed.decode(numbers), value), 0.0, rtol=0, atol=1e-14)


@given(pose=poses())
def test_encoded_pose_is_a_position_and_a_unit_quaternion(pose):
    numbers = Task.parse("pose").encode(pose)
    np.testing.assert_array_equal(numbers[:3], pose.translation)
    x, y, z, w = numbers[3:]
    np.testing.assert_allclose(pin.Quaternion(w, x, y, z).matrix(), pose.rotation, rtol=0, atol=1e-14)
    assert np.linalg.norm(numbers[3:]) == pytest.approx(1.0, abs=1e-15)


@every_task
def test_value_and_checked_are_copies(task):
    parsed = Task.parse(task)
    pose = pin.SE3(pin.exp3(np.array([0.3, -0.7, 1.1])), np.array([0.4, 0.5, 0.6]))
    value = parsed.value(pose)
    checked, before = parsed.checked("x", value), parsed.encode(value).copy()
    pose.translation = np.zeros(3)
    np.testing.assert_array_equal(parsed.encode(value), before)
    if task in ROTATING:
        value.translation = np.ones(3)
    else:
        value[:] = 1.0
    np.testing.assert_array_equal(parsed.encode(checked), before)


@every_rotating_task
@pytest.mark.parametrize("bad", [np.zeros(6), np.zeros(3), np.eye(4), None, 0.0, "here"], ids=str)
def test_value_that_is_no_pose_is_an_error(task, bad):
    with pytest.raises(ShapeError, match=rf"x must be a pin\.SE3 for the task .*, got {type(bad).__name__}"):
        Task.parse(task).checked("x", bad)


@every_position_task
def test_value_that_is_no_position_is_an_error(task):
    for bad in (pin.SE3.Identity(), None, np.zeros(7), np.eye(3), "here"):
        with pytest.raises(ShapeError, match="x must"):
            Task.parse(task).checked("x", bad)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_value_that_is_not_finite_is_an_error(bad):
    with pytest.raises(NonFiniteError, match="x must be finite"):
        Task.parse("xyz").checked("x", [0.0, bad, 0.0])
    with pytest.raises(NonFiniteError, match="x must be finite"):
        Task.parse("pose").checked("x", pin.SE3(np.eye(3), np.array([0.0, bad, 0.0])))
    with pytest.raises(NonFiniteError, match="x must be finite"):
        Task.parse(("rx", "ry")).checked("x", pin.SE3(np.diag([1.0, bad, 1.0]), np.zeros(3)))


# The laws


def samples(arm, count, seed):
    """States away from singularities, and targets of the arm's task up to 0.5 m and 1.7 rad away."""
    rng = np.random.default_rng(seed)
    for q, v in random_motions(arm, count, seed):
        if np.linalg.cond(arm.jacobian(q)) < 100.0:
            x = arm.coordinates.displaced(arm.task_position(q), rng.uniform(-0.5, 0.5, arm.task_dim))
            yield q, v, Target(x, *rng.normal(0.0, 2.0, (2, arm.task_dim)))


@task_space_laws
@tasks_of_laws
def test_law_gives_the_commanded_task_acceleration(law, task):
    arm = panda(task)
    gains = np.linspace(50.0, 150.0, arm.task_dim), np.linspace(10.0, 30.0, arm.task_dim)
    controller = controllers.create(law, arm, kp=gains[0], kv=gains[1])
    seen = 0
    for q, v, target in samples(arm, 40, seed=7):
        state = arm.state(q, v)
        error = arm.coordinates.error(target.x, state.x)
        b = target.ddx + gains[1] * (target.dx - state.dx) + gains[0] * error - state.drift
        tau = controller.torque(q, v, target)
        actual = task_acceleration(state.M, state.nle, state.J, tau)
        # What M⁻¹ makes of N is taken away again: rounding is relative to the larger of the two.
        size = np.linalg.norm(b) + np.linalg.norm(state.nle)
        rounding = 1e-13 * np.linalg.cond(state.J) * np.linalg.cond(state.M) * size
        np.testing.assert_allclose(actual, b, rtol=0, atol=rounding)
        seen += 1
    assert seen > 20


@task_space_laws
@tasks_of_laws
def test_law_leads_the_error_by_its_gains_in_forward_dynamics(law, task):
    arm = panda(task)
    controller = controllers.create(law, arm)
    data, seen = arm.model.createData(), 0
    for q, v, target in samples(arm, 40, seed=8):
        tau = controller.torque(q, v, target)
        joint_acceleration = pin.aba(arm.model, data, q, v, tau)
        state = arm.state(q, v)
        acceleration = state.J @ joint_acceleration + state.drift
        # ë + K_v ė + K_p e = 0, the closed loop of Eq. (5).
        residue = target.ddx - acceleration + 20.0 * (target.dx - state.dx)
        residue += 100.0 * arm.coordinates.error(target.x, state.x)
        size = np.linalg.norm(acceleration) + np.linalg.norm(state.nle)
        rounding = 1e-13 * np.linalg.cond(state.J) * np.linalg.cond(state.M) * size
        np.testing.assert_allclose(residue, 0.0, rtol=0, atol=rounding)
        seen += 1
    assert seen > 20


@tasks_of_laws
@pytest.mark.parametrize("kappa", [0.0, 0.01])
def test_jmdc_speeds_the_task_up_to_its_target(task, kappa):
    arm, dt = panda(task), 1e-3
    controller = controllers.JMinorDynamicControl(arm, kappa=kappa)
    rest, seen = np.zeros(arm.nv), 0
    for q, _, target in samples(arm, 20, seed=9):
        state = arm.state(q, rest)
        controller.reset(q, rest, dt)
        # The first sample holds the start; the second one asks for ẋ_d, and the minor measure moves no task coordinate.
        np.testing.assert_allclose(controller.torque(q, rest, target), state.nle, rtol=0, atol=1e-12)
        tau = controller.torque(q, rest, target)
        actual = task_acceleration(state.M, state.nle, state.J, tau)
        b = (1.0 / dt + 20.0) * target.dx
        size = np.linalg.norm(b) + np.linalg.norm(state.nle)
        rounding = 1e-13 * np.linalg.cond(state.J) * np.linalg.cond(state.M) * size
        np.testing.assert_allclose(actual, b, rtol=0, atol=rounding)
        seen += 1
    assert seen > 10


def good_target(task):
    rates = np.zeros(Task.parse(task).dim)
    return Target(some_value(task), rates, rates)


def zero_target(x):
    dim = 6 if isinstance(x, pin.SE3) else len(x)
    return Target(x, np.zeros(dim), np.zeros(dim))


IDENTITY = pin.SE3.Identity()
WRONG_TARGETS = {
    "array for a pose": ("pose", zero_target(np.zeros(6)), "a pin.SE3 as x and 6 rates, got ndarray"),
    "array for rotations": (("rx", "ry"), good_target("xy"), "a pin.SE3 as x and 2 rates, got ndarray"),
    "pose for positions": ("xyz", Target(IDENTITY, np.zeros(3), np.zeros(3)), "an array as x and 3 rates, got SE3"),
    "too few positions": ("xyz", good_target("xy"), "an array as x and 3 rates, got ndarray and 2"),
    "too few rates": ("pose", good_target(("rx", "ry")), "a pin.SE3 as x and 6 rates, got SE3 and 2"),
    "too many rates": (("x", "y", "rz"), good_target("pose"), "a pin.SE3 as x and 3 rates, got SE3 and 6"),
}


@every_law
@pytest.mark.parametrize(("task", "target", "message"), WRONG_TARGETS.values(), ids=WRONG_TARGETS)
def test_target_of_another_kind_is_an_error(law, task, target, message):
    q, v = np.array([0.1, -0.7, 0.2, -2.3, 0.3, 1.5, 0.7]), np.zeros(7)
    controller = controllers.create(law, panda(task))
    controller.reset(q, v, 1e-3)
    with pytest.raises(ShapeError, match=f"the target for .* must have {message}"):
        controller.torque(q, v, target)


@every_law
@tasks_of_laws
def test_target_of_the_right_kind_is_taken(law, task):
    q, v = np.array([0.1, -0.7, 0.2, -2.3, 0.3, 1.5, 0.7]), np.zeros(7)
    controller = controllers.create(law, panda(task))
    controller.reset(q, v, 1e-3)
    assert np.isfinite([controller.torque(q, v, good_target(task)) for _ in range(3)]).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_target_pose_that_is_not_finite_is_an_error(bad):
    pose = pin.SE3(np.eye(3), np.array([0.0, bad, 0.0]))
    with pytest.raises(NonFiniteError, match=r"target\.x must be finite"):
        Target(pose, np.zeros(6), np.zeros(6))


def test_target_is_not_changed_by_its_callers_pose():
    pose = pin.SE3.Identity()
    target = Target(pose, np.zeros(6), np.zeros(6))
    pose.translation = np.ones(3)
    assert target.x == pin.SE3.Identity()


@pytest.mark.parametrize("name", ["dx", "ddx"])
def test_rates_of_a_pose_have_one_length(name):
    rates = {"dx": np.zeros(6), "ddx": np.zeros(6)} | {name: np.zeros(3)}
    with pytest.raises(ShapeError, match="must have one shape"):
        Target(pin.SE3.Identity(), **rates)
