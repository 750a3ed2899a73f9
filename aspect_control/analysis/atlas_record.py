"""What an atlas, and the paths of runs over it, come to in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..aspects import Atlas, growth, self_motion
from ..simulation import Run
from ..simulation.metrics import minor_zero_crossings
from .self_motion_of_run import self_motion_of_run

_COMPARED = 200
"""Samples of a path whose signs are compared with those of the slice."""


def atlas_record(atlas: Atlas, runs: Mapping[str, Run]) -> dict[str, Any]:
    """Return what an atlas and the paths over it come to as plain numbers, strings and lists, for JSON.

    Args:
        atlas: The atlas.
        runs: Runs of the same arm by the labels of their laws.

    Returns:
        What `Atlas.to_dict` has; `paths`, by label: `sign_changes` of minors, `agreement` of the signs with those of
        the slice, 0 to 1. With one redundant degree of freedom also `maciejewski_product_max` (rad²/s³) and its time
        (s), and at that moment `own_product`, −c ṡ³ (rad²/s³), `c` (1/rad) and `self_motion_speed`, ṡ (rad/s); and for
        the free self-motion through the start of the slice `self_motion`: `length` (rad), `closed`, `growth` from end
        to end, or once round, and `largest_growth`.
    """
    record = {**atlas.to_dict(), "paths": {label: _path(atlas, run) for label, run in runs.items()}}
    if atlas.stability is not None:
        curve = self_motion(atlas.arm, atlas.arm.configuration(atlas.slice.start))
        grown = growth(curve)
        record["self_motion"] = {
            "length": curve.length,
            "closed": curve.closed,
            "growth": grown.factor,
            "largest_growth": grown.largest_factor,
        }
    return record


def _path(atlas: Atlas, run: Run) -> dict[str, Any]:
    picked = np.linspace(0, len(run.q) - 1, min(len(run.q), _COMPARED)).astype(int)
    path = {
        "sign_changes": len(minor_zero_crossings(run)),
        "agreement": atlas.agreement(np.array([run.arm.positions(run.q[i]) for i in picked])),
    }
    if atlas.stability is not None:
        own, peak = self_motion_of_run(run), int(run.maciejewski_product.argmax())
        path |= {
            "maciejewski_product_max": float(run.maciejewski_product[peak]),
            "maciejewski_product_max_time": float(run.t[peak]),
            "own_product": float(own.own_product[peak]),
            "c": float(own.c[peak]),
            "self_motion_speed": float(own.speed[peak]),
        }
    return path
