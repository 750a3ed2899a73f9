"""What the tables of one or more studies say about the hypothesis, as one document of plain data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...files import atomic_path, sha256
from ..study import Study
from ..study_summary import THRESHOLD
from .condition import conditions
from .result import THRESHOLDS, HypothesisResult

if TYPE_CHECKING:
    import pyarrow as pa

Evidence = dict[str, Any]
"""What `evidence` returns."""


class Part(NamedTuple):
    """A study and what came of it.

    Attributes:
        study: The study.
        table: Its table, or what there is of it.
        file: Name of the file that holds the table.
        sha256: SHA-256 of that file.
    """

    study: Study
    table: pa.Table
    file: str
    sha256: str


def stored(study: Study, table: pa.Table, folder: Path) -> Part:
    """Return a study and its table, which is written to one file, `NAME.parquet`.

    Args:
        study: The study.
        table: What came of it.
        folder: Where the file goes.

    Raises:
        OutputError: If it cannot be written.
    """
    import pyarrow.parquet as pq

    path = folder / f"{study.name}.parquet"
    with atomic_path(path) as temporary:
        pq.write_table(table, temporary)
    return Part(study, table, path.name, sha256(path))


def results_of(part: Part) -> list[HypothesisResult]:
    """Return what came of every arm and setting of a study."""
    return [HypothesisResult(condition) for condition in conditions(part.table)]


def evidence(
    parts: Sequence[Part], *, check: bool = True, progress: Callable[[str, float], None] | None = None
) -> Evidence:
    """Return what the tables of studies say, as plain data for JSON; the reports are made of it.

    Args:
        parts: The studies and their tables.
        check: Whether to run the counterexamples again at a quarter of the sampling time.
        progress: Called with what is being done and the part of all work that is done, 0 to 1.

    Returns:
        `thresholds` and `threshold`; `sources`, one a study: its name, hash, file, SHA-256, how many runs it has and
        how many are in the table, and with what they were computed; `conditions`, one an arm and setting: what
        `HypothesisResult.to_dict` returns with `study`, `legs` of the motions, and `setting`, in words what is other
        than in the scenario, empty for an arm as its scenario has it; `counterexamples`, the clearest of each such arm.

    Raises:
        AspectControlError: If a run cannot be made again.
    """
    tell = progress or (lambda label, part: None)
    found, clearest = [], []
    for number, part in enumerate(parts):
        tell(f"statistics of {part.study.name}", 0.5 * number / len(parts))
        results = results_of(part)
        legs, alone = part.study.definition.motions.legs, len(part.study.points) == 1
        for result in results:
            setting = _setting({} if alone else result.condition.changes, legs)
            found.append({"study": part.study.name, "setting": setting, "legs": legs, **result.to_dict()})
            clearest += [(part.study, each) for each in ([] if setting else result.clearest())]
    examples = []
    for number, (study, each) in enumerate(clearest):
        tell(f"counterexample {number + 1} of {len(clearest)}, sampled more finely", 0.5 + 0.5 * number / len(clearest))
        examples.append({"study": study.name, **asdict(each.checked(study) if check else each)})
    return {
        "thresholds": list(THRESHOLDS),
        "threshold": THRESHOLD,
        "sources": [_source(part) for part in parts],
        "conditions": found,
        "counterexamples": examples,
    }


def _setting(changes: dict[str, Any], legs: int) -> str:
    words = [
        f"{key.partition('.')[2] or key} = {f'{value:g}' if isinstance(value, float) else value}"
        for key, value in changes.items()
    ]
    return ", ".join([*words, *([f"{legs} legs"] if legs > 1 else [])])


def _source(part: Part) -> dict[str, Any]:
    table, names = part.table, ("kernels", *(name for name in part.table.column_names if name.startswith("version.")))
    return {
        "name": part.study.name,
        "study": part.study.hash,
        "file": part.file,
        "sha256": part.sha256,
        "runs": part.study.runs,
        "rows": table.num_rows,
        "motions": part.study.motions,
        **{name: ", ".join(sorted({str(each) for each in table.column(name).unique().to_pylist()})) for name in names},
    }
