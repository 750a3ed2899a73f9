import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aspect_control.realtime.packets import (
    Command,
    Mode,
    State,
    command_size,
    pack_command,
    pack_state,
    state_size,
    unpack_command,
    unpack_state,
)

numbers = st.floats(-1e50, 1e50)
counts = st.integers(1, 2**32 - 1)
joints = 7
vector = arrays(np.float64, joints, elements=numbers)


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


@given(st.builds(Command, counts, counts, vector))
def test_a_command_arrives_as_it_was_sent(command):
    packet = pack_command(command)
    assert len(packet) == command_size(joints)
    assert same(unpack_command(packet, joints), command)
    assert unpack_command(packet, joints - 1) is None
    assert unpack_state(packet, joints) is None


@given(st.builds(State, counts, counts, st.sampled_from(Mode), st.floats(0.0, 1e9), vector, vector, vector))
def test_a_state_arrives_as_it_was_sent(state):
    packet = pack_state(state)
    assert len(packet) == state_size(joints)
    assert same(unpack_state(packet, joints), state)
    assert unpack_command(packet, joints) is None


@given(st.binary(max_size=300))
def test_anything_else_is_no_packet(packet):
    assert unpack_command(packet, joints) is None
    assert unpack_state(packet, joints) is None


@pytest.mark.parametrize(
    "packet",
    [
        struct.pack("<4sIII7d", b"ACTQ", 1, 1, 6, *range(7)),
        struct.pack("<4sIII7d", b"ACTQ", 0, 1, 7, *range(7)),
        struct.pack("<4sIII7d", b"ACTX", 1, 1, 7, *range(7)),
        struct.pack("<4sIII7d", b"ACTQ", 1, 1, 7, *range(6), float("nan")),
        struct.pack("<4sIII7d", b"ACTQ", 1, 1, 7, *range(6), float("inf")),
        struct.pack("<4sIII8d", b"ACTQ", 1, 1, 7, *range(8)),
    ],
    ids=["joints", "session", "magic", "nan", "infinity", "length"],
)
def test_a_command_with_one_thing_wrong_is_none(packet):
    assert unpack_command(packet, joints) is None


@pytest.mark.parametrize(("mode", "time"), [(3, 1.0), (1, -1.0), (1, float("nan"))])
def test_a_state_with_one_thing_wrong_is_none(mode, time):
    packet = struct.pack("<4sIIIId21d", b"ACST", 1, 1, 7, mode, time, *range(21))
    assert unpack_state(packet, joints) is None
