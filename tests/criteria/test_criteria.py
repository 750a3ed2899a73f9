"""The criteria H(q): values, gradients, where they are undefined, and how a law is given one."""

import itertools
import json
import os
import re
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import aspect_control as ac
from aspect_control import controllers, criteria
from aspect_control.exceptions import (
    AspectControlError,
    CriterionNotFoundError,
    NonFiniteError,
    ParameterError,
    ShapeError,
    UndefinedCriterionError,
    UndefinedCriterionWarning,
    UnknownNameError,
)
from aspect_control.redundancy import border_distance, box_distance, minors, repulsive_potential, sphere_distance
from aspect_control.scenario import load_scenario
from example_arms import example_arm, random_postures, serial_chain, slopes

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
OBSTACLES = {
    "spheres": [{"centre": [0.4, 0.3, 0.2], "radius": 0.1}],
    "boxes": [{"centre": [0.3, -0.4, 0.4], "size": [0.3, 0.2, 0.5], "rpy": [0.1, 0.2, 0.3]}],
    "influence": 0.6,
}
PARAMETERS = {
    "force-compatibility": {"direction": [1.0, -2.0, 0.5]},
    "inverse-condition-number": {},
    "joint-range": {},
    "manipulability": {},
    "minor-measure": {},
    "potential": OBSTACLES,
    "velocity-compatibility": {"direction": [1.0, -2.0, 0.5]},
}
NAMES = sorted(PARAMETERS)


def parameters_of(name, arm):
    own = dict(PARAMETERS[name])
    if "direction" in own:
        own["direction"] = own["direction"][: arm.task_dim]
    return own


def criterion_of(name, arm):
    return criteria.create(name, arm, **parameters_of(name, arm))


def at(arm, q):
    return arm.state(q, np.zeros(arm.nv))


# Values and gradients


def literal(name, arm, q):
    """H as the literature writes it, from J and the joint positions alone."""
    J = arm.jacobian(q)
    u = np.array([1.0, -2.0, 0.5])[: arm.task_dim]
    u = u / np.sqrt(u @ u)
    if name == "inverse-condition-number":
        return 1.0 / np.linalg.cond(J)
    if name == "velocity-compatibility":
        return 1.0 / (u @ np.linalg.inv(J @ J.T) @ u)
    if name == "force-compatibility":
        return 1.0 / (u @ J @ J.T @ u)
    if name == "manipulability":
        return np.sqrt(np.linalg.det(J @ J.T))
    lower, upper = arm.position_limits
    ranged = [i for i in range(arm.nv) if np.isfinite(upper[i] - lower[i])]
    theta = arm.positions(q)
    middle, half = (upper + lower) / 2, (upper - lower) / 2
    return -sum(((theta[i] - middle[i]) / half[i]) ** 2 for i in ranged) / len(ranged)


@pytest.mark.parametrize("robot", ["planar3r", "panda"])
@pytest.mark.parametrize("name", sorted(set(NAMES) - {"minor-measure", "potential"}))
def test_value_is_the_formula_of_the_literature(robot, name):
    arm = example_arm(robot, "xy" if robot == "planar3r" else "xyz")
    criterion = criterion_of(name, arm)
    for q in random_postures(arm, 20, seed=31):
        assert criterion.value(at(arm, q)) == pytest.approx(literal(name, arm, q), rel=1e-9)


# Continuous joints (kinova, pr2) and prismatic ones (pr2, tiago) beside the two arms of the paper's kind.
@pytest.mark.parametrize(
    ("robot", "name"),
    [
        *((robot, name) for robot in ("planar3r", "panda") for name in NAMES),
        *((robot, name) for robot in ("kinova", "pr2", "tiago") for name in ("joint-range", "potential")),
    ],
)
def test_gradient_is_the_slope_of_the_value(robot, name):
    arm = example_arm(robot, "xy" if robot == "planar3r" else "xyz")
    criterion = criterion_of(name, arm)
    checked = 0
    for q in random_postures(arm, 25, seed=32):
        gradient = criterion.gradient(at(arm, q))
        scale = np.linalg.norm(gradient)
        if name == "potential" and near_a_seam(criterion, q):
            continue
        if name == "minor-measure" and scale > 50.0 * criterion.value(at(arm, q)):
            continue  # so near a border that H is all curvature
        expected = slopes(arm, lambda p: criterion.value(at(arm, p)), q, step=2e-5 if name == "potential" else 1e-4)
        np.testing.assert_allclose(gradient, expected, rtol=0, atol=1e-6 * max(scale, 1e-3))
        checked += scale > 0.0
    assert checked >= 8


