"""The atlas: against the closed form of the planar arm, on Panda, as figures and on the command line."""

import json
import re
import sys
import warnings

import numpy as np
import pytest

from aspect_control import aspects
from aspect_control.analysis import minor_zero_crossings
from aspect_control.analysis.atlas_record import atlas_record
from aspect_control.cli import main
from aspect_control.exceptions import JointNotFoundError, ParameterError
from aspect_control.studies.paper import trajectory_a as paper
from aspect_control.views import atlas_figure, stability_figure
from aspect_control.views.progress import describe_time
from example_arms import example_arm
from oracles import planar_reference

PANDA = np.array([0.3, -0.3, 0.2, -1.9, 0.3, 1.8, 0.5])


@pytest.fixture(scope="module")
def planar_atlas(planar):
    return aspects.compute_atlas(aspects.JointSlice(planar, paper.Q0), 48)


@pytest.fixture(scope="module")
def panda_slice():
    return aspects.SelfMotionSlice(example_arm("panda", "pose"), PANDA, "panda_joint4")


@pytest.fixture(scope="module")
def panda_atlas(panda_slice):
    return aspects.compute_atlas(panda_slice, 24)


@pytest.fixture(scope="module")
def runs():
    return {law: paper.run_law(law, 5e-3) for law in ("null-space-vector", "jmdc")}


# The arrays


def test_planar_atlas_is_the_closed_form(planar_atlas):
    second, third = np.meshgrid(planar_atlas.a, planar_atlas.b)
    expected = np.moveaxis(planar_reference.minors([None, second, third]), 0, -1)
    np.testing.assert_allclose(planar_atlas.minors, expected, atol=1e-12)
    np.testing.assert_allclose(planar_atlas.minor_measure, np.abs(expected.prod(axis=-1)) ** (1 / 3), atol=1e-12)
    assert planar_atlas.within_limits.all()


def test_planar_slice_is_the_torus_of_the_second_and_third_joint_unless_told_otherwise(planar_atlas):
    axes = planar_atlas.slice.horizontal, planar_atlas.slice.vertical
    assert [axis.name for axis in axes] == ["joint2", "joint3"]
    assert [(axis.low, axis.high) for axis in axes] == [(-np.pi, np.pi)] * 2


def test_signatures_of_the_planar_atlas_come_in_antipodal_pairs_of_equal_size(planar_atlas):
    signs, which, counts = planar_atlas.signatures
    assert len(signs) == 8
    sizes = {tuple(row): count for row, count in zip(signs.tolist(), counts, strict=True)}
    assert all(sizes[tuple(-s for s in row)] == count for row, count in sizes.items())
    assert counts.tolist() == sorted(counts, reverse=True)
    assert counts.sum() == 48**2
    np.testing.assert_array_equal(signs[which], np.sign(planar_atlas.minors))


def test_stability_of_the_atlas_is_that_of_its_places(planar_atlas):
    for row, column in ((3, 40), (20, 20), (41, 7)):
        posture = planar_atlas.slice.posture(planar_atlas.a[column], planar_atlas.b[row])
        assert planar_atlas.stability[row, column] == aspects.stability(planar_atlas.arm, posture)
        delta = planar_reference.minors(posture)
        z = delta[[1, 2, 0]] / np.linalg.norm(delta)
        np.testing.assert_allclose(planar_atlas.direction[row, column], z, atol=1e-9)


def test_panda_slice_follows_the_self_motion_where_the_joint_is_not_moved_away(panda_slice):
    arm, x = panda_slice.arm, panda_slice.arm.task_position(PANDA)
    for s in panda_slice.horizontal.centres(7):
        posture = panda_slice.posture(s, 0.0)
        assert np.linalg.norm(arm.coordinates.error(x, arm.task_position(arm.configuration(posture)))) < 1e-9
        moved = panda_slice.posture(s, 0.4) - posture
        np.testing.assert_allclose(moved, [0, 0, 0, 0.4, 0, 0, 0], atol=1e-12)
    assert panda_slice.horizontal.low == -panda_slice.horizontal.high


