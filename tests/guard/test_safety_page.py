"""What the pages of safety say is what the code does, and what was measured."""

import re
from pathlib import Path

from aspect_control import controllers
from aspect_control.studies.safety import FAULTS

DOCS = Path(__file__).parents[2] / "docs"
PAGE, MEASURED = ((DOCS / name).read_text() for name in ("safety.md", "safety-measured.md"))


def rows(text, cells):
    found = [re.split(r" *(?<!\\)\| *", line.strip("| ")) for line in text.splitlines() if line.startswith("| ")]
    return [row for row in found if len(row) == cells and row[0] in {fault.name for fault in FAULTS}]


def test_the_python_example_runs_and_prints_what_it_says(capsys):
    exec(re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1], {})  # noqa: S102
    assert capsys.readouterr().out == re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1]


def test_the_measured_page_has_a_row_a_fault_and_one_a_fault_and_law():
    assert [row[0] for row in rows(MEASURED, 7)] == [fault.name for fault in FAULTS]
    pairs = [(row[0], row[1]) for row in rows(MEASURED, 8)]
    assert pairs == [(fault.name, law) for fault in FAULTS for law in controllers.available()]
    for *_, share, state, reason in rows(MEASURED, 8):
        assert float(share) <= 1.0
        assert state in ("stopping", "stopped")
        assert reason


def test_the_table_and_the_sequences_of_the_page_are_the_measured_ones():
    short = [[row[0], row[2], row[3], row[5]] for row in rows(MEASURED, 7)]
    assert [row[:4] for row in rows(PAGE, 5)] == short
    for told, measured in zip(rows(PAGE, 5), rows(MEASURED, 7), strict=True):
        assert measured[6].startswith(told[4].rstrip("…"))
    sentence = re.search(r"^[\d,]+ sequences of .*$", MEASURED, re.MULTILINE)[0]
    assert sentence in " ".join(PAGE.split())
    assert "a bound was broken in 0 of them" in sentence
