"""How far a study has come."""

from __future__ import annotations

from typing import NamedTuple


class StudyProgress(NamedTuple):
    """How far a study has come.

    Attributes:
        total: Number of runs to be there in the end.
        done: Number of runs that are there.
        failed: How many of them raised.
        made: How many of them were made since the study was begun or resumed.
        seconds: Time since then, s.
    """

    total: int
    done: int
    failed: int
    made: int
    seconds: float

    @property
    def rate(self) -> float:
        """Runs a second; 0 before the first."""
        return self.made / self.seconds if self.seconds > 0.0 else 0.0

    @property
    def remaining(self) -> float | None:
        """Time that the rest takes at this rate, s; None before the first run."""
        return (self.total - self.done) / self.rate if self.rate > 0.0 else None
