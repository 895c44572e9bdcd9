"""An emulated gamepad: Linux's records of a common one, with two sticks and two triggers.

Codes and directions are those of Linux's gamepad specification; sticks have 16 bits, triggers 8, as with xpad.
"""

import struct
from collections import deque
from collections.abc import Mapping
from random import Random
from typing import Any

from lbr.capability.context import Device
from lbr.simulation.devices.gamepad import GamepadFaults, GamepadRow
from lbr.simulation.faults import FaultValue
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row
from lbr.simulation.wire import noise

RECORD = struct.Struct("@llHHi")
"""`struct input_event`: seconds, microseconds, type, code, value."""
SYN, KEY, ABS = 0, 1, 3
KEYS = {
    "a": 0x130, "b": 0x131, "x": 0x133, "y": 0x134, "tl": 0x136, "tr": 0x137, "select": 0x13A, "start": 0x13B,
    "mode": 0x13C, "thumbl": 0x13D, "thumbr": 0x13E,
}  # fmt: skip
STICK = 32767
AXES = {
    "left_x": (0x00, STICK), "left_y": (0x01, -STICK), "right_x": (0x03, STICK), "right_y": (0x04, -STICK),
    "left_trigger": (0x02, 255), "right_trigger": (0x05, 255), "dpad_x": (0x10, 1), "dpad_y": (0x11, -1),
}  # fmt: skip
"""The code of each axis, and its value when it is fully pushed to the right or up."""


class EmulatedGamepad:
    """A gamepad and its input: each change is reported at once, in one packet."""

    def __init__(self, hand: GamepadFaults | None = None, *, seed: int = 0) -> None:
        self.hand = hand or GamepadFaults()
        self._sent: dict[tuple[int, int], int] = {}
        self._random = Random(seed)

    def plugged(self) -> None:
        """Begin anew: a program that opens it assumes that it is at rest."""
        self._sent = {}

    def poll(self, now: float) -> bytes:
        """Return the packet with the changes; empty without any, or out of range."""
        if self.hand.silent:
            return b""
        values = self._values()
        changed = {code: value for code, value in values.items() if value != self._sent.get(code, 0)}
        if not changed:
            return b""
        self._sent = values
        events = [(*code, value) for code, value in changed.items()]
        return b"".join(self._record(now, *event) for event in (*events, (SYN, 0, 0)))

    def _values(self) -> dict[tuple[int, int], int]:
        hand: Mapping[str, float] = {name: getattr(self.hand, name) for name in AXES}
        axes = {(ABS, code): round(hand[name] * full) for name, (code, full) in AXES.items()}
        return axes | {(KEY, code): int(name in self.hand.pressed) for name, code in KEYS.items()}

    def _record(self, now: float, type_: int, code: int, value: int) -> bytes:
        record = RECORD.pack(int(now), int(now % 1.0 * 1e6), type_, code, value)
        if self._random.random() < self.hand.half:
            record = record[: self._random.randrange(RECORD.size)]
        return noise(self._random) + record if self._random.random() < self.hand.garbage else record


class GamepadTwin(PortTwin[PtyPort, GamepadFaults]):
    """Sends all changes of its input, one after the other."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, GamepadRow)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        self._pad = EmulatedGamepad(settings.faults, seed=around.seed_for(device))
        self._hands = deque([settings.faults])

    def fault(self, name: str, value: FaultValue) -> dict[str, Any]:
        """Change its input, and return all of it; quick changes are not merged."""
        told = super().fault(name, value)
        self._hands.append(self._faults)
        return told

    def service(self, now: float) -> None:
        """Do all that is due: the cable, records out."""
        if plug(self.port, present=not self._faults.unplug):
            self._pad.plugged()
        self.port.read()
        records = b""
        while self._hands:
            self._pad.hand = self._hands.popleft()
            records += self._pad.poll(now)
        if records:
            self.port.write(records)
