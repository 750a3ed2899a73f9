"""The real counterpart that runs here: a simulated robot in a process of its own, and the client that drives it."""

from __future__ import annotations

import secrets
import socket
import subprocess
import sys
from importlib.util import find_spec
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import finite_vector, non_negative, positive, real_array
from ..exceptions import RobotError, ShapeError
from ..redundancy import Array
from .mujoco_chain import mjcf
from .packets import HELLO, LAST, Command, Mode, State, pack_command, state_size, unpack_state
from .simulation_server import LOOPBACK, Setting, main

PATIENCE = 1.0
"""Time after which a robot that says nothing is taken to be gone, s."""


class SimulatedRobot:
    """A client of a `SimulationProcess`, over UDP on the loopback interface: a robot with a clock of its own.

    Until the first `write` it only reads, so that several may watch one robot; then it is in command until `stop`.

    Attributes:
        state: The newest state; None before the first `read`.
    """

    def __init__(self, arm: Arm, port: int) -> None:
        """Ask for telemetry.

        Args:
            arm: The arm that is simulated.
            port: Port of the simulation.
        """
        self.state: State | None = None
        self._arm, self._size = arm, state_size(arm.nv)
        self._new_session()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        # A connected socket gets nothing from anybody else.
        self._socket.connect((LOOPBACK, port))
        self._send(HELLO, np.zeros(arm.nv))

    @property
    def time(self) -> float:
        """Time of the newest state on the robot's clock, s; 0 before the first."""
        return 0.0 if self.state is None else self.state.time

    @property
    def mode(self) -> Mode:
        """What moved the arm at the newest state."""
        return Mode.WAITING if self.state is None else self.state.mode

    def read(self) -> tuple[Array, Array]:
        """Wait for a new state and return q, shape (nq,), rad, and v, shape (nv,), rad/s, of the newest.

        Raises:
            RobotError: If none comes for `PATIENCE`, or, after a `write`, if another client drives the robot or its
                watchdog has ended the session.
        """
        found = self._newest()
        self.state = found
        ours, driving = found.session == self._session, self._sequence > 0
        if driving and ours and found.mode is Mode.BRAKING:
            raise RobotError("the simulated robot takes no more commands: its watchdog brakes it")
        if driving and not ours and found.mode is Mode.DRIVEN:
            raise RobotError("the simulated robot takes no commands: another client drives it")
        return self._arm.configuration(found.positions), found.v

    def write(self, tau: Array) -> None:
        """Send torques, shape (nv,), N m.

        Raises:
            ShapeError: If there is not one torque a joint.
            NonFiniteError: If one is not finite.
            RobotError: If the robot is gone.
        """
        self._sequence += 1
        self._send(self._sequence, finite_vector("tau", tau, self._arm.nv))

    def stop(self) -> None:
        """Say that no more torques will come: the brakes hold the arm until the next `write`.

        Raises:
            RobotError: If the robot is gone.
        """
        if self._sequence:
            self._send(LAST, np.zeros(self._arm.nv))
            self._new_session()

    def close(self) -> None:
        """Let go of the socket."""
        self._socket.close()

    def __enter__(self) -> SimulatedRobot:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _new_session(self) -> None:
        self._session, self._sequence = secrets.randbelow(2**32 - 1) + 1, 0

    def _send(self, sequence: int, tau: Array) -> None:
        try:
            self._socket.send(pack_command(Command(self._session, sequence, tau)))
        except OSError as error:
            raise RobotError(f"the simulated robot is gone: {error.strerror or error}") from error

    def _newest(self) -> State:
        """Return the newest state, waiting for one that is newer than the last."""
        newest, joints = None, self._arm.nv
        before = 0 if self.state is None else self.state.sequence
        while True:
            self._socket.settimeout(PATIENCE if newest is None else 0.0)
            try:
                state = unpack_state(self._socket.recv(self._size + 1), joints)
            except BlockingIOError:
                if newest is not None:
                    return newest
            except TimeoutError:
                raise RobotError(f"the simulated robot has said nothing for {PATIENCE:g} s") from None
            except OSError as error:
                raise RobotError(f"the simulated robot is gone: {error.strerror or error}") from error
            else:
                if state is not None and state.sequence > before:
                    newest, before = state, state.sequence


class SimulationProcess:
    """A MuJoCo simulation of an arm in a process of its own, as a context: it lives as long as its block.

    It steps at its own pace and holds the last torque until the next, within the torque limits of the robot's
    description. Until the first command comes, its brakes hold the arm. When commands stop for longer than `watchdog`,
    it carries the arm's weight, slows every joint down, and the client in command has lost it. It listens on
    the loopback interface only and ends with the process that started it, however that ends. The simulated arm has no
    joint ends, no shapes and no contacts.

    Attributes:
        arm: The arm.
        port: Port on which it listens, once it is started.
    """

    def __init__(
        self,
        arm: Arm,
        q0: ArrayLike,
        *,
        dt: float = 1e-3,
        friction: ArrayLike = 0.5,
        damping: ArrayLike = 0.5,
        watchdog: float = 0.02,
    ) -> None:
        """Set the arm, its imperfections and its start.

        Args:
            arm: The arm.
            q0: Joint configuration at the start, shape (nq,), rad.
            dt: Period of its clock, s.
            friction: Dry friction of the joints, a number or one a joint, N m.
            damping: Viscous friction of the joints, a number or one a joint, N m s/rad.
            watchdog: Time without a command after which it brakes, s.

        Raises:
            ShapeError: If q0 or a friction has the wrong shape.
            NonFiniteError: If q0 is not finite.
            ParameterError: If a friction is negative, or a time not above zero.
        """
        self.arm, self.port = arm, 0
        limits = [float(limit) if np.isfinite(limit) else None for limit in arm.torque_limit]
        self._setting = Setting(
            mjcf=mjcf(
                arm,
                dt=positive("dt", dt, "s"),
                friction=_each_joint("friction", friction, arm.nv),
                damping=_each_joint("damping", damping, arm.nv),
            ),
            positions=arm.positions(finite_vector("q0", q0, arm.nq)).tolist(),
            dt=dt,
            torque_limit=limits,
            watchdog=positive("watchdog", watchdog, "s"),
        )

    def connect(self) -> SimulatedRobot:
        """Return a new client."""
        return SimulatedRobot(self.arm, self.port)

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def __enter__(self) -> SimulationProcess:
        """Start the process.

        Raises:
            ImportError: If MuJoCo is not installed.
            RobotError: If the process does not start.
        """
        if find_spec("mujoco") is None:
            raise ImportError("the simulated robot needs MuJoCo: pip install 'aspect-control[mujoco]'")
        command = [sys.executable, "-c", f"from {main.__module__} import main; main()"]
        self._process = subprocess.Popen(  # noqa: S603
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        assert self._process.stdin is not None and self._process.stdout is not None  # noqa: PT018, S101
        try:
            self._process.stdin.write(self._setting.to_json() + "\n")
            self._process.stdin.flush()
            port = self._process.stdout.readline().strip()
        except OSError:
            port = ""
        if not port.isdecimal():
            self.__exit__(None, None, None)
            raise RobotError("the simulation did not start; what it says is above")
        self.port = int(port)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


def _each_joint(name: str, value: ArrayLike, size: int) -> Array:
    given = np.atleast_1d(real_array(name, value, "a number or one a joint"))
    if given.ndim != 1 or len(given) not in (1, size):
        raise ShapeError(f"{name} must be a number or one for each of {size} joints, got shape {given.shape}")
    for each in given.tolist():
        non_negative(name, each)
    return np.broadcast_to(given, (size,))
