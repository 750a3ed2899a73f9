"""The command that tries wrong input."""

import json

import pytest
from typer.testing import CliRunner

from aspect_control.cli.commands import app
from aspect_control.exceptions import ParameterError
from aspect_control.studies import safety


def test_it_writes_the_page_and_the_numbers(tmp_path, monkeypatch):
    few = [fault for fault in safety.FAULTS if fault.name in ("q and v in degrees", "target is none")]
    whole = safety.safety_table
    monkeypatch.setattr(safety, "safety_table", lambda progress: whole(progress, few, ["pseudoinverse"]))
    done = CliRunner().invoke(app, ["safety", "--out", str(tmp_path), "--sequences", "5", "--seed", "3"])
    assert done.exit_code == 0, done.output
    document = json.loads((tmp_path / "safety.json").read_text())
    assert [row["fault"] for row in document["faults"]] == [fault.name for fault in few]
    assert (document["seed"], document["random"]["sequences"], document["random"]["broken"]) == (3, 5, [])
    assert "5 sequences of" in done.output
    assert "q is in degrees" in (tmp_path / "safety.md").read_text()


@pytest.mark.parametrize("arguments", [["--sequences", "-1"], ["--seed", "-1"]])
def test_numbers_that_are_none_are_refused(arguments):
    with pytest.raises(ParameterError, match=f"{arguments[0][2:]} must be a whole number of at least 0"):
        CliRunner().invoke(app, ["safety", *arguments], catch_exceptions=False)
