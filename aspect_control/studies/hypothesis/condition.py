"""The runs of one arm under one setting, taken out of the table of a study."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..study_summary import grid_keys

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa


class Condition(NamedTuple):
    """The runs of all laws of a scenario at a grid point.

    Attributes:
        scenario: Name of the scenario.
        point: Number of the grid point.
        changes: What the point changes in the scenario, by the names of the fields.
        laws: Labels of the laws.
        rows: Their rows of the table, as many for each law.
    """

    scenario: str
    point: int
    changes: dict[str, Any]
    laws: tuple[str, ...]
    rows: pd.DataFrame


def conditions(table: pa.Table) -> list[Condition]:
    """Return every arm and setting of a table, in its order.

    A law that a grid point does not change is run once; its rows belong to every point that leaves it as it is. Motions
    of which the row of a law is missing, as at the end of an interrupted table, are left out.

    Args:
        table: What `Study.run` returns.
    """
    frame = table.to_pandas()
    keys = grid_keys(table)
    return [condition for _, rows in frame.groupby("scenario", sort=False) for condition in _of_scenario(rows, keys)]


def _of_scenario(rows: pd.DataFrame, keys: list[str]) -> Iterator[Condition]:
    import pandas as pd

    places = dict(iter(rows.groupby(["law", "point"], sort=False)))
    laws = tuple(dict.fromkeys(law for law, _ in places))
    own = {place: _values(part.iloc[0], keys) for place, part in places.items()}
    for point in sorted({point for _, point in places}):
        changes = {key: value for (_, at), values in own.items() if at == point for key, value in values.items()}
        chosen = {}
        for law in laws:
            foreign = tuple(f"controller.{other}." for other in laws if other != law)
            wanted = {key: value for key, value in changes.items() if not key.startswith(foreign)}
            found = [place for place in places if place[0] == law and (place[1] == point or own[place] == wanted)]
            if found:
                chosen[law] = places[next((place for place in found if place[1] == point), found[0])]
        joined = pd.concat(chosen.values())
        complete = joined.groupby("sample")["law"].transform("size") == len(chosen)
        yield Condition(str(rows["scenario"].iloc[0]), int(point), changes, tuple(chosen), joined[complete])


def _values(row: pd.Series[Any], keys: list[str]) -> dict[str, Any]:
    import pandas as pd

    values = ((key, row[key]) for key in keys if not pd.isna(row[key]))
    return {key: value.item() if isinstance(value, np.generic) else value for key, value in values}
