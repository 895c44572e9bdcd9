"""The common part of emulated devices with lines of ASCII: echo, line ends, answers and their faults."""

from random import Random
from typing import Generic, TypeVar

from lbr.simulation.faults import LineFaults
from lbr.simulation.wire import Outbox, flip_one_bit, noise, strikes

TURNAROUND_S = 0.0005

_LINE_LIMIT = 64
_QRY, _ACK = 0x05, b"\x06"

F = TypeVar("F", bound=LineFaults)


class AsciiDevice(Generic[F]):
    """Assembles lines, which end with CR or `_`, echoes them, and sends answers; subclasses `execute` the lines."""

    def __init__(self, faults: F, seed: int) -> None:
        self.echo = True
        self.random = Random(seed)
        self.outbox = Outbox()
        self._faults = faults
        self.boot()

    @property
    def faults(self) -> F:
        """Return the faults; setting them takes effect at once."""
        return self._faults

    @faults.setter
    def faults(self, faults: F) -> None:
        if self._faults.brown_out and not faults.brown_out:
            self.boot()
        self._faults = faults

    def boot(self) -> None:
        """Restart; subclasses reset their state."""
        self._line = bytearray()
        self._echoed = 0

    def execute(self, line: str, now: float) -> None:
        """Carry out a line, and answer."""

    def receive(self, data: bytes, now: float) -> None:
        """Receive bytes from the host."""
        for byte in data:
            self._take(byte, now)
        self._echo_partial(now)

    def answer(self, text: str, now: float) -> None:
        """Answer a line, unless a fault drops the answer."""
        if strikes(self._faults.drop, self.random):
            return
        if strikes(self._faults.garbage, self.random):
            self.send(noise(self.random), now)
        self.send(text.encode("ascii") + b"\r", now)

    def send(self, data: bytes, now: float) -> None:
        """Send bytes on the line."""
        if self._faults.silent:
            return
        if strikes(self._faults.bit_flip, self.random):
            data = flip_one_bit(data, self.random)
        self.outbox.send(data, now, TURNAROUND_S)

    def _take(self, byte: int, now: float) -> None:
        self.outbox.received(1, now)
        if byte == _QRY:
            self.send(_ACK, now)
        elif byte in b"\r_":
            self._line.append(byte)
            self._echo_partial(now)
            line = self._line[:-1].decode("ascii").strip()
            self._line.clear()
            self._echoed = 0
            self.execute(line, now)
        elif 0x20 <= byte < 0x7F:
            self._line.append(byte)
            if len(self._line) > _LINE_LIMIT:
                self._line.clear()
                self._echoed = 0
                self.answer("-", now)

    def _echo_partial(self, now: float) -> None:
        if self.echo and len(self._line) > self._echoed:
            self.send(bytes(self._line[self._echoed :]), now)
        self._echoed = len(self._line)