def test_places_on_a_slice_are_their_own_nearest(panda_slice):
    curve = panda_slice.curve
    for i in (5, len(curve.s) // 2 + 30, len(curve.s) - 9):
        posture = curve.positions[i].copy()
        posture[3] += 0.3
        s, away = panda_slice.trace(posture[np.newaxis])[0]
        assert panda_slice.horizontal.low <= s <= panda_slice.horizontal.high
        assert (s - curve.s[i]) % curve.length == pytest.approx(0.0, abs=1e-9) or s == pytest.approx(curve.s[i])
        assert away == pytest.approx(0.3)


def test_direction_on_the_self_motion_is_along_it(panda_slice):
    a = panda_slice.horizontal.centres(5)
    tangents = np.array([(panda_slice.posture(s + 1e-5, 0.0) - panda_slice.posture(s - 1e-5, 0.0)) / 2e-5 for s in a])
    np.testing.assert_allclose(panda_slice.direction(a, tangents), [[1.0, 0.0]] * 5, atol=1e-6)
    joint = np.tile(np.eye(7)[3], (5, 1))
    np.testing.assert_allclose(panda_slice.direction(a, joint), [[0.0, 1.0]] * 5, atol=1e-9)


def test_joint_slice_keeps_the_other_joints_and_the_limits_of_its_own():
    arm = example_arm("panda", "xyz")
    slice_ = aspects.JointSlice(arm, PANDA, ("panda_joint2", "panda_joint4"))
    lower, upper = arm.position_limits
    assert (slice_.vertical.low, slice_.vertical.high) == (lower[3], upper[3])
    posture = slice_.posture(0.5, -1.0)
    np.testing.assert_array_equal(posture, [0.3, 0.5, 0.2, -1.0, 0.3, 1.8, 0.5])
    np.testing.assert_allclose(slice_.trace(posture[np.newaxis]), [[0.5, -1.0]], atol=1e-12)
    atlas = aspects.compute_atlas(slice_, 6)
    assert atlas.stability is None
    assert atlas.minors.shape == (6, 6, 19)


def test_joints_of_many_sign_changes_are_the_slice_unless_told_otherwise():
    arm = example_arm("panda", "xyz")
    slice_ = aspects.JointSlice(arm, PANDA)
    assert len(aspects.compute_atlas(slice_, 12).signatures[0]) > 12
    # The first joint turns the arm as a whole and changes no minor.
    assert "panda_joint1" not in (slice_.horizontal.name, slice_.vertical.name)


def test_record_says_how_much_of_a_path_the_slice_shows(planar_atlas, panda_atlas, runs):
    record = atlas_record(planar_atlas, runs)
    path, run = record["paths"]["null-space-vector"], runs["null-space-vector"]
    assert path["sign_changes"] == len(minor_zero_crossings(run))
    assert path["agreement"] == 1.0
    assert path["maciejewski_product_max"] == run.maciejewski_product.max()
    assert path["own_product"] == pytest.approx(-path["c"] * path["self_motion_speed"] ** 3)
    assert sum(each["share"] for each in record["signatures"]) == pytest.approx(1.0)
    rng = np.random.default_rng(1)
    assert panda_atlas.agreement(rng.uniform(-2.0, 2.0, (30, 7))) < 0.9
    json.dumps(record, allow_nan=False)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda arm: aspects.JointSlice(arm, PANDA, ("panda_joint2", "joint4")),
            JointNotFoundError,
            "'joint4'.*did you",
        ),
        (lambda arm: aspects.JointSlice(arm, PANDA, ("panda_joint2",) * 2), ParameterError, "two joints.*twice"),
        (
            lambda arm: aspects.SelfMotionSlice(arm, PANDA, "panda_joint9"),
            JointNotFoundError,
            "available: 'panda_joint1'",
        ),
        (
            lambda arm: aspects.SelfMotionSlice(arm, PANDA, "panda_joint2"),
            ParameterError,
            "4 redundant degrees",
        ),
        (lambda arm: aspects.compute_atlas(aspects.JointSlice(arm, PANDA), 1), ParameterError, "at least 2, got 1"),
        (
            lambda arm: aspects.compute_atlas(aspects.JointSlice(arm, PANDA), 10**6),
            ParameterError,
            r"does not fit into memory: 19 minors .* at most \d+ cells",
        ),
    ],
)
def test_bad_input_of_an_atlas(make, error, words):
    with pytest.raises(error, match=words):
        make(example_arm("panda", "xyz"))


