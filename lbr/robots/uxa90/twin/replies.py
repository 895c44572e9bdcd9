"""The answers of a main board on its line, each byte in its own time, and their faults."""

from collections import deque
from random import Random

from lbr.robots.uxa90.twin import Uxa90Faults
from lbr.simulation.wire import flip_one_bit, noise

BABBLE_S = 0.004
_LIMIT_BYTES = 65_536


class Replies:
    """Bytes on their way to the host, in the order in which they were said; `faults` may be set at any time."""

    def __init__(self, faults: Uxa90Faults, seed: int, byte_s: float) -> None:
        self.faults = faults
        self._random = Random(seed)
        self._byte_s = byte_s
        self._out: deque[tuple[float, bytes]] = deque()
        self._free_at = self._babbles_at = 0.0

    def frame(self, data: bytes, at: float) -> None:
        """Say something of the main board's own from `at` on, as soon as the line is free."""
        if not self.faults.silent:
            self._say(self._flipped(data), at + self.faults.late_s)

    def servo(self, data: bytes, at: float) -> None:
        """Say what a servo answers from `at` on, as soon as the line is free."""
        faults = self.faults
        if faults.silent or faults.no_replies or self._hit(faults.missing):
            return
        if self._hit(faults.garbage):
            data = self._random.randbytes(len(data))
        if self._hit(faults.shifted):
            data = self._random.randbytes(1) + data
        self._say(self._flipped(data), at + faults.late_s)

    def due(self, now: float) -> bytes:
        """Take what has crossed the line so far."""
        if self.faults.babble and now >= self._babbles_at:
            self._babbles_at = now + self._random.uniform(0.5, 1.5) * BABBLE_S
            self._say(noise(self._random), now)
        taken = []
        while self._out and self._out[0][0] <= now:
            taken.append(self._out.popleft()[1])
        return b"".join(taken)

    def next_due(self) -> float | None:
        """Return when the next bytes will have crossed; None: nothing is on its way."""
        at = self._out[0][0] if self._out else None
        if not self.faults.babble:
            return at
        return self._babbles_at if at is None else min(at, self._babbles_at)

    def jitter(self, most_s: float) -> float:
        """Return some time up to the most."""
        return self._random.uniform(0.0, most_s)

    def clear(self) -> None:
        """Lose everything under way."""
        self._out.clear()
        self._free_at = 0.0

    def _say(self, data: bytes, at: float) -> None:
        if sum(len(waiting) for _, waiting in self._out) + len(data) > _LIMIT_BYTES:
            return
        self._free_at = max(at, self._free_at) + len(data) * self._byte_s
        self._out.append((self._free_at, data))

    def _flipped(self, data: bytes) -> bytes:
        return flip_one_bit(data, self._random) if self._hit(self.faults.bit_flip) else data

    def _hit(self, probability: float) -> bool:
        return probability > 0 and self._random.random() < probability
