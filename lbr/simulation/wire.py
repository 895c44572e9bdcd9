"""The timing of a simulated serial line: answers come no earlier than their bytes, and may be spoilt."""

from collections import deque
from random import Random

BYTE_S = 10 / 115_200
"""One byte at 115200 baud, 8N1."""

_LIMIT_BYTES = 65_536
_BABBLE_S = 0.004


class Outbox:
    """Bytes on their way to the host, each chunk with the time at which its last byte has crossed the line."""

    def __init__(self, byte_s: float = BYTE_S) -> None:
        self._byte_s = byte_s
        self._chunks: deque[tuple[float, bytes]] = deque()
        self._size = 0
        self._heard_at = 0.0
        self._free_at = 0.0

    def received(self, count: int, now: float) -> None:
        """Add the time that `count` bytes from the host took to arrive."""
        self._heard_at = max(now, self._heard_at) + count * self._byte_s

    def send(self, data: bytes, now: float, turnaround_s: float = 0.0) -> None:
        """Send an answer as soon as the line is free."""
        if self._fits(data):
            self._free_at = max(now, self._free_at, self._heard_at + turnaround_s) + len(data) * self._byte_s
            self._put(data, self._free_at)

    def arrive(self, data: bytes, at: float) -> None:
        """Let bytes arrive at a time, behind the earlier ones."""
        if data and self._fits(data):
            self._put(data, max(at, self._chunks[-1][0]) if self._chunks else at)

    def due(self, now: float) -> bytes:
        """Remove and return the bytes that have crossed the line so far."""
        taken = []
        while self._chunks and self._chunks[0][0] <= now:
            taken.append(self._chunks.popleft()[1])
        data = b"".join(taken)
        self._size -= len(data)
        return data

    def next_due(self) -> float | None:
        """Return when the next chunk will have crossed, or None."""
        return self._chunks[0][0] if self._chunks else None

    def lose_after(self, now: float) -> None:
        """Drop the bytes that are still under way."""
        while self._chunks and self._chunks[-1][0] > now:
            self._size -= len(self._chunks.pop()[1])

    def clear(self) -> None:
        """Drop all bytes under way."""
        self._chunks.clear()
        self._size = 0
        self._heard_at = self._free_at = 0.0

    def _fits(self, data: bytes) -> bool:
        """Return whether a port buffers so much; further bytes are lost."""
        return self._size + len(data) <= _LIMIT_BYTES

    def _put(self, data: bytes, at: float) -> None:
        self._chunks.append((at, data))
        self._size += len(data)


class Babble:
    """Continuous noise, while it is on."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self.next_at = 0.0

    def due(self, now: float) -> bytes:
        """Return the noise of this moment."""
        if now < self.next_at:
            return b""
        self.next_at = now + self._random.uniform(0.5, 1.5) * _BABBLE_S
        return noise(self._random)


def strikes(probability: float, random: Random) -> bool:
    """Return whether a fault strikes this time, at random."""
    return probability > 0 and random.random() < probability


def noise(random: Random) -> bytes:
    """Return a few bytes of line noise."""
    return random.randbytes(random.randint(1, 12))


def flip_one_bit(data: bytes, random: Random) -> bytes:
    """Return the data with one flipped bit."""
    if not data:
        return data
    spoilt = bytearray(data)
    spoilt[random.randrange(len(spoilt))] ^= 1 << random.randrange(8)
    return bytes(spoilt)
