"""The answers of a main board on its line, each byte in its own time, and their faults."""

from random import Random

from lbr.robots.uxa90.twin import Uxa90Faults
from lbr.simulation.wire import Babble, Outbox, flip_one_bit, strikes


class Replies:
    """Bytes on their way to the host, in their order; `faults` may be set at any time."""

    def __init__(self, faults: Uxa90Faults, seed: int, byte_s: float) -> None:
        self.faults = faults
        self._random = Random(seed)
        self._babble = Babble(self._random)
        self._outbox = Outbox(byte_s)

    def frame(self, data: bytes, at: float) -> None:
        """Send a frame of the main board's own from `at` on, as soon as the line is free."""
        if not self.faults.silent:
            self._outbox.send(self._flipped(data), at + self.faults.late_s)

    def servo(self, data: bytes, at: float) -> None:
        """Send a servo's answer from `at` on, as soon as the line is free."""
        faults = self.faults
        if faults.silent or faults.no_replies or strikes(faults.missing, self._random):
            return
        if strikes(faults.garbage, self._random):
            data = self._random.randbytes(len(data))
        if strikes(faults.shifted, self._random):
            data = self._random.randbytes(1) + data
        self._outbox.send(self._flipped(data), at + faults.late_s)

    def due(self, now: float) -> bytes:
        """Return the bytes that have crossed the line so far."""
        if self.faults.babble and (babble := self._babble.due(now)):
            self._outbox.send(babble, now)
        return self._outbox.due(now)

    def next_due(self) -> float | None:
        """Return when the next bytes will have crossed; None without any."""
        dues = (self._outbox.next_due(), self._babble.next_at if self.faults.babble else None)
        return min((at for at in dues if at is not None), default=None)

    def jitter(self, most_s: float) -> float:
        """Return a random time up to the most."""
        return self._random.uniform(0.0, most_s)

    def clear(self) -> None:
        """Discard all bytes on their way."""
        self._outbox.clear()

    def _flipped(self, data: bytes) -> bytes:
        return flip_one_bit(data, self._random) if strikes(self.faults.bit_flip, self._random) else data
