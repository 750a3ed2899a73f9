"""What the ratios are to be, and whether they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .literal import LAWS
from .programs import FREE, HELD, SCALED, SEARCHED
from .timing import Row

TICK = "Panda, xyz: tick"


@dataclass(frozen=True)
class Verdict:
    """A target and what was measured.

    Attributes:
        target: The target in words.
        bound: The ratio that is to be reached.
        measured: The measured ratio; None if a part of it was not measured.
        at_least: Whether the ratio is to be at least the bound, not at most.
    """

    target: str
    bound: float
    measured: float | None
    at_least: bool = False

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None if it was not measured."""
        if self.measured is None:
            return None
        return self.measured >= self.bound if self.at_least else self.measured <= self.bound

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict as plain data."""
        return {"target": self.target, "bound": self.bound, "measured": self.measured, "met": self.met}


def verdicts(rows: list[Row]) -> list[Verdict]:
    """Hold the rows against the targets."""
    found = {(row.group, row.name): row for row in rows}

    def between(group: str, name: str, other: str) -> float | None:
        one, two = found.get((group, name)), found.get((group, other))
        return None if one is None or two is None else float(np.median(one.seconds / two.seconds))

    rival = "Panda, xyz: rivals"
    result = [Verdict(f"tick of {law} ≤ 2 × floor", 2.0, between(TICK, law, "floor")) for law in LAWS if law != "jmdc"]
    result += [
        Verdict(f"{law} ≥ 8 × faster than literal", 8.0, between(TICK, f"{law}, literal", law), at_least=True)
        for law in LAWS
    ]
    result += [
        Verdict(f"tick of {law} ≤ 1.5 × PlaCo's", 1.5, between(rival, law, "PlaCo DynamicsSolver"))
        for law in ("pseudoinverse", "null-space-vector")
    ]
    pinv = between("Panda, xyz: J⁺", "numpy pinv", "aspect-control")
    loop = "Panda, xyz: closed loop, "
    name = "a sample of the run"
    many = next((row for row in rows if row.group == "chain of 20, xyz" and row.name != "floor"), None)
    started = {row.name: row for row in rows if row.group == "start"}
    result += [
        Verdict("J⁺ ≥ 10 × faster than numpy.linalg.pinv", 10.0, pinv, at_least=True),
        Verdict("jmdc, 19 minors and gradient ≤ 3 × floor", 3.0, between(TICK, "jmdc", "floor")),
        Verdict("modified ≤ 1.3 × jmdc", 1.3, between(TICK, "modified-null-space-vector", "jmdc")),
        Verdict("1,140 minors and ∇H ≤ 20 × floor", 20.0, many.ratio if many else None),
    ]
    for group in (FREE, HELD, SEARCHED, SCALED):
        for solver, bound in (("osqp", 10.0), ("daqp", 5.0)):
            what = f"{group.removeprefix('Panda, xyz: ')}: {solver} ≤ {bound:g} × floor"
            result.append(Verdict(what, bound, between(group, solver, "floor")))
    for law in ("pseudoinverse", "null-space-vector", "jmdc"):
        row = found.get((loop + law, name))
        result.append(Verdict(f"sample of a run of {law} ≤ 3 × (tick + four ABA)", 3.0, row.ratio if row else None))
    if started:
        package, shown = started["import aspect_control"], started["aspect-control --help"]
        result.append(Verdict("import aspect_control ≤ 2.5 × import pinocchio", 2.5, package.ratio))
        beyond = float(np.median(shown.seconds - package.seconds))
        result.append(Verdict("aspect-control --help ≤ that import + 0.5 s", 0.5, beyond))
    return result