@pytest.mark.parametrize("robot", ["planar3r", "panda"])
@given(st.lists(st.floats(-2.8, 2.8), min_size=7, max_size=7))
@settings(max_examples=15, suppress_health_check=[HealthCheck.filter_too_much])
def test_gradient_is_the_slope_of_the_value_in_any_posture_where_it_is_smooth(robot, angles):
    arm = example_arm(robot, "xy" if robot == "planar3r" else "xyz")
    q = arm.configuration(angles[: arm.nv])
    J = arm.jacobian(q)
    sigma = np.linalg.svd(J, compute_uv=False)
    # Off the singular poses, the borders and the ridges: where H is smooth.
    assume(sigma[-1] > 0.05 * sigma[0] and np.min(-np.diff(sigma)) > 0.05 * sigma[0])
    near = border_distance(minors(J, arm.minor_columns), arm.minor_scales) < 0.02
    for name in sorted(set(NAMES) - {"potential"} - ({"minor-measure"} if near else set())):
        criterion = criterion_of(name, arm)
        gradient = criterion.gradient(at(arm, q))
        expected = slopes(arm, lambda p, of=criterion: of.value(at(arm, p)), q)
        np.testing.assert_allclose(gradient, expected, rtol=0, atol=1e-6 * np.linalg.norm(gradient), err_msg=name)


def near_a_seam(criterion, q):
    """Whether a point is where the potential changes its formula, at which it has no second derivative."""
    distances = np.array([obstacle.distance(criterion.points(q))[0] for obstacle in criterion.obstacles])
    seams = (0.0, 0.1 * criterion.influence, criterion.influence)
    return bool(distances.min() < 1e-3 or any(np.abs(distances - seam).min() < 1e-3 for seam in seams))


def test_joints_without_limits_contribute_nothing():
    arm = example_arm("kinova")
    lower, upper = arm.position_limits
    free = ~np.isfinite(lower) | ~np.isfinite(upper)
    assert free.any()
    criterion = criteria.JointRange(arm)
    for q in random_postures(arm, 5, seed=33):
        assert not criterion.gradient(at(arm, q))[free].any()
    middle = arm.configuration(np.where(free, 0.7, (np.where(free, 0, lower) + np.where(free, 0, upper)) / 2))
    assert criterion.value(at(arm, middle)) == pytest.approx(0.0, abs=1e-12)
    at_limit = arm.configuration(np.where(free, 0.7, lower))
    assert criterion.value(at(arm, at_limit)) == pytest.approx(-1.0)


def test_an_arm_without_any_limit_has_no_joint_range():
    model = serial_chain(4)
    model.lowerPositionLimit[:], model.upperPositionLimit[:] = -np.inf, np.inf
    arm = ac.Arm.from_pinocchio(model, frame="tip", task="xyz")
    with pytest.raises(
        ParameterError, match=r"'joint-range' needs joints with limits: none of 'joint1'.* of 'chain of 4'"
    ):
        criteria.create("joint-range", arm)


# Obstacles

lengths = st.floats(0.05, 2.0)
coordinates = st.tuples(*[st.floats(-2.0, 2.0)] * 3)


def coal_distance(shape, placement, point):
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return coal.distance(shape, placement, coal.Sphere(0.0), coal.Transform3s(np.eye(3), point), request, result)


@given(coordinates, coordinates, lengths)
def test_distance_from_a_sphere_is_that_of_coal(centre, point, radius):
    centre, point = np.array(centre), np.array(point)
    distance, outward = sphere_distance(point[np.newaxis], centre, radius)
    expected = coal_distance(coal.Sphere(radius), coal.Transform3s(np.eye(3), centre), point)
    assert distance[0] == pytest.approx(expected, abs=1e-6)
    assert np.linalg.norm(outward) == pytest.approx(1.0)


