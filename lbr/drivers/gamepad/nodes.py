"""The gamepads among the kernel's input devices, and their nodes: from /sys/class/input, without opening any."""

import re
import struct
from pathlib import Path

from msgspec import Struct

SYS = Path("/sys/class/input")
ANYWHERE = "input:"
"""The prefix of an address that names a gamepad by its radio address or its name, not by its node."""
_WORD_BITS = 8 * struct.calcsize("l")
_JOYSTICK, _GAMEPAD = 0x120, 0x130
_ABS_X, _ABS_Y = 0, 1


class Node(Struct, frozen=True, kw_only=True):
    """A gamepad: the name of its node, its own name, and its radio address, if it has one."""

    node: str
    name: str
    radio: str = ""

    @property
    def address(self) -> str:
        """Return the address for a device row."""
        return ANYWHERE + (self.radio or self.name)


def gamepads(sys: Path = SYS) -> list[Node]:
    """Return all present gamepads: devices with a stick, and the buttons of a gamepad or a joystick."""
    return [
        Node(node=one.name, name=_read(one / "device/name"), radio=_read(one / "device/uniq"))
        for one in sorted(sys.glob("event*"), key=lambda one: int(re.sub(r"\D", "", one.name) or 0))
        if _is_gamepad(one / "device/capabilities")
    ]


def path_of(address: str, sys: Path = SYS) -> str:
    """Return the node of an address; empty if it is not present."""
    if not address.startswith(ANYWHERE):
        return address
    wanted = address.removeprefix(ANYWHERE).strip().lower()
    nodes = (one.node for one in gamepads(sys) if wanted and wanted in {one.radio.lower(), one.name.lower()})
    return next((f"/dev/input/{node}" for node in nodes), "")


def _is_gamepad(capabilities: Path) -> bool:
    keys, axes = _bits(capabilities / "key"), _bits(capabilities / "abs")
    buttons = any(keys >> code & 0x1 for code in (_JOYSTICK, _GAMEPAD))
    return buttons and bool(axes >> _ABS_X & axes >> _ABS_Y & 1)


def _bits(file: Path) -> int:
    """Return a bitmap of the kernel: hexadecimal words of a `long`, the highest first."""
    bits = 0
    for word in _read(file).split():
        try:
            bits = bits << _WORD_BITS | int(word, 16)
        except ValueError:
            return 0
    return bits


def _read(file: Path) -> str:
    try:
        return file.read_text(errors="replace").strip()
    except OSError:
        return ""
