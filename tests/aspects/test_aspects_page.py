"""What the page on aspects says is what the code does."""

import re
from pathlib import Path

import numpy as np
import pytest

from aspect_control import aspects
from aspect_control.analysis.self_motion_of_run import self_motion_of_run
from aspect_control.resources import scenario_paths
from aspect_control.scenario import load_scenario
from aspect_control.studies.paper import trajectory_a as paper
from example_arms import example_arm

PAGE = (Path(__file__).parents[2] / "docs" / "aspects.md").read_text(encoding="utf-8")
WORDS = " ".join(PAGE.split())
READY = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])


def test_the_python_examples_run_and_print_what_the_page_says(capsys):
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(block, names)  # noqa: S102
    assert capsys.readouterr().out == "".join(re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL))


def test_the_ready_pose_is_the_one_of_the_command():
    setting = re.search(r"READY='(.*)'", PAGE)[1]
    scenario = load_scenario(scenario_paths()["panda-pose"], [setting])
    np.testing.assert_allclose(scenario.build().q0, READY, atol=1e-15)


@pytest.mark.parametrize(("task", "column"), [("pose", 0), ("xyz", 2)])
def test_the_table_of_starts_is_what_is_found(task, column):
    arm = example_arm("panda", task)
    rows = re.findall(r"^\| ([\d.]+ rad|anything) \| ([\d. |]+) \|$", PAGE, re.MULTILINE)
    assert len(rows) == 4
    for allowed, cells in rows:
        within = np.inf if allowed == "anything" else float(allowed.removesuffix(" rad"))
        start = aspects.choose_start(arm, arm.task_position(READY), reference=READY, within=within)
        value, smallest = (cell.strip() for cell in cells.split("|")[column : column + 2])
        assert f"{start.value:.5f}" == value
        assert float(smallest) == pytest.approx(start.smallest_minor, rel=0.05)


def test_the_table_of_peaks_is_that_of_trajectory_a():
    rows = dict(re.findall(r"^\| `([\w-]+)` \| (.*) \|$", PAGE, re.MULTILINE))
    assert tuple(rows) == paper.LAWS
    for law, cells in rows.items():
        run = paper.run_law(law, 1e-3)
        own, peak = self_motion_of_run(run), run.maciejewski_product.argmax()
        measured = run.maciejewski_product[peak], own.own_product[peak], own.c[peak], own.speed[peak]
        # JMDC's self-motion is next to nothing, and its cube is rounding.
        written = [float(cell.replace("−", "-")) for cell in cells.split(" | ")]
        assert written == pytest.approx(measured, rel=0.01, abs=1e-10)
        if law == "null-space-vector":
            assert f"{own.own_product[peak] / run.maciejewski_product[peak]:.1%}".replace("%", " %") in WORDS


@pytest.mark.parametrize(
    ("scenario", "sentence"),
    [
        ("planar3r", "grows by up to {largest:.0f} times from one place to another, and by {turn:.2f} times"),
        ("panda-pose", "grows by up to {largest:.2f} times, and a turn multiplies it by {turn:.3f} one way"),
    ],
)
def test_growth_of_free_self_motions_is_what_the_page_says(scenario, sentence):
    setup = load_scenario(scenario_paths()[scenario]).build()
    grown = aspects.growth(aspects.self_motion(setup.arm, setup.q0))
    assert sentence.format(largest=grown.largest_factor, turn=grown.factor) in WORDS


def test_the_self_motion_is_driven_from_outside_on_panda():
    described = load_scenario(scenario_paths()["panda-pose"], ['controllers=[{name = "null-space-vector"}]'])
    run = described.build().run()["null-space-vector"]
    own, peak = self_motion_of_run(run), run.maciejewski_product.argmax()
    assert f"peak is {run.maciejewski_product[peak]:.3g}, of which −c ṡ³ is {own.own_product[peak]:.3g}" in WORDS