@pytest.mark.parametrize(
    ("seconds", "words"), [(40.0, "40 s"), (720.0, "12 min"), (12600.0, "3.5 h"), (2.1 * 86400, "2.1 days")]
)
def test_time_in_words(seconds, words):
    assert describe_time(seconds) == words


def test_estimated_time_grows_with_the_number_of_points(panda_slice):
    assert aspects.estimated_time(panda_slice, 2000) > 10.0 * aspects.estimated_time(panda_slice, 100)


# The figures


def legend_of(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_atlas_figure_shows_signatures_borders_paths_and_crossings(planar_atlas, runs):
    figure = atlas_figure(planar_atlas, runs, "title")
    entries = legend_of(figure)
    for words in ("− − +", "+ + −", r"$\delta_3 = 0$", "null space vector", "JMDC", "start", "end", "border crossed"):
        assert words in entries
    axes = figure.axes[0]
    circles = [line for line in axes.get_lines() if line.get_marker() == "o" and len(line.get_xdata())]
    crossings = minor_zero_crossings(runs["null-space-vector"])
    assert [len(line.get_xdata()) for line in circles] == [len(crossings)]
    path = np.rad2deg(runs["null-space-vector"].q[:, 1:])
    nearest = np.linalg.norm(path[:, np.newaxis] - np.column_stack(circles[0].get_data()), axis=2).min(axis=0)
    assert nearest.max() < 1e-9
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("joint2 (°)", "joint3 (°)")


def test_colours_of_antipodes_are_light_and_dark_of_one_hue(planar_atlas):
    from matplotlib.colors import rgb_to_hsv

    from aspect_control.views.figures.atlas_figures import _signature_colours

    signs = planar_atlas.signatures[0]
    colours = {
        tuple(row): rgb_to_hsv(colour) for row, colour in zip(signs.tolist(), _signature_colours(signs), strict=True)
    }
    for row, (hue, saturation, _) in colours.items():
        other_hue, other_saturation, _ = colours[tuple(-s for s in row)]
        assert hue == pytest.approx(other_hue, abs=1e-6)
        assert abs(saturation - other_saturation) > 0.05
    assert len({round(float(hue), 3) for hue, _, _ in colours.values()}) == 4


def test_path_over_the_edge_of_the_torus_is_broken_not_drawn_across(planar_atlas, planar):
    from aspect_control import Hold, controllers, simulate

    q0 = np.deg2rad([0.0, 178.0, 60.0])
    run = simulate(controllers.Pseudoinverse(planar), Hold(0.1), q0=q0, v0=[0.0, 1.0, 0.0], dt=5e-3)
    assert np.rad2deg(run.q[-1, 1]) > 180.0
    figure = atlas_figure(planar_atlas, {"pseudoinverse": run})
    line = next(each for each in figure.axes[0].get_lines() if each.get_label() == "pseudoinverse")
    x = np.asarray(line.get_xdata())
    assert np.isnan(x).sum() == 1
    assert np.nanmax(np.abs(np.diff(x))) < 10.0


def test_figure_of_many_signatures_counts_signs_and_hatches_limits(panda_atlas):
    figure = atlas_figure(panda_atlas, {})
    assert "of another sign than at the start, of 7" in figure.axes[1].get_ylabel()
    assert not panda_atlas.within_limits.all()
    assert "beyond a joint limit" in legend_of(figure)
    assert "away from the self-motion (°)" in figure.axes[0].get_ylabel()


def test_stability_figure_shows_the_direction(planar_atlas, runs):
    from matplotlib.quiver import Quiver

    figure = stability_figure(planar_atlas, runs)
    arrows = next(each for each in figure.axes[0].collections if isinstance(each, Quiver))
    assert len(arrows.U) > 400
    at = planar_atlas.direction[1::2, 1::2, 1:]
    np.testing.assert_allclose(np.column_stack([arrows.U, arrows.V]), at.reshape(-1, 2), atol=1e-12)
    assert figure.axes[1].get_ylabel().startswith("c (1/rad) for travel along the arrows")


def test_stability_figure_is_for_one_joint_to_spare():
    arm = example_arm("panda", "xyz")
    atlas = aspects.compute_atlas(aspects.JointSlice(arm, PANDA, ("panda_joint2", "panda_joint4")), 2)
    with pytest.raises(ParameterError, match="leaves 4 of 7"):
        stability_figure(atlas, {})


def test_borders_on_the_edge_of_the_torus_are_drawn(planar_atlas):
    """δ₃ = 0 at θ₂ = ±180°, δ₁ = δ₂ = 0 at θ₃ = ±180°: between the cells on both sides of the seam."""
    from aspect_control.views.figures.atlas_layers import _beyond_the_edges

    a, b, values = _beyond_the_edges(planar_atlas)
    assert a[0] + a[1] == pytest.approx(-360.0)
    assert b[-1] + b[-2] == pytest.approx(360.0)
    second, third = np.meshgrid(np.deg2rad(a), np.deg2rad(b))
    expected = np.moveaxis(planar_reference.minors([None, second, third]), 0, -1)
    np.testing.assert_allclose(values, expected, atol=1e-12)
    assert (values[:, 0, 2] * values[:, 1, 2] < 0.0).all()
    assert (values[0, :, :2] * values[1, :, :2] < 0.0).all()


# The command


@pytest.fixture
def atlas(monkeypatch, capsys):
    """The command in this process: exit status, standard output and standard error."""
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["aspect-control", "atlas", *map(str, arguments)])
        with pytest.raises(SystemExit) as raised:
            main()
        return raised.value.code or 0, *capsys.readouterr()

    return run