@given(coordinates, coordinates, st.tuples(lengths, lengths, lengths), coordinates)
def test_distance_from_a_box_is_that_of_coal(centre, point, size, rpy):
    centre, point, rotation = np.array(centre), np.array(point), pin.rpy.rpyToMatrix(np.array(rpy))
    distance, outward = box_distance(point[np.newaxis], centre, rotation, np.array(size))
    if distance[0] > 0.0:
        expected = coal_distance(coal.Box(*size), coal.Transform3s(rotation, centre), point)
        assert distance[0] == pytest.approx(expected, abs=1e-5)
    # Whether outside or inside, the nearest point of the surface is where the distance and the unit vector say.
    on_surface, _ = box_distance((point - distance[0] * outward[0])[np.newaxis], centre, rotation, np.array(size))
    assert on_surface[0] == pytest.approx(0.0, abs=1e-9)


def test_the_potential_is_khatibs_down_to_a_tenth_of_the_influence_distance_and_then_its_tangent():
    rho = np.array([0.5, 0.3, 0.2, 0.03, 0.01, -0.1])
    U, slope = repulsive_potential(rho, 0.3)
    assert U[:2].tolist() == slope[:2].tolist() == [0.0, 0.0]
    assert U[2:4] == pytest.approx(0.5 * (1.0 / rho[2:4] - 1.0 / 0.3) ** 2)
    assert slope[2:4] == pytest.approx(-(1.0 / rho[2:4] - 1.0 / 0.3) / rho[2:4] ** 2)
    assert U[4:] == pytest.approx(U[3] + slope[3] * (rho[4:] - rho[3]))


@pytest.mark.parametrize("robot", ["planar3r", "panda", "tiago"])
def test_the_points_lie_on_the_links_a_spacing_apart_and_move(robot):
    arm = example_arm(robot, "xy" if robot == "planar3r" else "xyz")
    criterion = criteria.Potential(arm, spheres=[criteria.Sphere((9.0, 9.0, 9.0), 0.1)], spacing=0.03)
    q = random_postures(arm, 1, seed=34)[0]
    points, corners = criterion.points(q), arm.skeleton(q)
    to_links = [min(to_segment(point, a, b) for a, b in itertools.pairwise(corners)) for point in points]
    assert max(to_links) < 1e-12
    np.testing.assert_allclose(points[-1], corners[-1], atol=1e-12)
    if robot != "tiago":  # a prismatic joint stretches what it slides
        assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 0.03 + 1e-9
    for i in range(len(points)):
        assert np.abs(slopes(arm, lambda p, i=i: criterion.points(p)[i], q)).max() > 1e-9


def to_segment(point, a, b):
    length = (b - a) @ (b - a)
    share = np.clip((point - a) @ (b - a) / length, 0.0, 1.0) if length > 0.0 else 0.0
    return np.linalg.norm(point - a - share * (b - a))


def test_skeleton_jacobians_are_the_slopes_of_the_skeleton():
    for robot in ("planar3r", "kinova", "tiago"):
        arm = example_arm(robot, "xy" if robot == "planar3r" else "xyz")
        q = random_postures(arm, 1, seed=35)[0]
        np.testing.assert_allclose(arm.skeleton_jacobians(q), slopes(arm, arm.skeleton, q), atol=1e-9)


# Where a criterion is undefined


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_nan_where_the_arm_is_stretched_or_inside_of_an_obstacle(name, planar):
    criterion = criterion_of(name, planar)
    sphere = {"centre": [1.0, 0.0, 0.0], "radius": 0.1}
    inside = criteria.Potential(planar, spheres=[sphere], boxes=[{"centre": [1.0, 0.0, 0.0], "size": [1.0, 1.0, 1.0]}])
    for each in (criterion, inside):
        for q in ([0.0, 0.0, 0.0], [0.3, np.pi, 0.0], [0.3, 0.0, 0.0], [-1.1071487177940906, 0.0, 0.0]):
            assert np.isfinite(each.gradient(at(planar, q))).all()
            assert not np.isnan(each.value(at(planar, q)))


