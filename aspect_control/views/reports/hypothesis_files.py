"""The files that make up a report about the hypothesis, or a page about several studies."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...checks import file_path
from ...exceptions import StudyError
from ...files import output_folder, write_text
from ...studies.hypothesis import Evidence, Part, evidence, results_of, stored
from ..figures.hypothesis_figure import hypothesis_figure
from ..figures.run_figures import save_figure
from ..figures.shares_figure import shares_figure
from .hypothesis_report import filled_page, hypothesis_fields, hypothesis_report

if TYPE_CHECKING:
    import pyarrow as pa

    from ...studies import Study


def write_hypothesis(
    study: Study, table: pa.Table, folder: Path, progress: Callable[[str, float], None], *, check: bool = True
) -> list[str]:
    """Write what a study says about the hypothesis; as `write_report`.

    Args:
        study: The study.
        table: Its table, which is written to one Parquet file.
        folder: Where the files go.
        progress: As for `write_report`.
        check: Whether to run the counterexamples again, sampled more finely.
    """
    part = stored(study, table, folder)
    found = evidence([part], check=check, progress=progress)
    figures = _figures(found, [part])
    for name, figure in figures.items():
        for ending in ("png", "svg"):
            save_figure(figure, folder / f"{name}.{ending}")
    write_text(folder / "hypothesis.md", hypothesis_report(found, list(figures)))
    write_text(folder / "hypothesis.json", _json(found))
    drawn = [f"{name}.{ending}" for name in figures for ending in ("png", "svg")]
    return ["hypothesis.md", "hypothesis.json", part.file, *drawn]


def read_template(path: Path) -> str:
    """Return the text of a page whose fields are to be filled in.

    Raises:
        StudyError: If it cannot be read.
    """
    try:
        return file_path("the template", path, StudyError).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(f"cannot read the template {path}: {getattr(error, 'strerror', None) or error}") from None


def write_page(template: str, parts: Sequence[Part], out: Path, progress: Callable[[str, float], None]) -> list[str]:
    """Fill a page with what studies say about the hypothesis.

    Args:
        template: The text of the page, with fields such as `${verdict}`; see `hypothesis_fields`.
        parts: The studies and their tables.
        out: Folder for `hypothesis.md`, `hypothesis.json` with the numbers, and the figures in `images`.
        progress: Called with what is being done and the part of the work that is done, 0 to 1.

    Returns:
        The names of the files, the page first.

    Raises:
        StudyError: If the page asks for a field that there is not.
        OutputError: If a file cannot be written.
        AspectControlError: If a counterexample cannot be run again.
    """
    found = evidence(parts, progress=progress)
    text, figures = filled_page(template, hypothesis_fields(found)), _figures(found, parts)
    images = output_folder(output_folder(out) / "images")
    for name, figure in figures.items():
        save_figure(figure, images / f"{name}.png")
    write_text(out / "hypothesis.md", text)
    write_text(out / "hypothesis.json", _json(found))
    return ["hypothesis.md", "hypothesis.json", *(f"images/{name}.png" for name in figures)]


def _figures(found: Evidence, parts: Sequence[Part]) -> dict[str, Any]:
    """Return the figures by name: arms and settings side by side, and each arm as its scenario has it by itself."""
    conditions = found["conditions"]
    groups = {"hypothesis-arms": [each for each in conditions if not each["setting"]]}
    groups["hypothesis-settings"] = [each for each in conditions if each["setting"]]
    figures = {name: shares_figure(rows) for name, rows in groups.items() if len(rows) > 1}
    results = [result for part in parts for result in results_of(part)]
    for each, result in zip(conditions, results, strict=True):
        if not each["setting"]:
            figures[f"hypothesis-{each['scenario']}"] = hypothesis_figure(result)
    return figures


def _json(found: Evidence) -> str:
    return json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
