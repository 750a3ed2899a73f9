"""The rows of a study's table: one run each, in plain columns."""

from __future__ import annotations

import json
import time
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import AspectControlError
from ..redundancy import kernels_compiled
from ..simulation.metrics import METRICS
from ..simulation.run_file import versions
from ..trajectories import StraightLine
from .cases import Place
from .study import Study

if TYPE_CHECKING:
    import pyarrow as pa

ERROR = "error"
"""Status of a run that raised; `message` says what, and it has no metrics."""

_BEFORE: dict[str, type] = {
    "study": str,
    "row": int,
    "scenario": str,
    "sample": int,
    "law": str,
    "controller": str,
    "robot": str,
    "task": str,
    "seed": int,
    "point": int,
}
_AFTER: dict[str, type] = {
    "parameters": str,
    "plant": str,
    "dt": float,
    "duration": float,
    "path_length": float,
    "path_angle": float,
    "on_border": int,
    "wrong_length": int,
    "minors": int,
    "redundancy": int,
    "status": str,
    "message": str,
}
_PACKAGES = ("python", "aspect-control", "pin", "numpy")

UNREPEATABLE = ("wall_time", "kernels", *(f"version.{name}" for name in _PACKAGES))
"""Columns that say how a run was computed, and may differ from one machine to another."""


def columns(study: Study) -> dict[str, type]:
    """Return the columns of a study's table and the types of their values.

    - `study`: the hash; `row`: the number of the row in the whole table, see `Study.place`.
    - `scenario`, `sample`, `law`, `point`: which run it is; `controller`: the registry name of the law; `robot` and
      `task`; `seed`: that of the draws.
    - One column a field that the grid changes, null where that concerns another law; a value that is no number, text
      or truth value is written as JSON.
    - `parameters`: all of the law's as JSON; `plant`; `dt` (s); `duration` (s) of the motion, `path_length` (m) and
      `path_angle` (rad) of a straight line; `on_border` and `wrong_length`: how often a random motion was drawn again.
    - `minors`: how many are not structurally zero; `redundancy`: n − m.
    - `status` and `message`, then what `Run.metrics` returns.
    - `wall_time` (s), `kernels` and `version.…`: how the run was computed.
    """
    return {
        **_BEFORE,
        **{key: _type_of([point[key] for point in study.points if key in point]) for key in study.definition.keys},
        **_AFTER,
        **METRICS,
        "wall_time": float,
        "kernels": str,
        **{f"version.{name}": str for name in _PACKAGES},
    }


def make_row(study: Study, row: int) -> dict[str, Any]:
    """Make a run of a study and return its row; a run that raises an error of ours has the status `ERROR`.

    Args:
        study: The study.
        row: Number of the row.
    """
    place, started = study.place(row), time.perf_counter()
    described: dict[str, Any] = {"study": study.hash, "row": row, **place._asdict()}
    try:
        described |= _describe(study, place)
        run = study.record(*place)
        outcome = {"status": run.status, "message": run.message, **run.metrics()}
    except AspectControlError as error:
        outcome = {"status": ERROR, "message": str(error)}
    spent = time.perf_counter() - started
    return {**described, **outcome, "wall_time": spent, **_computed_by(kernels_compiled())}


def to_table(study: Study, rows: list[dict[str, Any]]) -> pa.Table:
    """Return rows as a table with the columns of the study, whatever is null in them."""
    import pyarrow as pa

    kinds = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
    schema = pa.schema([(name, kinds[kind]) for name, kind in columns(study).items()])
    return pa.Table.from_pylist(rows, schema=schema.with_metadata({"study": study.hash, "name": study.name}))


def _describe(study: Study, place: Place) -> dict[str, Any]:
    setup, motion = study.setup(place.scenario, place.point), study.motion(place.scenario, place.sample, place.point)
    law, case, line = setup.laws[place.law], study.case(place), motion.trajectory
    displacement = line.displacement if isinstance(line, StraightLine) else None
    types = columns(study)
    return {
        "controller": law.name,
        "robot": setup.arm.name,
        "task": ",".join(setup.arm.task),
        "seed": study.definition.motions.seed,
        **{key: _plain(value, types[key]) for key, value in case.changes.items()},
        "parameters": json.dumps(law.parameters, sort_keys=True),
        "plant": setup.plant.name,
        "dt": setup.dt,
        "duration": line.duration,
        "path_length": _norm(displacement, setup.arm.coordinates.position_rows),
        "path_angle": _norm(displacement, setup.arm.coordinates.rotation_rows),
        "on_border": motion.on_border,
        "wrong_length": motion.wrong_length,
        "minors": len(setup.arm.minor_columns),
        "redundancy": setup.arm.redundancy,
    }


def _norm(displacement: Any, rows: Any) -> float | None:
    return None if displacement is None or not len(rows) else float(np.linalg.norm(displacement[rows]))


def _type_of(values: list[Any]) -> type:
    """Return the type of a grid's column: text unless all are truth values, all whole numbers or all numbers."""
    kinds = {type(value) for value in values}
    for kind in (bool, int, float):
        if kinds <= ({int, float} if kind is float else {kind}):
            return kind
    return str


def _plain(value: Any, kind: type) -> Any:
    if kind is str and not isinstance(value, str):
        return json.dumps(value, sort_keys=True)
    return kind(value)


@cache
def _computed_by(compiled: bool) -> dict[str, str]:
    return {
        "kernels": f"numba {version('numba')}" if compiled else "numpy",
        **{f"version.{name}": number for name, number in versions().items()},
    }
