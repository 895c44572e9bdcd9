"""The registers of a SAM servo, and the configuration packets that write and read them, by the wCK's protocol."""

from collections.abc import Mapping
from typing import NamedTuple

BAUD_115200 = 0x07
SAVING = frozenset({0x08, 0x09, 0x0C, 0x0D, 0x0F, 0x11, 0x15})
"""Commands that write EEPROM, which takes a while."""

_BAUDS = (0x00, 0x01, 0x03, BAUD_115200, 0x0F, 0x17, 0x5F, 0xBF)
_BYTE = range(255)
_GAINS: Mapping[int, tuple[int, int, int]] = {
    **dict.fromkeys((0, 1), (30, 10, 0)),
    **dict.fromkeys((2, 3), (40, 20, 0)),
    **dict.fromkeys((4, 5, 6, 7, 8, 9), (60, 20, 0)),
    **dict.fromkeys((10, 11), (40, 5, 0)),
}
"""P, D and I in the factory's walking motion."""

_OTHER_GAINS = (5, 5, 0)

Allowed = range | tuple[int, ...]


class _Write(NamedTuple):
    """The registers that a packet's two bytes set; the same one twice: both bytes must agree."""

    first: str
    second: str
    allowed: tuple[Allowed, Allowed]
    saved: bool = True
    answered: bool = True


_WRITES: Mapping[int, _Write] = {
    0x08: _Write("baud", "baud", (_BAUDS, _BAUDS)),
    0x09: _Write("p", "d", (range(1, 255), _BYTE)),
    0x0B: _Write("p", "d", (range(1, 255), _BYTE), saved=False),
    0x0C: _Write("id", "id", (range(31), range(31))),
    0x0D: _Write("speed", "acceleration", (range(31), range(20, 101))),
    0x0F: _Write("overload", "overload", (range(33, 200), range(33, 200))),
    0x11: _Write("lower", "upper", (_BYTE, _BYTE)),
    0x15: _Write("i", "i", (range(11), range(11))),
    0x17: _Write("speed", "acceleration", (range(31), range(20, 101)), saved=False, answered=False),
    0x18: _Write("i", "i", (range(11), range(11)), saved=False),
    0x64: _Write("outputs", "outputs", (_BYTE, _BYTE), saved=False),
    0xAE: _Write("p", "d", (range(1, 255), _BYTE), saved=False),
    0xB5: _Write("i", "i", (range(11), range(11)), saved=False),
}
_READS: Mapping[int, tuple[str, str]] = {
    0x0A: ("p", "d"),
    0x0E: ("speed", "acceleration"),
    0x10: ("overload", "overload"),
    0x12: ("lower", "upper"),
    0x16: ("i", "i"),
    0x65: ("outputs", "input"),
    0xAF: ("p", "d"),
    0xB6: ("i", "i"),
}


class Registers:
    """One servo's registers by name: the current values, and the saved ones, which are restored at power-up."""

    def __init__(self, number: int) -> None:
        p, d, i = _GAINS.get(number, _OTHER_GAINS)
        self._saved = {"id": number, "baud": BAUD_115200, "p": p, "d": d, "i": i, "speed": 30, "acceleration": 100}
        self._saved |= {"overload": 199, "lower": 0, "upper": 254, "outputs": 0, "input": 0}
        self._used = dict(self._saved)

    def __getitem__(self, name: str) -> int:
        return self._used[name]

    def boot(self) -> None:
        """Restore the saved values."""
        self._used = dict(self._saved)

    def execute(self, command: int, first: int, second: int) -> bytes | None:
        """Execute a packet; return its answer, None if it is unknown, not allowed, or unanswered."""
        if (read := _READS.get(command)) is not None:
            return bytes(self._used[name] for name in read)
        write = _WRITES.get(command)
        if write is None or first not in write.allowed[0] or second not in write.allowed[1]:
            return None
        if (write.first == write.second and first != second) or (write.first == "lower" and first > second):
            return None
        given = {write.first: first, write.second: second}
        self._used |= given
        if write.saved:
            self._saved |= given
        return bytes((first, second)) if write.answered else None
