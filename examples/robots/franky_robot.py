"""This adapter has not run on a robot: it is checked against the signatures of franky-control 2.0 only.

A Franka arm as a robot of `RealTimeLoop`, by `franky`, whose own thread talks to the arm at 1 kHz, limits the change of
the torque, and stops the arm when torques no longer come. The loop keeps its own time.

    arm = ac.Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
    robot = FrankyRobot(arm, "172.16.0.2")
    run = ac.RealTimeLoop(robot, law, dt=1e-3).follow(line)
"""

from __future__ import annotations

import franky
import numpy as np
from numpy.typing import NDArray

from aspect_control import Arm
from aspect_control.exceptions import RobotError

Array = NDArray[np.float64]

SIGNAL_TIMEOUT = 0.02
"""Time without a torque after which franky stops the arm, s."""


class FrankyRobot:
    """A Franka arm, read and written whenever the loop wants.

    Torque control begins with the first `write` and ends with `stop`; before and after, `read` only looks.
    """

    def __init__(self, arm: Arm, address: str) -> None:
        """Connect.

        Args:
            arm: The arm that the law is for, whose gravity torque is taken off what the law asks for.
            address: Address of the robot's control unit.
        """
        self._robot = franky.Robot(address)
        self._arm, self._q = arm, np.zeros(arm.nq)
        self._motion: franky.SimpleTorqueMotion | None = None

    def read(self) -> tuple[Array, Array]:
        """Return q and v, shapes (7,), rad and rad/s, as they are now."""
        if self._motion is not None and not self._robot.is_in_control:
            self._motion = None
            self._robot.join_motion()  # raises what ended it
            raise RobotError("franky has ended the motion")
        state = self._robot.state
        self._q = np.array(state.q)
        return self._q, np.array(state.dq)

    def write(self, tau: Array) -> None:
        """Send torques with gravity in them, shape (7,), N m; the robot adds the gravity that is taken off here."""
        without_gravity = tau - self._arm.state(self._q, np.zeros(self._arm.nv)).nle
        if self._motion is None:
            self._motion = franky.SimpleTorqueMotion(without_gravity, signal_timeout=SIGNAL_TIMEOUT)
            self._robot.move(self._motion, asynchronous=True)
        self._motion.set_torque(without_gravity)

    def stop(self) -> None:
        """End torque control: franky damps the arm until it rests."""
        if self._motion is not None:
            self._motion = None
            self._robot.move(franky.TorqueStopMotion(), asynchronous=True)
            self._robot.join_motion()
