"""Which of the kernel's input devices are gamepads, and where: by /sys/class/input, without opening any."""

import re
import struct
from pathlib import Path

from msgspec import Struct

SYS = Path("/sys/class/input")
ANYWHERE = "input:"
"""The beginning of an address that finds a gamepad by its radio address, or else its name, not by its place."""
_WORD_BITS = 8 * struct.calcsize("l")
_JOYSTICK, _GAMEPAD = 0x120, 0x130
_ABS_X, _ABS_Y = 0, 1


class Node(Struct, frozen=True, kw_only=True):
    """A gamepad: the name of its node, its own name, and the address of its radio, if it tells one."""

    node: str
    name: str
    radio: str = ""

    @property
    def address(self) -> str:
        """Return by what a device row finds it again."""
        return ANYWHERE + (self.radio or self.name)


def gamepads(sys: Path = SYS) -> list[Node]:
    """Return all gamepads that there are now: what has a stick, and the buttons of a gamepad or a joystick."""
    return [
        Node(node=one.name, name=_read(one / "device/name"), radio=_read(one / "device/uniq"))
        for one in sorted(sys.glob("event*"), key=lambda one: int(re.sub(r"\D", "", one.name) or 0))
        if _is_gamepad(one / "device/capabilities")
    ]


def path_of(address: str, sys: Path = SYS) -> str:
    """Return the node of an address; empty if what it names is not there."""
    if not address.startswith(ANYWHERE):
        return address
    wanted = address.removeprefix(ANYWHERE).strip().lower()
    found = (one.node for one in gamepads(sys) if wanted and wanted in {one.radio.lower(), one.name.lower()})
    return next((f"/dev/input/{node}" for node in found), "")


def _is_gamepad(capabilities: Path) -> bool:
    keys, axes = _bits(capabilities / "key"), _bits(capabilities / "abs")
    buttons = any(keys >> code & 0x1 for code in (_JOYSTICK, _GAMEPAD))
    return buttons and bool(axes >> _ABS_X & axes >> _ABS_Y & 1)


def _bits(file: Path) -> int:
    """Return a bitmap of the kernel's: words of a `long` in hexadecimal, the highest first."""
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
