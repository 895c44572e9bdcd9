"""The bytes on a main board's line, decoded: its own frames, and packets for the servos behind it.

A servo packet is `FF b1 ... sum`; FF in the middle of one begins another. Frames and servo packets may follow each
other in any order; a pause within one makes the main board discard it.
"""

from functools import reduce
from operator import xor
from typing import NamedTuple

PREAMBLE = bytes.fromhex("FFFFAA55AA5537BA")
GAP_S = 0.1
"""The longest pause within a packet."""

MOST_CONTENTS = 64
EXTENDED = frozenset({0xC8, 0xAD, 0xAE, 0xAF, 0xB5, 0xB6})
"""Commands of configuration packets to id 0 that name their servo by a byte of its own."""

_HEADER = len(PREAMBLE) + 6
_ALL = 31
_CONFIGURE = 7


class Frame(NamedTuple):
    """A frame for the main board; `end` is its end in the bytes of the newest piece. `sound`: its sum is right."""

    type: int
    platform: int
    contents: bytes
    sound: bool
    end: int


class Packet(NamedTuple):
    """A packet for servos, as `Frame`; `data` is everything between FF and the sum."""

    data: bytes
    sound: bool
    end: int

    @property
    def mode(self) -> int:
        """The upper three bits: a torque level, or the type of another packet."""
        return self.data[0] >> 5

    @property
    def id(self) -> int:
        """The lower five bits."""
        return self.data[0] & 0x1F


class Reader:
    """Finds frames and packets in bytes of any pieces; bytes that belong to neither are skipped."""

    def __init__(self) -> None:
        self._buffer = b""
        self._received_at = 0.0

    def forget(self) -> None:
        """Discard the unfinished bytes."""
        self._buffer = b""

    def feed(self, data: bytes, now: float) -> list[Frame | Packet]:
        """Add bytes; return the complete packets."""
        if now - self._received_at > GAP_S:
            self.forget()
        self._received_at = now
        before, self._buffer = len(self._buffer), self._buffer + data
        packets: list[Frame | Packet] = []
        at = self._buffer.find(0xFF)
        while at >= 0:
            size = _size(self._buffer[at : at + _HEADER + MOST_CONTENTS + 1])
            if size is None:
                break
            if size:
                packets.append(_parsed(self._buffer[at : at + size], at + size - before))
            at = self._buffer.find(0xFF, at + max(1, size))
        self._buffer = self._buffer[at:] if at >= 0 else b""
        return packets


def framed(kind: int, platform: int, contents: bytes) -> bytes:
    """Return a frame as the main board sends it."""
    head = bytes((kind, platform)) + len(contents).to_bytes(4)
    return PREAMBLE + head + contents + bytes((reduce(xor, contents, 0),))


def _size(view: bytes) -> int | None:
    """Return the size of the packet that begins here; 0 without one; None while it is unknown or incomplete."""
    if len(view) < 2:
        return None
    if view[1] == 0xFF:
        return _frame_size(view)
    needed = _packet_size(view)
    if 0xFF in view[1:needed]:
        return 0
    return needed if needed is not None and len(view) >= needed else None


def _frame_size(view: bytes) -> int | None:
    if not view.startswith(PREAMBLE[: len(view)]):
        return 0
    if len(view) < _HEADER:
        return None
    contents = int.from_bytes(view[_HEADER - 4 : _HEADER])
    if contents > MOST_CONTENTS:
        return 0
    return _HEADER + contents + 1 if len(view) > _HEADER + contents else None


def _packet_size(view: bytes) -> int | None:
    mode, number = view[1] >> 5, view[1] & 0x1F
    if mode == _CONFIGURE:
        if len(view) < 3:
            return None
        return 7 if number == 0 and view[2] in EXTENDED else 6
    if mode < 5 and number == _ALL:
        return 4 + view[2] if len(view) > 2 else None
    return 4


def _parsed(data: bytes, end: int) -> Frame | Packet:
    if data[1] == 0xFF:
        contents = data[_HEADER:-1]
        kind, platform = data[len(PREAMBLE) : len(PREAMBLE) + 2]
        return Frame(kind, platform, contents, reduce(xor, contents, 0) == data[-1], end)
    inner = data[1:-1]
    together = inner[:1] == b"" or ((inner[0] >> 5) < 5 and inner[0] & 0x1F == _ALL)
    summed = inner[2:] if together else inner
    return Packet(inner, reduce(xor, summed, 0) & 0x7F == data[-1], end)
