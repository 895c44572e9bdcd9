"""Dynamixel protocol 1.0 from the servo's side: instruction packets in, status packets out."""

from enum import IntEnum, IntFlag
from typing import NamedTuple

BROADCAST = 0xFE
RECEIVE_BYTES = 143
"""The size of an AX servo's receive buffer."""

_HEADER = b"\xff\xff"
_GAP_S = 0.1
"""A longer pause within a packet makes a servo drop it."""


class Code(IntEnum):
    """The instructions there are; 0x84 is the USB2AX's own."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    SYNC_WRITE = 0x83
    SYNC_READ = 0x84


class Fault(IntFlag):
    """The bits of a status packet's error byte, and of the masks for alarm LED and shutdown."""

    NONE = 0
    VOLTAGE = 0x01
    ANGLE = 0x02
    HEAT = 0x04
    RANGE = 0x08
    CHECKSUM = 0x10
    OVERLOAD = 0x20
    INSTRUCTION = 0x40


class Instruction(NamedTuple):
    """A packet from the host; `end` counts the bytes of its last piece up to its end. Not sound: its sum is wrong."""

    id: int
    code: int
    parameters: bytes = b""
    sound: bool = True
    end: int = 0

    @property
    def size(self) -> int:
        """Return how many bytes it has on the line."""
        return len(self.parameters) + 6


class InstructionReader:
    """Finds packets in pieces of any size, as a servo does: searches for a header, and trusts the length that
    follows."""

    def __init__(self) -> None:
        self._held = bytearray()
        self._last = 0.0

    def feed(self, data: bytes, now: float) -> list[Instruction]:
        """Return the packets that these bytes complete."""
        if now - self._last > _GAP_S:
            self._held.clear()
        self._last = now
        before = len(self._held)
        self._held += data
        instructions, at = [], 0
        while (begin := self._held.find(_HEADER, at)) >= 0:
            packet = self._packet(begin)
            if packet is None:
                at = begin
                break
            at = begin + 1 if packet.size == 0 else packet.end
            if packet.size:
                instructions.append(packet.instruction(before))
        else:
            at = max(at, len(self._held) - 1)  # the last byte may be half a header
        del self._held[:at]
        return instructions

    def _packet(self, begin: int) -> "_Found | None":
        held = self._held
        if len(held) < begin + 4:
            return None
        number, length = held[begin + 2], held[begin + 3]
        if number > BROADCAST or length < 2:
            return _Found(0, 0, b"")
        end = begin + 4 + length
        return _Found(length + 4, end, bytes(held[begin:end])) if len(held) >= end else None


class _Found(NamedTuple):
    size: int
    end: int
    data: bytes

    def instruction(self, before: int) -> Instruction:
        data = self.data
        return Instruction(
            id=data[2],
            code=data[4],
            parameters=data[5:-1],
            sound=checksum(data[2:-1]) == data[-1],
            end=self.end - before,
        )


def status(number: int, error: int, data: bytes = b"") -> bytes:
    """Return a status packet."""
    body = bytes((number, len(data) + 2, error)) + data
    return _HEADER + body + bytes((checksum(body),))


def sound(packet: bytes) -> bool:
    """Return whether a status packet is complete with a right sum."""
    return len(packet) >= 6 and packet[3] + 4 == len(packet) and checksum(packet[2:-1]) == packet[-1]


def checksum(body: bytes) -> int:
    """Return the sum of a packet without its header."""
    return ~sum(body) & 0xFF
