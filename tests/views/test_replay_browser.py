"""The replay as a real browser shows it."""

import socket
import threading
from pathlib import Path

import numpy as np
import pytest

import aspect_control as ac
from aspect_control import views
from aspect_control.scenario import load_scenario
from aspect_control.trajectories import StraightLine
from browser import changed, open_browser, require_browser

START = np.deg2rad([-50.0, 140.0, -140.0])
LISTENING = "0A"
LOOPBACK = "0100007F"
TIP_COLOUR = np.array([0x00, 0x72, 0xB2])


@pytest.fixture(scope="module")
def browser():
    require_browser()
    with open_browser() as new_page:
        yield new_page


@pytest.fixture(scope="module")
def runs(planar):
    line = StraightLine(displacement=[1.5, 1.0], duration=2.0, profile="bang-bang")
    return {
        name: ac.simulate(ac.controllers.create(name, planar), line, q0=START, dt=1e-3)
        for name in ("null-space-vector", "jmdc")
    }


@pytest.fixture(scope="module")
def one(browser, runs, tmp_path_factory):
    path = tmp_path_factory.mktemp("one") / "replay.html"
    views.replay(runs["jmdc"], path)
    page = browser()
    page.open(path.as_uri())
    return page, path


@pytest.fixture(scope="module")
def two(browser, runs, tmp_path_factory):
    path = tmp_path_factory.mktemp("two") / "replay.html"
    views.replay(runs, path)
    page = browser()
    page.open(path.as_uri())
    return page


def test_the_page_opens_from_disk_without_complaint_and_asks_for_nothing_else(one):
    page, path = one
    page.picture()
    assert page.complaints == []
    assert page.requests == [path.as_uri()]


def test_the_arm_is_drawn(one):
    page, _ = one
    page.seek(0.5)
    drawn = page.picture()
    page.show("meshcat/run0/robot", False)
    empty = page.picture()
    page.show("meshcat/run0/robot", True)
    assert changed(drawn, empty).sum() > 3000
    assert not changed(drawn, page.picture()).any()


def test_the_arm_moves(one):
    page, _ = one
    page.seek(0.2)
    early = page.picture()
    page.seek(1.6)
    assert changed(early, page.picture()).sum() > 3000


@pytest.mark.parametrize("sample", [0, -1], ids=["start", "end"])
def test_the_tip_is_where_forward_kinematics_puts_it(one, runs, sample):
    page, _ = one
    run = runs["jmdc"]
    page.seek(float(run.t[sample]))
    # The trace has the colour of the tip.
    page.run(
        "() => viewer.scene.traverse((part) => { if (part.geometry?.type === 'TubeGeometry') part.visible = false; })"
    )
    picture = page.picture()
    rows, columns = np.nonzero(np.abs(picture - TIP_COLOUR).max(axis=2) <= 3)
    assert len(rows) > 20
    expected = page.pixel([*run.arm.task_position(run.q[sample]), 0.0])
    np.testing.assert_allclose([columns.mean(), rows.mean()], expected, atol=3.0)
    assert np.ptp(columns) < 30


def test_both_of_two_runs_are_drawn_side_by_side(two):
    two.seek(1.3)
    whole = two.picture()
    places = []
    for run in ("run0", "run1"):
        two.show(f"meshcat/{run}", False)
        rows, columns = np.nonzero(changed(whole, two.picture()))
        two.show(f"meshcat/{run}", True)
        assert len(rows) > 1500
        places.append((columns.min(), columns.max()))
    assert places[0][1] < places[1][0]
    assert two.complaints == []


def test_the_cards_tell_the_law_the_torque_and_the_change_of_the_aspect(two, runs):
    two.seek(1.3)
    left, right = two.page.locator(".run").all()
    assert left.locator("h2").inner_text() == "null space vector"
    assert "left its aspect at 0.9" in left.locator("p").inner_text()
    assert right.locator("p").inner_text() == "in the aspect of its start"
    shown = [float(text.split()[0].replace(",", "")) for text in left.locator("td.value").all_inner_texts()]
    run = runs["null-space-vector"]
    np.testing.assert_allclose(shown, np.abs(run.tau[np.searchsorted(run.t, 1.3 - 1e-9)]), rtol=6e-3)
    assert two.run("() => document.querySelectorAll('.run u').length") == 6


def test_the_links_of_the_exploding_arm_change_colour(two):
    colour = """() => {
      const colours = [];
      viewer.scene_tree.find(["meshcat", "run0", "robot", "joint2"]).object.traverse(
        (part) => part.isMesh && colours.push(part.material.color.getHexString()));
      return colours;
    }"""
    two.seek(0.0)
    calm = two.run(colour)
    two.seek(1.3)
    assert len(calm) > 0
    assert all(one != other for one, other in zip(calm, two.run(colour), strict=True))


@pytest.mark.parametrize("scenario", ["panda-xyz", "ur5-xyz"])
def test_a_robot_of_meshes_is_drawn_whole_and_moves(browser, tmp_path, scenario):
    setup = load_scenario(Path(scenario), ["simulation.dt=0.005"]).build()
    run = ac.simulate(setup.laws["jmdc"], setup.trajectory, q0=setup.q0, dt=5e-3)
    views.replay(run, tmp_path / "replay.html")
    page = browser()
    page.open((tmp_path / "replay.html").as_uri())
    page.seek(0.0)
    early = page.picture()
    page.seek(0.9)
    late = page.picture()
    page.show("meshcat/run0/robot", False)
    assert changed(late, page.picture()).sum() > 5000
    assert changed(early, late).sum() > 1000
    undrawable = page.run("""() => {
      let count = 0;
      viewer.scene.traverse((part) => {
        if (part.isMesh) count += [part.material].flat().filter((material) => !material?.isMaterial).length;
      });
      return count;
    }""")
    assert undrawable == 0
    assert page.complaints == []


def test_a_run_is_shown_while_it_is_simulated_and_only_on_loopback(browser, planar):
    line = StraightLine(displacement=[1.5, 1.0], duration=2.0, profile="bang-bang")
    law = ac.controllers.create("jmdc", planar)
    with views.LiveView(planar, ["jmdc"], START, line, speed=2.0, port=0) as view:
        assert listening(view.port) == {LOOPBACK}
        page = browser()
        page.open(view.url)
        assert view.wait_for_viewer(20.0)
        simulation = threading.Thread(
            target=ac.simulate, args=(law, line), kwargs={"q0": START, "watch": view.watch("jmdc")}
        )
        before = page.picture()
        simulation.start()
        page.page.wait_for_function(
            "() => document.querySelector('output').textContent === 't = 2.000 s'", timeout=60_000
        )
        simulation.join()
        assert changed(before, page.picture()).sum() > 3000
        assert page.complaints == []
        assert page.requests[0] == view.url
        assert all(f"//127.0.0.1:{view.port}/" in address for address in page.requests)
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", view.port), timeout=2.0)


def listening(port):
    """Addresses on which anything listens on a port, as the kernel tells."""
    lines = [
        line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()[1:]
    ]
    places = [local.split(":") for _, local, _, state, *_ in lines if state == LISTENING]
    return {address for address, number in places if int(number, 16) == port}
