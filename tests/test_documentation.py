"""What README and docs say is what the code does."""

import re
from pathlib import Path

import pytest

from aspect_control.analysis import summarize
from aspect_control.analysis import trajectory_a as paper

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def test_the_table_of_laws_is_what_reproduce_measures():
    rows = dict(re.findall(r"^\| `([\w-]+)` \| ([\d.,]+ N m \| \d+ \| [\d.]+ mm) \|$", README, re.MULTILINE))
    assert tuple(rows) == paper.LAWS
    for law, row in rows.items():
        peak, changes, error = re.findall(r"[\d.,]+", row)
        summary = summarize(paper.run_law(law, 1e-3))
        assert float(peak.replace(",", "")) == pytest.approx(max(summary["peak_torque"]), rel=5e-3)
        assert int(changes) == len(summary["minor_zero_crossings"])
        assert float(error) == pytest.approx(1e3 * summary["max_tracking_error"], rel=0.03)


def test_the_python_examples_run(tmp_path, monkeypatch, capsys):
    (tmp_path / "models").symlink_to(ROOT / "models")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL):
        exec(block, names)  # noqa: S102
    assert capsys.readouterr().out.startswith("finished 18.0")
    assert names["again"] == names["run"]
    law = names["DampedSelfMotion"](names["arm"])
    assert law.torque(names["q"], names["v"], names["target"]).shape == (3,)


def test_links_lead_somewhere():
    for document in (README, (ROOT / "docs" / "report.md").read_text()):
        folder = ROOT if document is README else ROOT / "docs"
        for target in re.findall(r"\]\(((?!http)[^)]+)\)", document):
            assert (folder / target).exists(), target


def test_the_claims_counted_in_the_readme_are_those_of_the_report():
    report = (ROOT / "docs" / "report.md").read_text()
    counted = {verdict: len(re.findall(rf"\| {verdict} \|", report)) for verdict in ("agrees", "partly", "differs")}
    sentence = " ".join(re.search(r"holds \[.*?do not\.", README, re.DOTALL)[0].split())
    assert sentence.endswith(
        f"{counted['agrees']} agree, {counted['partly']} agree in part, {counted['differs']} do not."
    )


def test_the_two_shell_lines_are_where_ci_looks_for_them():
    for marker, ending in (("reproduce", "aspect-control reproduce"), ("test", "pytest")):
        line = re.search(rf"<!-- {marker} -->\n```shell\n(.*)\n```", README)[1]
        assert line.startswith("python3 -m venv .venv && .venv/bin/pip install ")
        assert line.endswith(f".venv/bin/{ending}")
