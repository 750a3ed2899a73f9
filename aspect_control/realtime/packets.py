"""What the simulated robot and its client say to each other: packets of fixed size, checked before they are believed.

Little-endian, one packet a datagram, nothing but numbers:

- A command: magic `ACTQ`, session, sequence number, number of joints, torques. The sequence numbers `HELLO` and `LAST`
  carry no torque: the one asks for telemetry, the other ends the session.
- A state: magic `ACST`, the session in command, sequence number, number of joints, mode, time, positions, velocities
  and the torques that act.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from ..checks import is_finite
from ..redundancy import Array

_COMMAND, _STATE = b"ACTQ", b"ACST"
_COMMAND_HEAD, _STATE_HEAD = struct.Struct("<4sIII"), struct.Struct("<4sIIIId")

HELLO, LAST = 0, 2**32 - 1
"""Sequence numbers of the packets that ask for telemetry, and that end a session."""


class Mode(IntEnum):
    """What moves the simulated arm."""

    WAITING = 0
    """Nothing: its brakes hold it until the first command of a session comes."""
    DRIVEN = 1
    """The commands."""
    BRAKING = 2
    """Its brakes, because commands stopped; a new session is needed."""


_MODES = frozenset(int(mode) for mode in Mode)


class Command(NamedTuple):
    """Torques from a client.

    Attributes:
        session: The client's own number.
        sequence: Counts the commands of the session from 1; or `HELLO`, or `LAST`.
        tau: Torques, shape (n,), N m.
    """

    session: int
    sequence: int
    tau: Array


class State(NamedTuple):
    """What the robot says of itself, once a period.

    Attributes:
        session: The session whose commands move it; 0 for none.
        sequence: Counts the states.
        mode: What moves it.
        time: Its own time, s.
        positions: Joint positions, shape (n,), rad.
        v: Joint velocities, shape (n,), rad/s.
        tau: Torques that act, shape (n,), N m.
    """

    session: int
    sequence: int
    mode: Mode
    time: float
    positions: Array
    v: Array
    tau: Array


def command_size(joints: int) -> int:
    """Return the size of a command, in bytes."""
    return _COMMAND_HEAD.size + 8 * joints


def state_size(joints: int) -> int:
    """Return the size of a state, in bytes."""
    return _STATE_HEAD.size + 24 * joints


def pack_command(command: Command) -> bytes:
    """Return a command as a packet."""
    tau = np.asarray(command.tau, dtype="<f8")
    return _COMMAND_HEAD.pack(_COMMAND, command.session, command.sequence, len(tau)) + tau.tobytes()


def unpack_command(packet: bytes, joints: int) -> Command | None:
    """Return the command of a packet; None if it is none for that many joints, or not finite."""
    if len(packet) != command_size(joints):
        return None
    magic, session, sequence, count = _COMMAND_HEAD.unpack_from(packet)
    tau = np.frombuffer(packet, dtype="<f8", offset=_COMMAND_HEAD.size)
    if magic != _COMMAND or count != joints or session == 0 or not is_finite(tau):
        return None
    return Command(session, sequence, tau)


def pack_state(state: State) -> bytes:
    """Return a state as a packet."""
    session, sequence, mode, time, *vectors = state
    head = _STATE_HEAD.pack(_STATE, session, sequence, len(state.v), mode, time)
    return head + np.concatenate(vectors, dtype="<f8").tobytes()


def unpack_state(packet: bytes, joints: int) -> State | None:
    """Return the state of a packet; None if it is none for that many joints, or not finite."""
    if len(packet) != state_size(joints):
        return None
    magic, session, sequence, count, mode, time = _STATE_HEAD.unpack_from(packet)
    vectors = np.frombuffer(packet, dtype="<f8", offset=_STATE_HEAD.size)
    if magic != _STATE or count != joints or mode not in _MODES or not (is_finite(vectors) and time >= 0.0):
        return None
    return State(session, sequence, Mode(mode), time, *vectors.reshape(3, joints))
