"""The command that tests the hypothesis, what it writes, and the page that shows it."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

import aspect_control as ac
from aspect_control.cli.commands import app
from aspect_control.exceptions import AspectControlError, ParameterError, ScenarioError, ShapeError
from aspect_control.files import sha256
from aspect_control.studies import Study
from aspect_control.studies.hypothesis import ABLATION, THRESHOLDS, hypothesis_study
from aspect_control.views.reports.hypothesis_report import filled_page, hypothesis_fields

COMMAND = str(Path(sys.executable).with_name("aspect-control"))
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hypothesis")
    done = subprocess.run(
        [COMMAND, "hypothesis", "--samples", "3", "--dt", "5e-3", "--seed", "2", "--workers", "1"],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )
    assert done.returncode == 0, done.stderr
    return folder / "results" / "hypothesis" / "planar3r", done.stdout


def test_command_writes_table_report_figure_and_counterexamples(results):
    folder, screen = results
    assert {path.name for path in folder.iterdir()} == {
        "study.json",
        "shards",
        "planar3r.parquet",
        "hypothesis.md",
        "hypothesis.json",
        "hypothesis-planar3r.png",
        "hypothesis-planar3r.svg",
        "counterexamples",
    }
    found = json.loads((folder / "hypothesis.json").read_text(), parse_constant=pytest.fail)
    (condition,), (source,) = found["conditions"], found["sources"]
    assert [condition[name] for name in ("scenario", "seed", "dt", "samples")] == ["planar3r", 2, 5e-3, 3]
    assert len(condition["tables"]) == 5 * len(THRESHOLDS)
    assert source["sha256"] == sha256(folder / "planar3r.parquet")
    assert pq.read_table(folder / "planar3r.parquet").num_rows == source["rows"] == source["runs"] == 15
    assert "Necessary for a calm torque?" in screen
    assert "modified-null" in screen
    report = (folder / "hypothesis.md").read_text()
    assert report.count("| jmdc-without-minor-measure |") >= 4


def test_a_saved_counterexample_is_made_again_bit_for_bit_and_can_be_shown(results, tmp_path):
    folder, _ = results
    found = json.loads((folder / "hypothesis.json").read_text())["counterexamples"]
    names = {f"{each['law']}-{each['sample']}.npz" for each in found}
    assert names == {path.name for path in (folder / "counterexamples").iterdir()}
    study = hypothesis_study("planar3r", 3, seed=2, dt=5e-3)
    for each in (found[0], found[-1]):
        law, sample = each["law"], each["sample"]
        saved = ac.Run.load(folder / "counterexamples" / f"{law}-{sample}.npz")
        assert saved == study.record("planar3r", sample, law)
        assert np.abs(saved.tau).max() == each["peak_torque"]
    page = tmp_path / "page.html"
    app(["replay", str(folder / "counterexamples" / f"{law}-{sample}.npz"), "--out", str(page)], standalone_mode=False)
    assert page.stat().st_size > 1e5


def test_a_page_is_filled_with_what_a_study_says(results, tmp_path):
    folder, _ = results
    template = tmp_path / "template.md"
    template.write_text("Of ${runs} runs:\n\n${verdict}\n\n${sources}\n")
    app(["study", "page", str(template), str(folder), "--out", str(tmp_path / "docs")], standalone_mode=False)
    text = (tmp_path / "docs" / "hypothesis.md").read_text()
    assert text.startswith("Of 15 runs:\n\n- Necessary for a calm torque?")
    assert sha256(folder / "planar3r.parquet") in text
    assert (tmp_path / "docs" / "images" / "hypothesis-planar3r.png").stat().st_size > 1e4
    stored = json.loads((tmp_path / "docs" / "hypothesis.json").read_text())
    assert filled_page(template.read_text(), hypothesis_fields(stored)) == text


@pytest.mark.parametrize(("template", "words"), [(None, "cannot read the template"), ("${this}", "the field 'this'")])
def test_a_page_that_cannot_be_filled_is_refused(results, tmp_path, template, words):
    folder, _ = results
    file = tmp_path / "template.md"
    if template:
        file.write_text(template)
    with pytest.raises(AspectControlError, match=words):
        app(["study", "page", str(file), str(folder), "--out", str(tmp_path / "docs")], standalone_mode=False)
    assert not (tmp_path / "docs").exists()


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
        patience = time.monotonic() + 120.0
        while not list(tmp_path.glob("shards/0*.parquet")) and process.poll() is None and time.monotonic() < patience:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60.0)
    finally:
        process.kill()
    assert process.returncode == 130
    assert errors.endswith("aspect-control: interrupted; what was written stays\n")
    found = json.loads((tmp_path / "hypothesis.json").read_text())
    assert 1 <= found["conditions"][0]["samples"] < 5000
    missing = 25_000 - found["sources"][0]["rows"]
    assert f"Interrupted: {missing:,} runs are not there yet." in (tmp_path / "hypothesis.md").read_text()


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
        (["--samples", "1000000"], ParameterError, "give --yes to go on, or fewer motions"),
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
    assert not list(Path().rglob("*.parquet"))


# The page


TEMPLATE = (DOCS / "templates" / "hypothesis.md").read_text()
PAGE = (DOCS / "hypothesis.md").read_text()
STORED = json.loads((DOCS / "hypothesis.json").read_text())
STUDIES = {path.stem: path for path in (DOCS.parent / "examples" / "studies").glob("hypothesis-*.toml")}


def test_the_page_is_its_template_with_the_stored_numbers():
    assert filled_page(TEMPLATE, hypothesis_fields(STORED)) == PAGE


def test_words_of_the_readme_are_the_stored_counts():
    (planar,) = (each for each in STORED["conditions"] if (each["scenario"], each["setting"]) == ("planar3r", ""))
    tables = [each for each in planar["tables"] if each["threshold"] == 10.0]

    def total(*keys):
        return f"{sum(each[key] for each in tables for key in keys):,}"

    readme = " ".join((DOCS.parent / "README.md").read_text().split())
    assert f"{total('left_calm')} of {total('left_calm', 'left_exploded')} runs that left it stayed calm" in readme
    assert f"{total('kept_exploded')} of {total('kept_calm', 'kept_exploded')} runs that kept it exploded" in readme


@pytest.mark.parametrize("index", [0, -1])
def test_a_stored_counterexample_is_what_its_study_gives(index):
    each = STORED["counterexamples"][index]
    run = Study.load(STUDIES[each["study"]]).record(each["scenario"], each["sample"], each["law"], each["point"])
    metrics = run.metrics()
    assert metrics["peak_torque"] == pytest.approx(each["peak_torque"], rel=1e-6)
    assert metrics["sign_changes"] == each["sign_changes"]


def test_the_studies_of_the_page_are_those_that_ship():
    assert {each["name"] for each in STORED["sources"]} <= set(STUDIES)
    for path in STUDIES.values():
        study = Study.load(path)
        assert study.definition.report == "hypothesis"
        assert all(ABLATION in study.laws(scenario) for scenario in study.scenarios)


def test_the_example_of_the_page_prints_what_it_says():
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1]