@pytest.mark.parametrize("name", ["inverse-condition-number", "manipulability", "velocity-compatibility"])
def test_a_start_at_a_singular_pose_is_a_warning_at_the_call_of_reset(planar, name):
    law = controllers.ResolvedMotion(planar, criterion={"name": name, **parameters_of(name, planar)})
    with pytest.warns(
        UndefinedCriterionWarning, match=f"'{name}' has no definite gradient at the start: the pose"
    ) as caught:
        law.reset(np.zeros(3), np.zeros(3), 1e-3)
    assert [each.filename for each in caught] == [__file__]
    law.reset(np.array([0.1, 0.2, 0.3]), np.zeros(3), 1e-3)


def test_a_start_where_no_torque_is_needed_is_an_error(planar):
    law = controllers.ResolvedMotion(planar, criterion={"name": "force-compatibility", "direction": [3.0, 0.0]})
    with pytest.raises(UndefinedCriterionError, match=r"infinite at the start.*force along \[3.0, 0.0\]"):
        law.reset(np.zeros(3), np.zeros(3), 1e-3)
    assert criteria.ForceCompatibility(planar, [1.0, 0.0]).value(at(planar, np.zeros(3))) == np.inf
    sideways = controllers.ResolvedMotion(planar, criterion={"name": "force-compatibility", "direction": [0.0, 3.0]})
    sideways.reset(np.zeros(3), np.zeros(3), 1e-3)


@pytest.mark.parametrize(
    "obstacle",
    [
        {"spheres": [{"centre": [1.52, 0.0, 0.0], "radius": 0.03}]},
        {"boxes": [{"centre": [1.5, 0.0, 0.0], "size": [0.06, 0.06, 0.06]}]},
    ],
)
def test_a_start_inside_of_an_obstacle_is_an_error_that_names_link_and_obstacle(planar, obstacle):
    law = controllers.ResolvedMotion(planar, criterion={"name": "potential", **obstacle})
    with pytest.raises(
        UndefinedCriterionError, match=r"the arm at 'joint2' and 'joint3' is 0\.0\d+ m inside of (Sphere|Box)"
    ):
        law.reset(np.zeros(3), np.zeros(3), 1e-3)


def test_an_obstacle_around_the_base_is_no_obstacle(planar):
    pedestal = criteria.Potential(planar, spheres=[criteria.Sphere((0.0, 0.0, 0.0), 0.04)])
    pedestal.start(np.zeros(3))
    assert pedestal.clearance(np.zeros(3)) == pytest.approx([0.01])


# Bad input


@pytest.mark.parametrize(
    ("criterion", "error", "words"),
    [
        ("joint-rang", CriterionNotFoundError, "unknown criterion 'joint-rang': did you mean 'joint-range'"),
        ("condition-number", CriterionNotFoundError, "did you mean 'inverse-condition-number'"),
        ({"name": "potentail"}, CriterionNotFoundError, "did you mean 'potential'"),
        ({"spheres": []}, ParameterError, "needs a 'name' among them"),
        (7, CriterionNotFoundError, "unknown criterion 7: available: 'force-comp"),
        ({"name": "joint-range", "weight": 2}, UnknownNameError, "unknown parameter 'weight' in 'joint-range'"),
        ("potential", ParameterError, "'potential' needs at least one obstacle"),
        ("velocity-compatibility", ParameterError, "'velocity-compatibility' needs 'direction'"),
        ({"name": "force-compatibility", "direction": [0, 0]}, ParameterError, "direction must not be zero, got"),
        ({"name": "force-compatibility", "direction": [1, 0, 0]}, ShapeError, r"must have shape \(2,\), got \(3,\)"),
        ({"name": "velocity-compatibility", "direction": [1, np.nan]}, NonFiniteError, "direction must be finite"),
        ({"name": "velocity-compatibility", "direction": "x"}, ShapeError, "must be a vector of numbers, got 'x'"),
        ({"name": "potential", "influence": 0}, ParameterError, "needs at least one obstacle"),
        ({"name": "potential", **OBSTACLES, "influence": 0}, ParameterError, "influence must be .* above 0 m, got 0"),
        ({"name": "potential", **OBSTACLES, "spacing": -1}, ParameterError, "spacing must be .* above 0 m, got -1"),
        ({"name": "potential", **OBSTACLES, "spacing": 1e-9}, ParameterError, "makes 3e.09 points of 3 m of links; at"),
        ({"name": "potential", "spheres": {"radius": 1}}, ParameterError, "spheres must be a list of Sphere or of tab"),
        (
            {"name": "potential", "spheres": [3]},
            ParameterError,
            r"spheres\[0\] must be a Sphere or a table with centre",
        ),
        ({"name": "potential", "spheres": [{"radius": 1.0}]}, ParameterError, r"spheres\[0\] lacks centre, got"),
    ],
)
def test_bad_input_is_one_clear_error(planar, criterion, error, words):
    with pytest.raises(error, match=words) as caught:
        controllers.JMinorDynamicControl(planar, criterion=criterion)
    assert isinstance(caught.value, AspectControlError)


