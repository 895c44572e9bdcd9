"""A gamepad as an open file: an input event device of the kernel, or an emulated one that sends the same records."""

import struct
from contextlib import ExitStack

from lbr.capability.context import Device
from lbr.drivers.gamepad.nodes import ANYWHERE, path_of
from lbr.drivers.gamepad.pad import AXES, STANDARD, Held, Pad, Span, X
from lbr.drivers.input_events import CODES, EVENT, RecordParser, read_event
from lbr.drivers.input_node import InputNode
from lbr.errors import DeviceError
from lbr.messages.gamepad import Link

NAME_BYTES = 256
_ID = struct.Struct("=4H")
_AXIS = struct.Struct("=6i")
_LINKS: dict[int, Link] = {0x03: "usb", 0x05: "bluetooth"}


def _reads(number: int, size: int) -> int:
    """Return the request that reads `size` bytes from an input device (EVIOCG…)."""
    return 2 << 30 | size << 16 | ord("E") << 8 | number


EVIOCGID = _reads(0x02, _ID.size)
EVIOCGNAME = _reads(0x06, NAME_BYTES)
EVIOCGKEY = _reads(0x18, CODES // 8)
EVIOCGBIT_ABS = _reads(0x20 + 3, 8)


def _eviocgabs(code: int) -> int:
    return _reads(0x40 + code, _AXIS.size)


class Receiver:
    """An open gamepad, which no other program reads meanwhile. Raises a DeviceError with the cure."""

    def __init__(self, device: Device) -> None:
        if not device.address.startswith(("/", ANYWHERE)):
            raise DeviceError(
                f"device '{device.name}' at {device.address} is neither a path (/dev/input/by-id/…-event-joystick) nor "
                "`input:` and a name: `lbr devices` shows what is there"
            )
        self._node = InputNode(device, path_of(device.address), RecordParser(EVENT.size, read_event))
        with ExitStack() as failed:
            failed.callback(self.close)
            self._node.claim()
            self.name = (self._node.ask(EVIOCGNAME, NAME_BYTES) or b"").split(b"\0")[0].decode(errors="replace")
            self.link: Link = self._link()
            self._codes = self._axes()
            self._pad = Pad(self._spans())
            self._ask_what_is_held()
            failed.pop_all()

    def poll(self) -> list[Held]:
        """Return the state at the end of each packet received since the last call."""
        whole = self._node.passed_over
        states = self._pad.feed(self._node.poll())
        if self._node.passed_over > whole:  # no kernel does that: nothing received with it is trusted
            states, self._pad.unknown = [], True
        if self._pad.unknown:
            self._ask_what_is_held()
            states.append(self.held())
        return states

    def held(self) -> Held:
        """Return the current state."""
        return self._pad.held()

    def close(self) -> None:
        """Release the gamepad; never fails."""
        self._node.close()

    def _link(self) -> Link:
        told = self._node.ask(EVIOCGID, _ID.size)
        return _LINKS.get(_ID.unpack(told)[0], "other") if told is not None else "other"

    def _axes(self) -> tuple[int, ...] | None:
        """Return the codes of its axes; None for an emulated gamepad, which does not report them."""
        told = self._node.ask(EVIOCGBIT_ABS, 8)
        if told is None:
            return None
        found = int.from_bytes(told, "little")  # words in the machine's order, which is little on all that lbr runs on
        codes = tuple(code for code in AXES if found >> code & 1)
        if X not in codes:
            raise self._node.error("is no gamepad: it has no stick; `lbr devices` shows which are", "wiring")
        return codes

    def _spans(self) -> dict[int, Span]:
        if self._codes is None:
            return dict(STANDARD)
        told = {code: self._node.ask(_eviocgabs(code), _AXIS.size) for code in self._codes}
        values = {code: _AXIS.unpack(one) for code, one in told.items() if one is not None}
        return {code: Span(least, most, flat) for code, (_, least, most, _, flat, _) in values.items()}

    def _ask_what_is_held(self) -> None:
        """Read the pad's current state. A pad without that request counts as at rest; it reports every change from now
        on."""
        keys = self._node.ask(EVIOCGKEY, CODES // 8)
        bits = int.from_bytes(keys or b"", "little")
        told = {code: self._node.ask(_eviocgabs(code), _AXIS.size) for code in self._codes or ()}
        values = {code: _AXIS.unpack(one)[0] for code, one in told.items() if one is not None}
        self._pad.tell(values, (code for code in range(CODES) if bits >> code & 1))
