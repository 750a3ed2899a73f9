"""This adapter has not run on a robot: it is checked against the signatures of pylibfranka 0.21 only.

A Franka arm as a robot of `RealTimeLoop`, by `pylibfranka`, the Python bindings of libfranka. The arm sets the pace:
`readOnce` waits for its next sample, at 1 kHz.

    arm = ac.Arm.from_example("panda", frame="panda_hand_tcp", task="xyz")
    robot = PylibfrankaRobot(arm, "172.16.0.2")
    run = ac.RealTimeLoop(robot, law, dt=1e-3).follow(line)

The robot compensates its own gravity and refuses torques that change by more than 1000 N m/s.
"""

from __future__ import annotations

import numpy as np
import pylibfranka
from numpy.typing import NDArray

from aspect_control import Arm

Array = NDArray[np.float64]


class PylibfrankaRobot:
    """A Franka arm, read and written once a millisecond.

    Torque control begins with the first `write` and ends with `stop`; before and after, `read` only looks.

    Attributes:
        time: Time of the newest sample on the robot's clock, s.
    """

    def __init__(self, arm: Arm, address: str, *, enforce_realtime: bool = True) -> None:
        """Connect.

        Args:
            arm: The arm that the law is for, whose gravity torque is taken off what the law asks for.
            address: Address of the robot's control unit.
            enforce_realtime: Whether libfranka insists on a real-time kernel.
        """
        config = pylibfranka.RealtimeConfig.kEnforce if enforce_realtime else pylibfranka.RealtimeConfig.kIgnore
        self._robot = pylibfranka.Robot(address, config)
        self._arm = arm
        self._control: pylibfranka.ActiveControlBase | None = None
        self._q, self._tau, self.time = np.zeros(arm.nq), np.zeros(arm.nv), 0.0

    def read(self) -> tuple[Array, Array]:
        """Return q and v, shapes (7,), rad and rad/s, of the next sample."""
        state = self._robot.read_once() if self._control is None else self._control.readOnce()[0]
        self.time, self._q = state.time.to_sec(), np.array(state.q)
        return self._q, np.array(state.dq)

    def write(self, tau: Array) -> None:
        """Send torques with gravity in them, shape (7,), N m; the robot adds the gravity that is taken off here."""
        if self._control is None:
            self._control = self._robot.start_torque_control()
            self._control.readOnce()
        self._tau = tau - self._arm.state(self._q, np.zeros(self._arm.nv)).nle
        self._control.writeOnce(pylibfranka.Torques(self._tau.tolist()))

    def stop(self) -> None:
        """End torque control."""
        if self._control is not None:
            control, self._control = self._control, None
            control.readOnce()
            last = pylibfranka.Torques(self._tau.tolist())
            last.motion_finished = True
            control.writeOnce(last)
