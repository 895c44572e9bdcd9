"""What every inertial unit shares: SI units, full scales, the signs of one that measures nothing, and telling of it."""

from math import pi

from msgspec import Struct

from lbr.capability.context import Context
from lbr.messages.units import Vector

STANDARD_GRAVITY_MPS2 = 9.80665
RAD_PER_DEG = pi / 180.0
LOWEST, HIGHEST = -32768, 32767
REPORT_PERIOD_S = 5.0
Counts = tuple[int, int, int]


def scaled(counts: Counts, unit: float) -> Vector | None:
    """Return what three numbers of 16 bits mean; None if one is at the end of its range, which is not measured."""
    x, y, z = counts
    if LOWEST in counts or HIGHEST in counts:
        return None
    return (x * unit, y * unit, z * unit)


class LifeSigns:
    """Tells a unit at work from one that is asleep, gone or frozen: real noise never repeats, not even after a restart."""

    def __init__(self, most_alike: int) -> None:
        self._most_alike = most_alike
        self._last: tuple[int, ...] = ()
        self._alike = 0

    def missing(self, counts: tuple[int, ...]) -> str:
        """Return why the newest reading of all axes is none, empty if it is one."""
        self._alike = self._alike + 1 if counts == self._last else 1
        self._last = counts
        if not any(counts):
            return "all it reads is zero, as when the unit is asleep"
        if all(count == -1 for count in counts):
            return "all bits it reads are ones, as when no unit drives the bus"
        if self._alike > self._most_alike:
            return f"the unit is frozen: the same {self._alike} times in a row"
        return ""


class Notices:
    """Makes events of what a unit tells, none of a kind more often than every few seconds."""

    def __init__(self, ctx: Context[Struct]) -> None:
        self._ctx = ctx
        self._told: dict[str, float] = {}

    def tell(self, kind: str, text: str) -> None:
        """Tell people, unless they were told of the same kind a moment ago."""
        now = self._ctx.clock()
        if now - self._told.get(kind, -REPORT_PERIOD_S) >= REPORT_PERIOD_S:
            self._told[kind] = now
            self._ctx.event(kind, text, level="warning")
