"""A simulated serial line's time: answers come no earlier than their bytes would take, and may be spoilt."""

from collections import deque
from random import Random

BYTE_S = 10 / 115_200
"""One byte at 115200 baud, 8N1."""

_LIMIT_BYTES = 65_536


class Outbox:
    """Bytes on their way to the host, each chunk with the moment its last byte has crossed the line."""

    def __init__(self) -> None:
        self._chunks: deque[tuple[float, bytes]] = deque()
        self._size = 0
        self._heard_at = 0.0
        self._free_at = 0.0

    def received(self, count: int, now: float) -> None:
        """Account for the time that `count` bytes from the host took to arrive."""
        self._heard_at = max(now, self._heard_at) + count * BYTE_S

    def send(self, data: bytes, now: float, turnaround_s: float = 0.0) -> None:
        """Put an answer on the line; beyond what a port buffers, bytes are lost as they would be."""
        if self._size + len(data) > _LIMIT_BYTES:
            return
        self._free_at = max(now, self._free_at, self._heard_at + turnaround_s) + len(data) * BYTE_S
        self._chunks.append((self._free_at, data))
        self._size += len(data)

    def due(self, now: float) -> bytes:
        """Take what has crossed the line so far."""
        taken = []
        while self._chunks and self._chunks[0][0] <= now:
            taken.append(self._chunks.popleft()[1])
        data = b"".join(taken)
        self._size -= len(data)
        return data

    def next_due(self) -> float | None:
        """Return when the next chunk will have crossed, or None."""
        return self._chunks[0][0] if self._chunks else None

    def clear(self) -> None:
        """Lose everything under way."""
        self._chunks.clear()
        self._size = 0
        self._heard_at = self._free_at = 0.0


def noise(random: Random) -> bytes:
    """Return a few bytes of line noise."""
    return random.randbytes(random.randint(1, 12))


def flip_one_bit(data: bytes, random: Random) -> bytes:
    """Return the data with one of its bits wrong."""
    if not data:
        return data
    spoilt = bytearray(data)
    spoilt[random.randrange(len(spoilt))] ^= 1 << random.randrange(8)
    return bytes(spoilt)
