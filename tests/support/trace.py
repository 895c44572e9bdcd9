"""Reads the file in which the emulated motor controller writes what its outputs did, and when."""

import select
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

CATCH_UP_S = 0.125
"""Growth may make up for this much: the longest step of the drive loop, and one period of it."""
ROUNDING = 0.003
REST_CAUSES = frozenset({"command", "watchdog", "emergency_stop"})
"""What a real controller would do too; the end of the emulation is none of it."""


@dataclass(frozen=True, slots=True)
class Output:
    """The outputs from this moment on: left and right wheel, forward positive."""

    at_ns: int
    left: float
    right: float
    cause: str

    @property
    def zero(self) -> bool:
        return self.left == 0.0 and self.right == 0.0

    @property
    def least(self) -> float:
        return min(abs(self.left), abs(self.right))

    @property
    def most(self) -> float:
        return max(abs(self.left), abs(self.right))


@dataclass(frozen=True, slots=True)
class Line:
    """A runtime command as the controller heard it."""

    at_ns: int
    text: str

    @property
    def moves(self) -> bool:
        """Say whether it asks a motor to turn."""
        words = self.text.split()
        return words[:1] == ["!M"] and any(word != "0" for word in words[1:])


Entry = Output | Line


class Trace:
    """Everything in the file so far; `read` takes in what is new."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entries: list[Entry] = []
        self._offset = 0
        self._rest = b""

    def read(self) -> list[Entry]:
        """Take in and return what was written since the last call."""
        try:
            with self.path.open("rb") as file:
                file.seek(self._offset)
                data = file.read()
        except FileNotFoundError:
            return []
        self._offset += len(data)
        *lines, self._rest = (self._rest + data).split(b"\n")
        new = [_parse(line.decode()) for line in lines]
        self.entries += new
        return new

    def outputs(self, since_ns: int = 0) -> list[Output]:
        """Return the changes of the outputs from a moment on, as read so far."""
        return [entry for entry in self._since(since_ns) if isinstance(entry, Output)]

    def lines(self, since_ns: int = 0) -> list[Line]:
        """Return the commands heard from a moment on, as read so far."""
        return [entry for entry in self._since(since_ns) if isinstance(entry, Line)]

    def now(self) -> Output:
        """Return the outputs as they are."""
        self.read()
        return self.at(time.monotonic_ns())

    def at(self, at_ns: int) -> Output:
        """Return the outputs as they were at a moment."""
        for entry in reversed(self.entries):
            if isinstance(entry, Output) and entry.at_ns <= at_ns:
                return entry
        return Output(0, 0.0, 0.0, "start")

    def first_zero(self, since_ns: int, limit_s: float) -> Output | None:
        """Wait for both outputs to be zero after a moment, by the controller's own doing; None if they are not."""
        end = time.monotonic() + limit_s
        while True:
            self.read()
            for entry in self.outputs(since_ns):
                if entry.zero and entry.cause in REST_CAUSES:
                    return entry
            if time.monotonic() > end:
                return None
            select.select([], [], [], 0.005)

    def _since(self, since_ns: int) -> Iterator[Entry]:
        first = len(self.entries)
        while first > 0 and self.entries[first - 1].at_ns >= since_ns:
            first -= 1
        return iter(self.entries[first:])


def limit_violations(outputs: list[Output], *, max_power: float, accel_per_s: float) -> list[str]:
    """Return where an output was above the configured maximum, or grew faster than configured."""
    found = [
        f"output {entry.left:g} {entry.right:g} above {max_power:g} at {entry.at_ns}"
        for entry in outputs
        if not entry.most <= max_power + ROUNDING
    ]
    for side in ("left", "right"):
        found += _too_fast([(entry.at_ns, getattr(entry, side)) for entry in outputs], accel_per_s)
    return found


def _too_fast(series: list[tuple[int, float]], accel_per_s: float) -> list[str]:
    """Follow the output with a value that grows as fast as allowed; the output may not run far ahead of it."""
    found: list[str] = []
    allowed, last, last_ns = 0.0, 0.0, 0
    for at_ns, value in series:
        allowed = min(allowed + accel_per_s * (at_ns - last_ns) * 1e-9, abs(last))
        if value * last < 0.0:
            allowed = 0.0
        if not abs(value) <= allowed + accel_per_s * CATCH_UP_S + ROUNDING:
            found.append(f"output grew from {last:g} to {value:g} faster than {accel_per_s:g}/s at {at_ns}")
        allowed, last, last_ns = min(allowed, abs(value)), value, at_ns
    return found


def _parse(line: str) -> Entry:
    at_ns, _, rest = line.partition(" ")
    if rest.startswith("line "):
        return Line(int(at_ns), rest[5:])
    left, right, cause = rest.split(" ")
    return Output(int(at_ns), float(left), float(right), cause)
