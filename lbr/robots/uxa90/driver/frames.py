"""Frames of the main board (UIC): encoding, and parsing out of any bytes. No I/O.

Eight bytes of preamble, type, platform, size (four bytes, big-endian), contents, and the XOR of the contents.
"""

from collections.abc import Collection
from typing import NamedTuple

from lbr.robots.uxa90.driver.packets import xor

PREAMBLE = bytes.fromhex("FFFFAA55AA5537BA")
OVERHEAD_BYTES = 15
MOST_CONTENTS = 64
"""The longest accepted contents; the longest known has 31."""
CONTROL, REMOTE, FIRMWARE, SERIAL, ZEROS, IMU, LAST_BUTTON = 0x10, 0x14, 0x12, 0x0C, 0x0B, 0x1A, 0x19


class Frame(NamedTuple):
    """A frame of the main board, in either direction."""

    type: int
    platform: int
    contents: bytes


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame."""
    size = len(frame.contents).to_bytes(4, "big")
    return PREAMBLE + bytes((frame.type, frame.platform)) + size + frame.contents + bytes((xor(frame.contents),))


TAKE_CONTROL = encode(Frame(CONTROL, 0, b"\x01"))
QUESTIONS = {
    "firmware": (FIRMWARE, 2),
    "serial": (SERIAL, 13),
    "zeros": (ZEROS, 31),
    "imu": (IMU, 6),
    "last_button": (LAST_BUTTON, 2),
}
"""The questions to the main board: the frame's type, and the number of bytes in its answer."""


def remote(button: int) -> bytes:
    """Return the frame of a remote control's button: it plays the motion of that number, and leaves PC control."""
    if not 1 <= button <= 42:
        raise ValueError(f"button {button} is outside 1..42")
    return encode(Frame(REMOTE, 0, bytes((button,))))


def ask(what: str) -> bytes:
    """Return the question for an entry of `QUESTIONS`."""
    return encode(Frame(QUESTIONS[what][0], 1, b"\x01"))


class FrameParser:
    """Takes frames out of a stream and returns all other bytes unchanged; it holds a bounded number of bytes."""

    def __init__(self, unsummed: Collection[int] = ()) -> None:
        """`unsummed` are the types without a reliable sum."""
        self._unsummed = frozenset(unsummed)
        self.corrupt = 0
        self._held = bytearray()

    @property
    def held(self) -> int:
        """Return the number of bytes that may still become a frame."""
        return len(self._held)

    def feed(self, data: bytes) -> tuple[list[Frame], bytes]:
        """Return the complete frames, and the bytes that belong to none."""
        self._held += data
        held = self._held
        frames: list[Frame] = []
        plain = bytearray()
        while held:
            start = held.find(0xFF)
            if start != 0:
                end = len(held) if start < 0 else start
                plain += held[:end]
                del held[:end]
                continue
            need = self._need()
            if need == 0:
                plain += held[:1]
                del held[:1]
            elif len(held) < need:
                break
            else:
                frames.append(Frame(held[8], held[9], bytes(held[14 : need - 1])))
                del held[:need]
        return frames, bytes(plain)

    def flush(self) -> bytes:
        """Return the held bytes: no more input comes that would complete them."""
        left = bytes(self._held)
        self._held.clear()
        return left

    def _need(self) -> int:
        """Return the size of the frame that begins here, larger than the held bytes while it is unknown; 0 without a
        frame."""
        held = self._held
        known = min(len(held), len(PREAMBLE))
        if held[:known] != PREAMBLE[:known]:
            return 0
        if len(held) < OVERHEAD_BYTES - 1:
            return OVERHEAD_BYTES
        size = int.from_bytes(held[10:14], "big")
        if size > MOST_CONTENTS:
            self.corrupt += 1
            return 0
        need = OVERHEAD_BYTES + size
        unsure = len(held) >= need and held[8] not in self._unsummed
        if unsure and xor(held[14 : need - 1]) != held[need - 1]:
            self.corrupt += 1
            return 0
        return need