@pytest.mark.parametrize(
    ("kind", "fields", "error", "words"),
    [
        ("spheres", {"centre": [0, 0, 1], "radius": 0.0}, ParameterError, "radius of a sphere must be .* above 0 m"),
        ("spheres", {"centre": [0, 0], "radius": 0.1}, ShapeError, r"centre of a sphere must have shape \(3,\)"),
        (
            "boxes",
            {"centre": [0, 0, 1], "size": [0.1, 0.0, 0.1]},
            ParameterError,
            r"size of a box .* above 0 m, got \[0.1",
        ),
        (
            "boxes",
            {"centre": [0, 0, 1], "size": [0, 0, 0]},
            ParameterError,
            "size of a box must be three lengths above",
        ),
        ("boxes", {"centre": [0, 0, 1], "size": 0.1}, ShapeError, r"size of a box must have shape \(3,\)"),
        ("boxes", {"center": [0, 0, 1], "size": [1, 1, 1]}, UnknownNameError, "unknown field 'center'.*mean 'centre'"),
        ("boxes", {"centre": [0, 0, 1]}, ParameterError, r"boxes\[0\] lacks size"),
        ("boxes", {"centre": [0, 0, np.inf], "size": [1, 1, 1]}, NonFiniteError, "centre of a box must be finite"),
    ],
)
def test_impossible_obstacles_are_clear_errors(planar, kind, fields, error, words):
    with pytest.raises(error, match=words):
        criteria.create("potential", planar, **{kind: [fields]})


def test_a_criterion_of_another_arm_is_refused(planar, seven):
    with pytest.raises(ParameterError, match=r"'joint-range' is one of Arm\('seven'.*, not of Arm\('planar3r'"):
        controllers.ResolvedMotion(planar, criterion=criteria.JointRange(seven))


# Laws


@pytest.mark.parametrize("law", ["jmdc", "resolved-motion"])
@pytest.mark.parametrize("name", NAMES)
def test_a_law_takes_any_criterion_and_is_made_again_of_its_parameters(planar, law, name):
    q, rest = np.array([0.5, 0.9, -1.1]), np.zeros(3)
    specification = {"name": name, **parameters_of(name, planar)}
    laws = [
        controllers.create(law, planar, kappa=0.02, criterion=given)
        for given in (specification, criterion_of(name, planar))
    ]
    laws.append(controllers.create(law, planar, **json.loads(json.dumps(laws[0].parameters))))
    if not parameters_of(name, planar):
        laws.append(controllers.create(law, planar, kappa=0.02, criterion=name))
    assert all(each.parameters == laws[0].parameters for each in laws)
    target = ac.Target(planar.task_position(q), np.array([0.1, 0.2]), np.zeros(2))
    torques = []
    for each in laws:
        each.reset(q, rest, 1e-3)
        torques.append(np.array([each.torque(q, rest, target) for _ in range(3)]))
    assert all(np.array_equal(tau, torques[0]) for tau in torques)
    without = controllers.create(law, planar, kappa=0.0, criterion=specification)
    assert without.criterion is None
    assert without.parameters == {**laws[0].parameters, "kappa": 0.0}


