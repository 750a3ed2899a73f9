"""What studies came to: reports, figures, and pages whose figures are filled in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .application import as_json
from .study_commands import studies

if TYPE_CHECKING:
    from ..studies.hypothesis import Evidence, Part


@studies.command()
def report(
    folders: Annotated[list[Path], typer.Argument(help="Folders of studies that one report is made of.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the report; the first of them unless given.")] = None,
    template: Annotated[
        Path | None, typer.Option(help="A page with fields such as ${verdict}, which is filled in instead.")
    ] = None,
) -> None:
    """Report what studies came to: tables, figures and what follows from them."""
    report_on_hypothesis(folders, out or folders[0], template)


def report_on_hypothesis(
    folders: Sequence[Path], out: Path, template: Path | None = None, *, check: bool = True
) -> Evidence:
    """Write what studies say about the hypothesis: a page, its figures and their numbers, and show them.

    Args:
        folders: The folders of the studies.
        out: Folder to write to.
        template: The page whose fields are filled in; None for a report of everything.
        check: Whether to run the counterexamples again, sampled more finely.

    Returns:
        The numbers.

    Raises:
        AspectControlError: If a study is not whole, or something cannot be written.
    """
    from ..files import output_folder, write_text
    from ..studies.hypothesis import evidence, results_of
    from ..views import (
        filled_page,
        hypothesis_fields,
        hypothesis_figure,
        hypothesis_report,
        hypothesis_rows,
        save_figure,
        shares_figure,
    )
    from ..views.progress import progress_bar
    from ..views.screen import show_table

    page = None if template is None else template.read_text(encoding="utf-8")
    parts = [_part(folder) for folder in folders]
    with progress_bar() as progress:
        found = evidence(parts, check=check, progress=progress)
    arms = [each for each in found["conditions"] if not each["setting"]]
    settings = [each for each in found["conditions"] if each["setting"]]
    images = output_folder(output_folder(out) / "images")
    figures: dict[str, Any] = {}
    for name, rows in (("hypothesis-arms", arms), ("hypothesis-settings", settings)):
        if len(rows) > 1:
            figures[name] = shares_figure(rows)
    for part in parts:
        if part.study.definition.motions.legs == 1 and len(part.study.points) == 1:
            figures |= {f"hypothesis-{each.condition.scenario}": hypothesis_figure(each) for each in results_of(part)}
    for name, figure in figures.items():
        save_figure(figure, images / f"{name}.png")
    if page is None:
        text = hypothesis_report(found, list(figures))
    else:
        text = filled_page(page, hypothesis_fields(found), str(template))
    write_text(out / "hypothesis.md", text)
    write_text(out / "hypothesis.json", as_json(found))
    for each in found["conditions"]:
        typer.echo(f"{each['scenario']}{': ' if each['setting'] else ''}{each['setting']}")
        show_table(("law", "kept: calm", "exploded", "left: calm", "exploded", "calm if left"), hypothesis_rows(each))
    typer.echo(hypothesis_fields(found)["verdict"])
    typer.echo(f"written to {out}: hypothesis.md, hypothesis.json and images")
    return found


def _part(folder: Path) -> Part:
    """Return the study of a folder, with its table in one file whose hash can be told."""
    from ..files import sha256
    from ..studies.hypothesis import Part
    from ..studies.shards import merge_folders, study_of

    study = study_of(folder)
    file = folder / f"{study.name}.parquet"
    table, _ = merge_folders([folder], file)
    return Part(study, table, file.name, sha256(file))
