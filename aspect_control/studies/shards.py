"""The folder of a study: one Parquet file a chunk, each written whole or not at all."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..checks import file_path
from ..exceptions import DamagedShardWarning, OutputError, StudyError
from ..files import atomic_path, output_folder, write_text
from .definition import define
from .rows import ERROR
from .study import Study

if TYPE_CHECKING:
    import pyarrow as pa

RECORD = "study.json"
"""The file that says which study a folder belongs to."""


class ShardFolder:
    """Where a study's table grows.

    Attributes:
        study: The study.
        folder: The folder.
    """

    def __init__(self, study: Study, folder: str | Path) -> None:
        """Take a folder for a study; it is made if it is not there.

        Raises:
            StudyError: If it holds another study.
            OutputError: If it cannot be written to.
        """
        self.study, self.folder = study, output_folder(folder)
        record = self.folder / RECORD
        if record.exists():
            require_same(read_record(self.folder), record_of(study), self.folder)
        output_folder(self.folder / "shards")

    def begin(self) -> None:
        """Say whose the folder is."""
        text = json.dumps(record_of(self.study), indent=1, ensure_ascii=False)
        write_text(self.folder / RECORD, text + "\n")

    def path(self, chunk: int) -> Path:
        """Return the file of a chunk."""
        return self.folder / "shards" / f"{chunk:06d}.parquet"

    def finished(self, chunks: Iterable[int]) -> dict[int, int]:
        """Return the chunks that are there whole, and how many of their runs raised.

        One that is cut short is told of in a warning and counts as not there.

        Raises:
            StudyError: If one belongs to another study.
        """
        found = {}
        for chunk in chunks:
            path = self.path(chunk)
            if path.exists():
                try:
                    table = read_shard(path, self.study.hash, ["status"])
                except OutputError as error:
                    warnings.warn(f"{error}; its runs are made again", DamagedShardWarning, stacklevel=2)
                    continue
                if table.num_rows == len(self.study.rows_of(chunk)):
                    found[chunk] = failed_runs(table)
        return found

    def missing(self, shard: str | None = None) -> int:
        """Return how many runs of the study, or of a part of it, are not there.

        Raises:
            StudyError: If `shard` is no part, or a file belongs to another study.
        """
        chunks = self.study.chunks_of(shard)
        there = self.finished(chunks)
        return sum(len(self.study.rows_of(chunk)) for chunk in chunks if chunk not in there)

    def write(self, chunk: int, table: pa.Table) -> None:
        """Write the table of a chunk.

        Raises:
            OutputError: If it cannot be written, such as on a full disk; files already there stay.
        """
        import pyarrow.parquet as pq

        with atomic_path(self.path(chunk)) as temporary:
            pq.write_table(table, temporary)

    def clear(self, chunks: Iterable[int]) -> None:
        """Remove what is there of some chunks."""
        for chunk in chunks:
            self.path(chunk).unlink(missing_ok=True)

    def table(self) -> pa.Table:
        """Return all rows that are there.

        Raises:
            StudyError: If a file belongs to another study.
            OutputError: If one is cut short.
        """
        return read_folder(self.folder)


def record_of(study: Study) -> dict[str, Any]:
    """Return what the folder says of its study."""
    definition = study.definition.model_dump(mode="json", exclude={"folder"}, exclude_unset=True)
    return {
        "name": study.name,
        "hash": study.hash,
        "runs": study.runs,
        "definition": {**definition, "folder": str(study.definition.folder.resolve())},
        "identity": study.identity,
    }


def read_record(folder: Path) -> dict[str, Any]:
    """Return what a folder says of its study.

    Raises:
        StudyError: If it is no folder of a study.
    """
    record = file_path("the folder of a study", folder, StudyError) / RECORD
    try:
        found = json.loads(record.read_text(encoding="utf-8"))
        if isinstance(found, dict) and {"name", "hash", "runs", "definition", "identity"} <= found.keys():
            return found
    except FileNotFoundError:
        raise StudyError(f"{folder} is no folder of a study: it has no {RECORD}") from None
    except (OSError, ValueError) as error:
        raise StudyError(f"cannot read {record}: {error}") from None
    raise StudyError(f"{record} does not describe a study")


def require_same(found: dict[str, Any], wanted: dict[str, Any], folder: Path) -> None:
    """Make sure that a folder belongs to a study.

    Raises:
        StudyError: If it does not; the message names what differs.
    """
    if found["hash"] == wanted["hash"]:
        return
    changes = list(_differences(found["identity"], json.loads(json.dumps(wanted["identity"]))))
    changes = changes[:3] + (["..."] if len(changes) > 3 else [])
    raise StudyError(
        f"{folder} holds the study {found['name']!r} ({found['hash'][:8]}), which is not this one "
        f"({wanted['hash'][:8]}): {'; '.join(changes) or 'the robots differ'}. Give another folder, or the old file"
    )


def read_folder(folder: Path) -> pa.Table:
    """Return all rows of a folder, in the order of the whole table.

    Raises:
        StudyError: If it is no folder of a study, or a file belongs to another one.
        OutputError: If a file is cut short.
    """
    record = read_record(folder)
    paths = sorted((folder / "shards").glob("[0-9]*.parquet"))
    if not paths:
        raise StudyError(f"{folder} has no runs yet")
    return in_order([read_shard(path, record["hash"]) for path in paths])


def study_of(folder: Path) -> Study:
    """Return the study that a folder belongs to.

    Raises:
        StudyError: If it is no folder of a study, or what the study is made of has changed since.
        AspectControlError: If a scenario or its robot cannot be read any more.
    """
    record = read_record(folder)
    definition = dict(record["definition"])
    study = Study(define(str(folder), definition, Path(definition.pop("folder"))), record["name"])
    require_same(record, record_of(study), folder)
    return study


def merge_folders(folders: Sequence[Path], out: Path) -> tuple[pa.Table, int]:
    """Put the parts of a study into one Parquet file.

    Args:
        folders: Folders of parts of one study.
        out: The file to write.

    Returns:
        The table, in the order of the whole, and how many runs are missing in it.

    Raises:
        StudyError: If the folders belong to different studies.
        OutputError: If a file is cut short, or `out` cannot be written.
    """
    import pyarrow.parquet as pq

    first, *others = [read_record(folder) for folder in folders]
    for folder, record in zip(folders[1:], others, strict=True):
        require_same(record, first, folder)
    table = in_order([read_folder(folder) for folder in folders])
    with atomic_path(out) as temporary:
        pq.write_table(table, temporary)
    return table, int(first["runs"]) - table.num_rows


def in_order(tables: Sequence[pa.Table]) -> pa.Table:
    """Return the rows of several tables in the order of the whole, each once."""
    import numpy as np
    import pyarrow as pa

    table = pa.concat_tables(tables)
    _, firsts = np.unique(table.column("row").to_numpy(), return_index=True)
    return table.take(firsts).combine_chunks()


def read_shard(path: Path, study: str, columns: list[str] | None = None) -> pa.Table:
    """Read the file of a chunk.

    Raises:
        StudyError: If it belongs to another study.
        OutputError: If it is cut short or no Parquet file.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path, columns=columns, partitioning=None)
    except (OSError, pa.ArrowException) as error:
        raise OutputError(f"{path} is cut short or no Parquet file ({' '.join(str(error).split())[:120]})") from error
    owner = (table.schema.metadata or {}).get(b"study", b"").decode()
    if owner != study:
        raise StudyError(
            f"{path} belongs to {f'another study ({owner[:8]})' if owner else 'no study'}, the folder to {study[:8]}: "
            "move it elsewhere"
        )
    return table


def failed_runs(table: pa.Table) -> int:
    """Return how many runs of a table raised."""
    return sum(status == ERROR for status in table.column("status").to_pylist())


def _differences(found: Any, wanted: Any, path: str = "") -> Any:
    if isinstance(found, dict) and isinstance(wanted, dict):
        for key in {**found, **wanted}:
            yield from _differences(found.get(key), wanted.get(key), f"{path}.{key}".lstrip("."))
    elif found != wanted:
        yield f"{path} was {_short(found)} and is {_short(wanted)}"


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."