@pytest.mark.parametrize("name", NAMES)
def test_a_law_climbs_its_criterion_by_self_motion(planar, name):
    q0 = np.array([0.5, 0.9, -0.7])
    criterion = criterion_of(name, planar)
    kappa = 0.05 / np.linalg.norm(criterion.gradient(at(planar, q0)))
    run = ac.simulate(
        controllers.ResolvedMotion(planar, kappa=kappa, criterion=criterion), ac.Hold(1.0), q0=q0, dt=5e-3
    )
    H = run.values_of(criterion)
    assert np.all(np.diff(H) > -1e-12)
    assert H[-1] > H[0]
    assert run.tracking_error.max() < 1e-3


def test_a_run_remembers_the_criterion_with_its_parameters(planar, tmp_path):
    law = controllers.JMinorDynamicControl(planar, criterion={"name": "potential", **OBSTACLES})
    ac.simulate(law, ac.Hold(0.1), q0=[0.5, 0.9, -1.1], dt=0.01).save(tmp_path / "run.npz")
    info = ac.Run.load(tmp_path / "run.npz").info
    assert info.parameters["criterion"]["boxes"] == OBSTACLES["boxes"]
    assert controllers.create(info.controller, planar, **info.parameters).parameters == law.parameters


def test_a_scenario_names_a_criterion_or_gives_a_table(tmp_path):
    table = """
[controllers.criterion]
name = "potential"
influence = 0.3
[[controllers.criterion.spheres]]
centre = [0.5, 0.9, 0.0]
radius = 0.1
[[controllers.criterion.boxes]]
centre = [0, -2, 0]
size = [1, 0.2, 1]
"""
    (tmp_path / "some.toml").write_text(
        '[robot]\nexample = "planar3r"\nframe = "tool"\ntask = "xy"\n[start]\ndegrees = [-50, 140, -140]\n'
        '[trajectory]\nkind = "line"\ndisplacement = [0.2, 0.1]\nduration = 0.5\n'
        f'[[controllers]]\nname = "resolved-motion"\ncriterion = "joint-range"\n[[controllers]]\nname = "jmdc"\n{table}'
    )
    scenario = load_scenario(tmp_path / "some.toml")
    first, second = scenario.build().laws.values()
    assert first.parameters["criterion"] == "joint-range"
    assert second.criterion.obstacles == (
        criteria.Sphere((0.5, 0.9, 0.0), 0.1),
        criteria.Box((0.0, -2.0, 0.0), (1.0, 0.2, 1.0)),
    )
    assert second.criterion.influence == 0.3
    changed = load_scenario(tmp_path / "some.toml", ["controller.jmdc.criterion=manipulability"])
    assert changed.build().laws["jmdc"].parameters["criterion"] == "manipulability"


# Registry and command


def test_every_exported_criterion_is_an_entry_point_under_its_own_name():
    exported = {getattr(criteria, name) for name in criteria.__all__ if isinstance(getattr(criteria, name), type)}
    concrete = {each for each in exported if issubclass(each, criteria.Criterion) and hasattr(each, "name")}
    group = entry_points(group="aspect_control.criteria")
    assert {each.name: f"aspect_control.criteria:{each.__name__}" for each in concrete} == {
        each.name: each.value for each in group
    }
    assert criteria.available() == tuple(NAMES)
    assert {name: criteria.find(name).name for name in NAMES} == dict(zip(NAMES, NAMES, strict=True))


def command(*arguments, **options):
    environment = {**os.environ, "COLUMNS": "3000"}
    return subprocess.run(
        [COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False, env=environment, **options
    )


def test_the_command_lists_the_criteria():
    done = command("criteria")
    assert (done.returncode, done.stderr) == (0, "")
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert [row[0] for row in rows] == NAMES
    assert re.search(
        r"^potential +spheres = \(\), boxes = \(\), influence = 0.2, spacing = 0.05 ", done.stdout, re.MULTILINE
    )


def test_a_box_without_a_size_is_one_line_of_the_command(tmp_path):
    bad = "controller.jmdc.criterion={name='potential', boxes=[{centre=[0, 9, 0], size=[0, 0, 0]}]}"
    done = command("run", "planar3r", "--set", bad, cwd=tmp_path)
    assert done.returncode == 2
    assert re.fullmatch(r"aspect-control: error: the size of a box must be three lengths above 0 m.*\n", done.stderr)
