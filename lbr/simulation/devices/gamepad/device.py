"""An emulated gamepad: Linux's records of a common one, with two sticks and two triggers. No I/O.

Codes and directions are those of Linux's gamepad specification; sticks have 16 bits, triggers 8, as with xpad.
"""

import struct
from collections.abc import Mapping
from random import Random

from lbr.simulation.devices.gamepad import GamepadFaults
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
