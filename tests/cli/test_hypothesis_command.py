"""The command that tests the hypothesis, what it writes, and the page that shows it."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import aspect_control as ac
from aspect_control.analysis import aspect_preserved
from aspect_control.cli.commands import app
from aspect_control.exceptions import AspectControlError, ParameterError, ScenarioError, ShapeError
from aspect_control.scenario import load_scenario
from aspect_control.studies.hypothesis import ABLATION, THRESHOLDS, Experiment

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hypothesis")
    done = subprocess.run(
        [COMMAND, "hypothesis", "--samples", "3", "--dt", "5e-3", "--seed", "2", "--workers", "2"],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "results" / "hypothesis" / "planar3r", done.stdout


def test_command_writes_tables_samples_figure_and_counterexamples(results):
    folder, screen = results
    assert {path.name for path in folder.iterdir()} == {
        "hypothesis.md",
        "hypothesis.json",
        "samples.json",
        "hypothesis.png",
        "hypothesis.svg",
        "counterexamples",
    }
    found = json.loads((folder / "hypothesis.json").read_text(), parse_constant=pytest.fail)
    assert (found["scenario"], found["seed"], found["dt"], found["samples"]) == ("planar3r", 2, 5e-3, 3)
    assert len(found["tables"]) == 5 * len(THRESHOLDS)
    samples = json.loads((folder / "samples.json").read_text(), parse_constant=pytest.fail)["samples"]
    assert [each["index"] for each in samples] == [0, 1, 2]
    assert "Necessary for a calm torque?" in screen
    assert "modified-null" in screen
    report = (folder / "hypothesis.md").read_text()
    assert report.count("| jmdc-without-minor-measure |") >= 4


def test_a_saved_counterexample_is_made_again_bit_for_bit_and_can_be_shown(results, tmp_path):
    folder, _ = results
    found = json.loads((folder / "hypothesis.json").read_text())
    names = {f"{each['outcome']['law']}-{each['index']}.npz" for each in found["counterexamples"]}
    assert names == {path.name for path in (folder / "counterexamples").iterdir()}
    experiment = Experiment.of("planar3r", load_scenario("planar3r"), seed=2, dt=5e-3)
    for each in (found["counterexamples"][0], found["counterexamples"][-1]):
        law, index = each["outcome"]["law"], each["index"]
        saved = ac.Run.load(folder / "counterexamples" / f"{law}-{index}.npz")
        assert saved == experiment.run(index, law)
        assert np.abs(saved.tau).max() == each["outcome"]["peak_torque"]
    assert saved.info.trajectory == repr(experiment.draw(index).line)
    page = tmp_path / "page.html"
    file = folder / "counterexamples" / f"{law}-{index}.npz"
    app(["replay", str(file), "--out", str(page)], standalone_mode=False)
    assert page.stat().st_size > 1e5


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_ends_with_status_130_and_what_was_computed_is_written(tmp_path):
    process = subprocess.Popen(
        [COMMAND, "hypothesis", "--samples", "5000", "--dt", "1e-2", "--workers", "1", "--out", str(tmp_path), "--yes"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        patience = time.monotonic() + 60.0
        while not (tmp_path / "samples.json").exists() and process.poll() is None and time.monotonic() < patience:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30.0)
    finally:
        process.kill()
    assert process.returncode == 130
    assert errors == "aspect-control: interrupted; what was written stays\n"
    computed = len(json.loads((tmp_path / "samples.json").read_text())["samples"])
    assert 1 <= computed < 5000
    assert f"{computed} samples of 5000 that were asked for" in (tmp_path / "hypothesis.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        (["--samples", "0"], ParameterError, "samples must be a whole number of at least 1, got 0"),
        (["--workers", "0"], ParameterError, "workers must be a whole number of at least 1, got 0"),
        (["--seed", "-1"], ParameterError, "seed must be a whole number of at least 0, got -1"),
        (["--dt", "0"], ParameterError, "dt must be a finite number above 0 s, got 0"),
        (["--dt", "2"], ParameterError, "dt must not be longer than the shortest motion of 1.41 s, got 2 s"),
        (["no-such"], ScenarioError, "no-such"),
        (["circle.toml"], ScenarioError, "the trajectory is of kind 'circle'"),
        (["far.toml"], ParameterError, "were not 50 to 150 m apart"),
        (["flat.toml"], ShapeError, "the line has 3 task coordinates"),
        (["--samples", "1000000"], ParameterError, "give --yes to go on, or fewer --samples"),
        (["--samples", "1", "--out", "file/below"], AspectControlError, "cannot write to folder file/below"),
    ],
)
def test_bad_input_is_refused_before_anything_is_computed(tmp_path, monkeypatch, arguments, error, words):
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).parents[2] / "scenarios" / "planar3r.toml").read_text()
    Path("file").write_text("in the way")
    Path("far.toml").write_text(text.replace("[1.5, 1.0]", "[100.0, 0.0]"))
    Path("flat.toml").write_text(text.replace("[1.5, 1.0]", "[1.5, 1.0, 0.0]"))
    head, tail = text.split('kind = "line"')
    tail = tail[tail.index("[[controllers]]") :]
    Path("circle.toml").write_text(f'{head}kind = "circle"\nradius = 0.5\nduration = 2.0\n\n{tail}')
    with pytest.raises(error, match=re.escape(words)):
        app(["hypothesis", *arguments], standalone_mode=False)
    assert not Path("results").exists()


# The page


PAGE = (DOCS / "hypothesis.md").read_text()
STORED = {name: json.loads((DOCS / f"hypothesis-{name}.json").read_text()) for name in ("planar3r", "panda-xyz")}


@pytest.mark.parametrize("name", STORED)
def test_tables_of_the_page_are_the_stored_ones(name):
    found = STORED[name]
    for table in found["tables"]:
        if table["threshold"] == 10.0:
            counts = [table[key] for key in ("kept_calm", "kept_exploded", "left_calm", "left_exploded")]
            shares = [table[key] for key in ("exploded_if_kept", "exploded_if_left", "calm_if_left")]
            cells = [
                "–" if each["value"] is None else f"{each['value']:.2f} [{each['low']:.2f}, {each['high']:.2f}]"
                for each in shares
            ]
            assert f"| {table['law']} | {' | '.join(map(str, [*counts, *cells]))} |" in PAGE
    for each in found["counterexamples"]:
        if name == "planar3r":
            row = rf"{each['outcome']['law']} \| {each['index']} \| {each['outcome']['peak_ratio']:,.2f} \|"
            assert re.search(row, PAGE)
            assert each["holds"] is True
    for law, correlations in found["correlations"].items():
        ratio, peak = (correlations[key]["self_motion"] for key in ("peak_ratio", "peak_torque"))
        assert re.search(rf"^\| {law} \|.*\| {re.escape(f'{ratio:+.2f} / {peak:+.2f}')} \|$", PAGE, re.MULTILINE)


def test_words_of_the_page_and_the_readme_are_the_stored_counts():
    planar, panda = ([each for each in STORED[name]["tables"] if each["threshold"] == 10.0] for name in STORED)
    laws = {each["law"]: each for each in planar}

    def total(tables, *keys):
        return f"{sum(each[key] for each in tables for key in keys):,}"

    words = " ".join(PAGE.split())
    left = f"{total(planar, 'left_calm')} of {total(planar, 'left_calm', 'left_exploded')} runs"
    kept = f"{total(planar, 'kept_exploded')} of {total(planar, 'kept_calm', 'kept_exploded')} runs"
    assert f"{left} of the planar arm that left" in words
    assert f"{total(panda, 'left_calm')} of {total(panda, 'left_calm', 'left_exploded')} of Panda's" in words
    assert f"{kept} of the planar arm" in words
    assert f"in none of {total(panda, 'kept_calm')} of Panda's" in words
    inside = sum(each["exploded_inside"]["count"] for each in planar)
    assert f"In {inside} of the {total(planar, 'kept_exploded', 'left_exploded')} runs of the planar arm" in words
    for law in ("jmdc", ABLATION):
        assert laws[law]["kept_calm"] + laws[law]["kept_exploded"] == 150
    burst = [laws[law]["kept_exploded"] + laws[law]["left_exploded"] for law in ("jmdc", ABLATION)]
    assert f"explodes on {burst[0]} with the measure and on {burst[1]} without" in words
    readme = " ".join((DOCS.parent / "README.md").read_text().split())
    assert f"{left} that left it stayed calm" in readme
    assert f"{kept} that kept it exploded" in readme


def test_a_stored_counterexample_is_what_seed_and_index_give():
    found = STORED["planar3r"]
    experiment = Experiment.of("planar3r", load_scenario("planar3r"), seed=found["seed"], dt=found["dt"])
    for each in (found["counterexamples"][0], found["counterexamples"][-1]):
        run = experiment.run(each["index"], each["outcome"]["law"])
        assert np.abs(run.tau).max() == pytest.approx(each["outcome"]["peak_torque"], rel=1e-6)
        assert aspect_preserved(run) == each["outcome"]["aspect_preserved"]


def test_the_example_of_the_page_prints_what_it_says(capsys):
    exec(re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1], {})  # noqa: S102
    assert capsys.readouterr().out == re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1]
