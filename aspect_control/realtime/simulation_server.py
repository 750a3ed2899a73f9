"""The simulated robot: MuJoCo in a process of its own, with a clock, friction, saturation and a watchdog.

The first line of input of the process is a `Setting` as JSON, its first line of output the port, and it ends when its
input does, which is when the process that started it ends.
"""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
from collections import deque
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any

import numpy as np

from ..redundancy import Array
from .interruptions import GarbageCollectorOff
from .packets import HELLO, LAST, Command, Mode, State, command_size, pack_state, unpack_command
from .samples import sleep_until

LOOPBACK = "127.0.0.1"
BRAKING_RATE = 20.0
"""Rate at which the brakes slow a joint down, 1/s."""

DIVERGED = 1e4
"""Joint speed that says that the simulation has gone wrong, rad/s: its process ends."""

MOST_LISTENERS = 8
"""Clients that get telemetry at the same time: the newest."""

MOST_PACKETS = 64
"""Packets that are looked at in a period, so that no flood of them stops the clock."""

LONGEST_LAG = 0.1
"""Time that the simulation catches up if it was held up, s; of a longer one its clock knows nothing."""


@dataclass(frozen=True)
class Setting:
    """What a simulation is started with.

    Attributes:
        mjcf: The arm.
        positions: Joint positions at the start, rad.
        dt: Period, s.
        torque_limit: Largest |τ| that the motors give, N m; None for a joint without limit.
        watchdog: Time without a command after which the arm brakes, s.
    """

    mjcf: str
    positions: list[float]
    dt: float
    torque_limit: list[float | None]
    watchdog: float

    def to_json(self) -> str:
        """Return the setting as one line of JSON."""
        return json.dumps(asdict(self))


class SimulatedArm:
    """The arm and its motors, brakes and watchdog; time is counted in periods."""

    def __init__(self, setting: Setting) -> None:
        """Put the arm where it starts, with its brakes on."""
        import mujoco

        self._step = mujoco.mj_step
        self._forward = mujoco.mj_forward
        self._multiply = mujoco.mj_mulM
        self.model = mujoco.MjModel.from_xml_string(setting.mjcf)
        self.data = mujoco.MjData(self.model)
        self.data.qpos = setting.positions
        self._limit = np.array([np.inf if limit is None else limit for limit in setting.torque_limit])
        self._dt, self._watchdog, self.periods = setting.dt, setting.watchdog, 0
        self.mode, self.session, self._sequence, self._commanded = Mode.WAITING, 0, 0, 0
        self._tau, self._held = np.zeros(self.model.nv), np.array(setting.positions)
        self._ended: set[int] = set()
        self._forward(self.model, self.data)
        # MuJoCo would write its warnings to a file; what they are about ends the process.
        mujoco.set_mju_user_warning(lambda message: None)

    def take(self, command: Command) -> bool:
        """Take over a command, and say whether it was one: a new one of the session in command, or of a new session.

        A session begins with its first command while no other is in command, and ends for good with its last or with
        the watchdog.
        """
        if self.mode is not Mode.DRIVEN and command.session not in self._ended:
            self.mode, self.session, self._sequence = Mode.DRIVEN, command.session, 0
        if command.session != self.session or self.mode is not Mode.DRIVEN or command.sequence <= self._sequence:
            return False
        self._tau, self._sequence, self._commanded = command.tau, command.sequence, self.periods
        if command.sequence == LAST:
            self._end(Mode.WAITING)
        return True

    def step(self) -> State:
        """Move on by one period and return the state at its end; an arm that has diverged ends the process."""
        data = self.data
        if self.mode is Mode.DRIVEN and (self.periods - self._commanded) * self._dt > self._watchdog:
            self._end(Mode.BRAKING)
        data.qfrc_applied = tau = np.clip(
            self._tau if self.mode is Mode.DRIVEN else self._brakes(), -self._limit, self._limit
        )
        self._step(self.model, data)
        # The bias forces of the new state, for the brakes.
        self._forward(self.model, data)
        self.periods += 1
        if not np.abs(data.qvel).max() <= DIVERGED:
            raise SystemExit(f"the simulated arm has diverged at t = {self.periods * self._dt:g} s")
        return State(
            self.session, self.periods, self.mode, self.periods * self._dt, data.qpos.copy(), data.qvel.copy(), tau
        )

    def _end(self, mode: Mode) -> None:
        """End the session in command."""
        self._ended.add(self.session)
        self.mode, self._held = mode, self.data.qpos.copy()

    def _brakes(self) -> Array:
        """Return the torque that carries the arm and slows it down; while it waits, that holds it where it was."""
        slowing, push = -BRAKING_RATE * self.data.qvel, np.empty(self.model.nv)
        if self.mode is Mode.WAITING:
            slowing = 2.0 * slowing + BRAKING_RATE**2 * (self._held - self.data.qpos)
        self._multiply(self.model, self.data, push, slowing)
        torque: Array = self.data.qfrc_bias + push
        return torque


def serve(arm: SimulatedArm, dt: float, server: socket.socket) -> None:
    """Run for ever, a step a period of dt, s, and answer those who ask."""
    joints = arm.model.nv
    listeners: deque[Any] = deque(maxlen=MOST_LISTENERS)
    driver, begin = None, perf_counter()
    while True:
        sleep_until(begin + arm.periods * dt)
        begin += max(0.0, perf_counter() - begin - arm.periods * dt - LONGEST_LAG)
        for _ in range(MOST_PACKETS):
            try:
                packet, client = server.recvfrom(command_size(joints) + 1)
            except BlockingIOError:
                break
            except ConnectionError:
                continue  # what was sent to a client that is gone
            command = unpack_command(packet, joints)
            if command is None:
                continue
            if command.sequence == HELLO:
                if client not in listeners:
                    listeners.append(client)
            elif arm.mode is not Mode.DRIVEN or client == driver:
                driver = client if arm.take(command) else driver
        packet = pack_state(arm.step())
        for client in listeners:
            try:
                server.sendto(packet, client)
            except OSError:
                continue


def main() -> None:
    """Serve what standard input says until it ends."""
    setting = Setting(**json.loads(sys.stdin.readline()))
    threading.Thread(target=lambda: (sys.stdin.read(), os._exit(0)), daemon=True).start()
    arm = SimulatedArm(setting)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server:
        server.bind((LOOPBACK, 0))
        server.setblocking(False)
        os.write(1, f"{server.getsockname()[1]}\n".encode())
        with GarbageCollectorOff():
            serve(arm, setting.dt, server)
