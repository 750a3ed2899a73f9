"""What the ratios are to be, and whether they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.literal import LAWS

from .guards import ADDED
from .timing import COMPILED, NUMPY, EveryTick, Row

TICKS = {NUMPY: (9.0, 20.0), COMPILED: (2.5, 3.5)}
"""The most that a tick of a law in closed form, and one of `jmdc`, may take, in floors."""

SOLVERS = {"osqp": (10.0, 40.0), "daqp": (6.0, 15.0)}
"""The most that the median, and the 99.9th percentile, of the ticks of `qp` with a solver may take, in floors."""

TARGET = 0.58
"""The most that a trajectory's target may take, in floors: 3 µs where the floor takes 5.2."""


GUARD = 1.0
"""The most that a guard may add to a tick, in floors."""


@dataclass(frozen=True)
class Verdict:
    """A target and what was measured.

    Attributes:
        target: The target in words.
        bound: The ratio that is to be reached.
        measured: The measured ratio; None if a part of it was not measured.
    """

    target: str
    bound: float
    measured: float | None

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None if it was not measured."""
        return None if self.measured is None else self.measured <= self.bound

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict as plain data."""
        return {"target": self.target, "bound": self.bound, "measured": self.measured, "met": self.met}


def verdicts(rows: list[Row]) -> list[Verdict]:
    """Hold the rows against the targets."""
    found = {(row.group, row.name): row for row in rows}

    def between(group: str, name: str, other: str) -> float | None:
        one, two = found.get((group, name)), found.get((group, other))
        return None if one is None or two is None else float(np.median(one.seconds / two.seconds))

    result = []
    for mode, (closed_form, of_jmdc) in TICKS.items():
        for law in LAWS:
            bound = of_jmdc if law == "jmdc" else closed_form
            measured = between(f"Panda, xyz: tick, {mode}", law, "floor")
            result.append(Verdict(f"tick of {law}, {mode} ≤ {bound:g} × floor", bound, measured))
    for law in ("pseudoinverse", "null-space-vector"):
        measured = between(f"Panda, xyz: rivals, {COMPILED}", law, "PlaCo DynamicsSolver")
        result.append(Verdict(f"tick of {law}, {COMPILED} ≤ 1.1 × PlaCo's", 1.1, measured))
    result += _of_programs(rows)
    for mode in TICKS:
        for law in ("pseudoinverse", "null-space-vector", "jmdc"):
            group = f"Panda, xyz: closed loop, {law}, {mode}"
            row = found.get((group, "a sample of the run"))
            what = f"sample of a run of {law}, {mode} ≤ 1.6 × (tick + four ABA)"
            result.append(Verdict(what, 1.6, row.ratio if row else None))
    measured = between(f"Panda, xyz: closed loop, pseudoinverse, {NUMPY}", "target", "floor")
    result.append(Verdict(f"a trajectory's target ≤ {TARGET:g} × floor", TARGET, measured))
    for mode in TICKS:
        for law in ("pseudoinverse", "jmdc"):
            row = found.get((f"Panda, xyz: a guard around {law}, {mode}", ADDED))
            what = f"what a guard adds to a tick of {law}, {mode} ≤ {GUARD:g} × floor"
            result.append(Verdict(what, GUARD, row.ratio if row else None))
    return result + _of_starting(found)


def _of_programs(rows: list[Row]) -> list[Verdict]:
    """Return the verdicts on `qp` for every motion of which every tick was timed."""
    result = []
    for row in rows:
        if isinstance(row, EveryTick) and row.name in SOLVERS:
            median, worst = SOLVERS[row.name]
            what = f"{row.group.removeprefix('Panda, xyz: ')}: {row.name}"
            result.append(Verdict(f"{what}, median ≤ {median:g} × floor", median, row.ratio))
            percentile = row.percentiles["99.9th percentile"]
            result.append(Verdict(f"{what}, 99.9th percentile ≤ {worst:g} × floor", worst, percentile))
    return result


def _of_starting(found: dict[tuple[str, str], Row]) -> list[Verdict]:
    package, shown = found.get(("start", "import aspect_control")), found.get(("start", "aspect-control --help"))
    if package is None or shown is None:
        return []
    beyond = float(np.median(shown.seconds - package.seconds))
    return [
        Verdict("import aspect_control ≤ 2.5 × import pinocchio", 2.5, package.ratio),
        Verdict("aspect-control --help ≤ that import + 0.5 s", 0.5, beyond),
    ]
