"""A line in memory, in the test's own time."""

from types import SimpleNamespace
from typing import Any, Protocol

READ_S = 0.0005


class Device(Protocol):
    """What is at its end: an emulated device, or one by script."""

    def feed(self, data: bytes, now: float) -> bytes: ...

    def poll(self, now: float) -> bytes: ...


class MemoryLine:
    """`written` is what left the driver, and when; `unheard` never arrives, and `misread` arrives otherwise.

    `time` has `now`, which goes on while the driver waits: a context, or the line's own.
    """

    def __init__(self, device: Device, time: Any = None) -> None:
        self.device: Any = device
        self.time = time or SimpleNamespace(now=100.0)
        self.written: list[tuple[float, bytes]] = []
        self.unheard: tuple[bytes, ...] = ()
        self.misread: dict[bytes, bytes] = {}
        self.closed = False
        self._came = b""

    def clock(self) -> float:
        return float(self.time.now)

    def asked(self, data: bytes) -> int:
        """Return how often this was written."""
        return sum(one == data for _, one in self.written)

    def say(self, data: bytes) -> None:
        """Have bytes come that nothing asked for."""
        self._came += data

    def fileno(self) -> int:
        return -1

    def write(self, data: bytes) -> int:
        self.written.append((self.time.now, data))
        if data not in self.unheard:
            self._came += self.device.feed(data, self.time.now)
        return len(data)

    def read(self, wait_s: float = 0.0) -> bytes:
        until = self.time.now + wait_s
        while not (data := self._heard()) and self.time.now < until:
            self.time.now = min(until, self.time.now + READ_S)
        for said, instead in self.misread.items():
            data = data.replace(said, instead)
        return data

    def drop_output(self) -> None:
        pass

    def drop_input(self) -> None:
        self._came = b""

    def close(self) -> None:
        self.closed = True

    def _heard(self) -> bytes:
        data, self._came = self._came + self.device.poll(self.time.now), b""
        return data