def test_atlas_of_trajectory_a_from_the_command_line(tmp_path, monkeypatch, atlas):
    """With every atlas counting as a long one, so that it is only made with --yes."""
    monkeypatch.setattr("aspect_control.views.screen.LONG", 0.0)
    arguments = "--resolution", "20", "--set", "simulation.dt=1e-2", "--out", tmp_path / "out"
    status, _, error = atlas(*arguments)
    assert status == 2
    assert re.search(r"a resolution of 20 takes about \d+ s: give --yes to go on, or a lower --resolution", error)
    assert not (tmp_path / "out").exists()
    status, shown, error = atlas(*arguments, "--yes")
    assert (status, error) == (0, "")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"atlas.json", "atlas.png", "atlas.svg", "stability.png", "stability.svg"}
    record = json.loads((tmp_path / "out" / "atlas.json").read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert tuple(record["paths"]) == paper.LAWS
    lines = {" ".join(line.split()) for line in shown.splitlines()}
    for law, path in record["paths"].items():
        numbers = [path[name] for name in ("maciejewski_product_max", "own_product", "c", "self_motion_speed")]
        assert f"{law} {path['sign_changes']} 100% of it" in lines
        assert " ".join([law, *(f"{each:.3g}" for each in numbers)]) in lines
    assert any(line.startswith("slice of joint2 and joint3: 8 aspect signatures") for line in lines)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--joints", "joint2", "joint4"], "unknown joint 'joint4' in planar3r: did you mean 'joint3'"),
        (["--self-motion", "elbow"], "unknown joint 'elbow' in planar3r: available: 'joint1'"),
        (["--joints", "joint2", "joint3", "--self-motion", "joint1"], "either --joints or --self-motion"),
        (["--resolution", "1"], "resolution must be a whole number of at least 2, got 1"),
        (["--resolution", "5000"], "a resolution of 5000 takes about "),
        (["panda-xyz", "--self-motion", "panda_joint4"], "leaves 4 redundant degrees of freedom of 7 joints"),
        (["--out", "file/below"], "cannot write to folder file/below"),
    ],
)
def test_bad_input_of_atlas_is_one_line_and_status_2_and_writes_nothing(tmp_path, monkeypatch, atlas, arguments, words):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("aspect_control.views.screen.LONG", 60.0)  # for 25 million points on any machine
    status, shown, error = atlas(*arguments)
    assert (status, shown) == (2, "")
    assert len(error.splitlines()) == 1
    assert words in error
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
