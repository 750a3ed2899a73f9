"""Whether a self-motion runs away: by its growth, together with that of the energy."""

from __future__ import annotations

from math import hypot, inf
from typing import NamedTuple

from ..redundancy import Array

GROWTH = 1.05
"""Least factor by which ‖θ̇_H‖ and the kinetic energy have to grow from one look to the next."""

LOOKS = 3
"""How many looks after one another they have to grow for that."""

FACTOR, SLACK = 2.0, 2.0
"""How much faster than the motion of the task a self-motion has to be for that: a factor, and rad/s."""


class Growth(NamedTuple):
    """What is kept from one look to the next.

    Attributes:
        self_motion: ‖θ̇_H‖, rad/s.
        energy: Kinetic energy ½θ̇ᵀMθ̇, J.
        looks: Looks after one another at which both had grown.
    """

    self_motion: float = inf
    energy: float = inf
    looks: int = 0

    def after(self, v: Array, M: Array, Vt: Array, of_task: Array) -> tuple[Growth, str]:
        """Look once more, and return what is to be kept, and what is wrong; empty if nothing is.

        A self-motion that is being built up at every instant grows by a factor in equal times, and so does the energy
        that it takes from the motors. In a calm motion the one that the task leaves grows with the motion, and stays
        small beside it.

        Args:
            v: Joint velocity θ̇, shape (n,), rad/s.
            M: Joint-space inertia matrix, shape (n, n), kg m².
            Vt: Right singular vectors of J as rows, shape (m, n).
            of_task: J⁺ẋ_d, the least joint velocity that follows the target, shape (n,), rad/s.
        """
        self_motion, energy = hypot(*(v - Vt.T @ (Vt @ v)).tolist()), float(v @ (M @ v)) / 2.0
        grown = self_motion > GROWTH * self.self_motion and energy > GROWTH * self.energy
        count = self.looks + 1 if grown else 0
        needed, reason = hypot(*of_task.tolist()), ""
        if count >= LOOKS and self_motion > FACTOR * needed + SLACK:
            reason = (
                f"the motion diverges: the self-motion has grown to {self_motion:.3g} rad/s and the kinetic energy to "
                f"{energy:.3g} J, at each of the last {count} looks by more than {100.0 * (GROWTH - 1.0):.0f} %; the "
                f"task needs {needed:.3g} rad/s"
            )
        return Growth(self_motion, energy, count), reason
