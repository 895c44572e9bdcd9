"""What may be on the serial line of a UXA-90, told from its bytes alone; for the trace of the emulated main board."""

from pathlib import Path
from typing import NamedTuple

PREAMBLE = bytes.fromhex("ffffaa55aa5537ba")
FRAMES = {0x10, 0x14, 0x12, 0x0C, 0x0B, 0x1A, 0x19}
"""PC control, button, and what only asks."""
BUTTONS = {*range(1, 15), 21}
IDS = range(25)
EVERY_ID = 31
READS = {0x0A, 0x0E, 0x10, 0x12, 0x16, 0x65, 0xAD, 0xC9, 0xAF, 0xB6}
MOTION = 0xE1


class Packet(NamedTuple):
    """Something whole on the line: what kind, and its bytes."""

    kind: str
    data: bytes

    @property
    def servo(self) -> int:
        """Which servo a move is for."""
        return self.data[1] & 0x1F


class Chunk(NamedTuple):
    """What the main board read at once."""

    at: float
    data: bytes


def chunks(trace: Path) -> list[Chunk]:
    """Return what was read, in order."""
    lines = [line.split() for line in trace.read_text().splitlines()] if trace.exists() else []
    return [Chunk(int(line[0]) / 1e9, bytes.fromhex(line[2])) for line in lines if line[1:2] == ["read"] and line[2:]]


def packets(data: bytes) -> tuple[list[Packet], list[str]]:
    """Return what bytes consist of, and what of it is illegal."""
    found: list[Packet] = []
    wrong: list[str] = []
    at = 0
    while at < len(data):
        packet, why = _frame(data[at:]) if data[at:].startswith(PREAMBLE) else _packet(data[at:])
        if why:
            wrong.append(f"{why} at byte {at}: {data[at : at + 24].hex(' ')}")
            after = data.find(b"\xff", at + 1)
            at = after if after > 0 else len(data)
        else:
            found.append(packet)
            at += len(packet.data)
    return found, wrong


def _frame(data: bytes) -> tuple[Packet, str]:
    kind, size = data[8] if len(data) > 8 else -1, int.from_bytes(data[10:14], "big")
    whole = data[: 15 + size]
    contents = whole[14:-1]
    total = 0
    for byte in contents:
        total ^= byte
    if kind not in FRAMES:
        return Packet("", b""), f"frame of type {kind:#x}"
    if len(whole) < 15 + size or size > 40:
        return Packet("", b""), "frame that is cut off"
    if whole[-1] != total:
        return Packet("", b""), "frame with a wrong sum"
    if kind == 0x14 and (size != 1 or contents[0] not in BUTTONS):
        return Packet("", b""), f"button {contents.hex()}"
    return Packet("button" if kind == 0x14 else "frame", whole), ""


def _packet(data: bytes) -> tuple[Packet, str]:
    """Return a servo packet; sums are over all between the first byte and the last, seven bits."""
    if data[0] != 0xFF or len(data) < 4:
        return Packet("", b""), "no packet"
    mode, servo, value = data[1] >> 5, data[1] & 0x1F, data[2]
    length = 4 if mode < 7 else 6
    whole, total = data[:length], 0
    for byte in whole[1:-1]:
        total ^= byte
    if len(whole) < length or whole[-1] != total & 0x7F:
        return Packet("", b""), "packet with a wrong sum"
    if mode < 5:
        legal = servo in IDS and 1 <= value <= 254
        return Packet("move", whole), "" if legal else f"move of servo {servo} to {value}"
    if mode == 5:
        return Packet("read", whole), "" if servo in IDS else f"read of servo {servo}"
    if mode == 6:
        legal = (servo in IDS and value == 0x10) or (servo == EVERY_ID and value == 0x20)
        return Packet("let go", whole), "" if legal else f"mode 6 with {value:#x} for servo {servo}"
    legal = value in READS or (value == MOTION and whole[4] in BUTTONS)
    return Packet("other", whole), "" if legal else f"configuration {whole.hex(' ')}"
