"""The pseudoinverse law with damped self-motion."""

from __future__ import annotations

from ..redundancy import Array, damped_torque
from ..redundancy.compiled import NUMBER
from ..redundancy.feedback import task_space_law
from .damped import DampedController


@task_space_law(NUMBER)
def _torque(M: Array, nle: Array, J: Array, b: Array, v: Array, damping: float) -> Array:
    return damped_torque(M, nle, J, b, v, damping)


class DampedNullSpace(DampedController):
    """τ = τ̃ − D M θ̇_H: Eq. (7), and the self-motion of Eq. (15) decays at the rate D.

    Null-space damping as in P. Hsu, J. Hauser and S. Sastry, "Dynamic control of redundant manipulators", Journal of
    Robotic Systems 6 (1989), with the desired self-motion zero and without the derivative of the projector.

    Attributes:
        damping: D, 1/s.
    """

    name = "damped-null-space"
    compiled_text = (_torque,)
