"""Tables of studies that were never run, for what reads them."""

import pyarrow as pa

DEFAULTS = {
    "study": "0123456789abcdef",
    "scenario": "arm",
    "sample": 0,
    "law": "jmdc",
    "seed": 1,
    "point": 0,
    "parameters": "{}",
    "dt": 1e-3,
    "status": "finished",
    "message": "finished at t = 1 s",
    "peak_torque": 10.0,
    "torque_squared_integral": 100.0,
    "aspect_preserved": True,
    "tracking_error_max": 1e-3,
    "wall_time": 0.5,
    "version.python": "3.13.0",
    "version.numpy": "2.4.0",
    "kernels": "numpy",
}
METRICS = ("peak_torque", "torque_squared_integral", "aspect_preserved", "tracking_error_max")
"""What a run that failed lacks."""


def table_of(*rows, keys=()):
    """The table of a study: what each run has that the others have not, and the keys of the grid."""
    names = [*list(DEFAULTS)[:6], *keys, *list(DEFAULTS)[6:]]
    whole = [{**DEFAULTS, **dict.fromkeys(keys), **row} for row in rows]
    return pa.table({name: [row[name] for row in whole] for name in names})


def failed(message="J has lost rank", **row):
    """A run that raised."""
    return {**row, "status": "error", "message": message, **dict.fromkeys(METRICS)}
