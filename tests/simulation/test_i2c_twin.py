"""The framing of i2c over a stream, and who answers on the bus."""

import errno
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.simulation.i2c import FramingError, Message, RequestReader, transfer

MESSAGES = st.one_of(
    st.builds(Message, st.integers(0, 0x7F), write=st.binary(max_size=40)),
    st.builds(Message, st.integers(0, 0x7F), read=st.integers(0, 8192)),
)
TRANSACTIONS = st.lists(MESSAGES, min_size=1, max_size=42).map(tuple)


class Memory:
    """A device that gives back what it was given, or does not answer."""

    def __init__(self, *, there=True):
        self.there, self.held = there, b""

    def write(self, data, now):
        self.held = data
        return self.there

    def read(self, length, now):
        return self.held.ljust(length, b"\0")[:length] if self.there else None


def encoded(messages):
    """Written from the framing's definition, apart from the code under test."""
    parts = [bytes((len(messages),))]
    for message in messages:
        if message.read is None:
            parts += [struct.pack("<BBH", message.address, 0, len(message.write)), message.write]
        else:
            parts.append(struct.pack("<BBH", message.address, 1, message.read))
    return b"".join(parts)


@given(st.lists(TRANSACTIONS, max_size=4), st.lists(st.integers(1, 30), min_size=1, max_size=8))
def test_requests_come_out_as_they_went_in_however_they_are_chopped(transactions, sizes):
    data, reader, out, turn = b"".join(map(encoded, transactions)), RequestReader(), [], 0
    while data:
        size = sizes[turn % len(sizes)]
        out += reader.feed(data[:size])
        data, turn = data[size:], turn + 1
    assert out == transactions


@given(st.binary(max_size=200))
def test_nonsense_is_an_error_of_framing_and_nothing_else(data):
    reader = RequestReader()
    try:
        for messages in reader.feed(data):
            assert 1 <= len(messages) <= 42
    except FramingError:
        pass


@pytest.mark.parametrize(
    "data", [b"\x00", b"\x2b", b"\x01\x80\x00\x00\x00", b"\x01\x68\x02\x00\x00", b"\x01\x68\x01\x01\x20"]
)
def test_what_no_bus_can_do_is_refused(data):
    with pytest.raises(FramingError):
        RequestReader().feed(data)


def test_reads_are_answered_in_order_after_a_zero():
    devices = {0x10: Memory(), 0x11: Memory()}
    messages = (
        Message(0x10, write=b"ab"),
        Message(0x11, write=b"cd"),
        Message(0x11, read=3),
        Message(0x10, read=1),
    )
    assert transfer(devices, messages, 0.0) == b"\0cd\0a"


@pytest.mark.parametrize("message", [Message(0x20, read=1), Message(0x11, read=1), Message(0x11, write=b"x")])
def test_what_nobody_acknowledges_is_a_remote_error(message):
    devices = {0x10: Memory(), 0x11: Memory(there=False)}
    assert transfer(devices, (Message(0x10, read=2), message), 0.0) == bytes((errno.EREMOTEIO,))
