"""`aspect-control study report`: what it writes, and what it says of a folder that holds no study."""

import re
from typing import get_args

import pytest
from typer.testing import CliRunner

from aspect_control.cli.commands import app
from aspect_control.exceptions import AspectControlError
from aspect_control.studies import Study
from aspect_control.studies.definition import StudyDefinition
from aspect_control.views.reports.report_files import REPORTS

DEFINITION = {
    "description": "Two laws, coarsely sampled.",
    "scenarios": ["planar3r"],
    "motions": {"random": 2, "seed": 3},
    "laws": [{"name": "jmdc"}, {"name": "pseudoinverse"}],
    "grid": [{"simulation.dt": [0.02], "controller.kp": [50.0, 100.0]}],
}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder of a study that was run."""
    folder = tmp_path_factory.mktemp("study")
    Study(DEFINITION, "small").run(folder)
    return folder


def report(folder, **options):
    return CliRunner().invoke(app, ["study", "report", str(folder)], catch_exceptions=False, **options)


def test_report_writes_exactly_the_files_it_names(done):
    before = {path.name for path in done.iterdir()}
    found = report(done)
    assert found.exit_code == 0
    written = {path.name for path in done.iterdir()} - before
    assert written == {"report.md", "study.png", "study.svg", "grid-planar3r.png", "grid-planar3r.svg"}
    named = re.fullmatch(rf"8 runs; written to {re.escape(str(done))}: (.*)\n", found.stdout)[1]
    assert set(named.split(", ")) == written


def test_the_files_are_the_same_each_time(done):
    report(done)
    first = {path.name: path.read_bytes() for path in done.glob("*.*")}
    report(done)
    assert {path.name: path.read_bytes() for path in done.glob("*.*")} == first


def test_report_shows_the_figures_beside_it(done):
    report(done)
    text = (done / "report.md").read_text(encoding="utf-8")
    assert text.startswith("# small\n\nTwo laws, coarsely sampled.\n")
    shown = re.findall(r"^!\[[^]]+\]\(([^)]+)\)$", text, re.MULTILINE)
    assert shown == ["study.png", "grid-planar3r.png"]
    assert all((done / each).exists() for each in shown)


def test_report_of_a_study_under_way_counts_what_is_there(tmp_path):
    study = Study(DEFINITION, "small")
    study.run(tmp_path, shard="1/2")
    found = report(tmp_path)
    assert re.match(r"(\d) of 8 runs; ", found.stdout)
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert f"\n{found.stdout[0]} runs of study" in text


def test_a_folder_without_a_study_is_an_error_that_says_so(tmp_path):
    with pytest.raises(AspectControlError, match="is no folder of a study"):
        app(["study", "report", str(tmp_path)], standalone_mode=False)
    assert not list(tmp_path.iterdir())


def test_a_report_that_does_not_exist_is_refused_before_the_first_run():
    with pytest.raises(AspectControlError, match="report: Input should be 'summary', 'hypothesis', 'survey' or 'comp"):
        Study({**DEFINITION, "report": "nonsense"}, "small")


def test_every_report_that_a_study_may_ask_for_has_a_writer():
    assert set(get_args(StudyDefinition.model_fields["report"].annotation)) == set(REPORTS)


def test_the_survey_can_be_reported_again_from_its_folder(tmp_path):
    study = Study({**DEFINITION, "motions": {}, "grid": [{"simulation.dt": [0.05]}], "report": "survey"}, "survey")
    study.run(tmp_path)
    assert report(tmp_path).exit_code == 0
    assert "| planar3r | 1 | jmdc | finished |" in (tmp_path / "survey.md").read_text(encoding="utf-8")
