"""More torque than a joint has."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...arm import Arm
from ...limits import FROM_FILE, joint_limit
from ...redundancy import Array
from .event import Event, Sample


class TorqueLimit(Event):
    """The law asks for more torque than a joint has."""

    name = "torque-limit"
    status = "torque limit"

    def __init__(self, limit: ArrayLike | str) -> None:
        """Set the limit.

        Args:
            limit: Largest |τ|, N m: a number, one a joint, shape (nv,), or `"urdf"` for the robot's own.

        Raises:
            ShapeError: If it is neither a number nor a vector of numbers.
            ParameterError: If it is not above zero, or is another text.
        """
        self.limit = limit if isinstance(limit, str) and limit == FROM_FILE else joint_limit("limit", limit)

    def require_fits(self, arm: Arm) -> None:
        """Make sure that there is one limit a joint, or one for all.

        Raises:
            ShapeError: If there is not.
            ParameterError: If the robot's description has no limits of its own, and they are asked for.
        """
        self._limit_of(arm)

    def check(self, sample: Sample) -> str | None:
        """Return why the run ends, or None."""
        limit = self._limit_of(sample.arm)
        share = np.abs(sample.tau) / limit
        joint = int(share.argmax())
        if share[joint] <= 1.0:
            return None
        return f"{sample.tau[joint]:.6g} N m at joint {sample.arm.joint_names[joint]!r}, limit {limit[joint]:.6g} N m"

    def _limit_of(self, arm: Arm) -> Array:
        return joint_limit("limit", self.limit, arm.nv, arm.torque_limit)
