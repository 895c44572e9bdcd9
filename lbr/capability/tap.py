"""The bytes of a device's line: always those of its first seconds, the others only while a recorder receives them."""

import time
from collections import deque

from lbr.messages.taped import LineBytes

OPENING_NS = 5_000_000_000
"""The bytes of a line are kept for this time after its opening: by then, the handshakes of all drivers are over."""
OPENING_PIECES = 2000
MOST_PIECES = 20_000
"""For one line between two messages: ten seconds of the fastest line."""


class Tap:
    """The bytes of one line; any thread of a driver adds them, one thread takes them."""

    def __init__(self) -> None:
        self._opening: list[LineBytes] = []
        self._opened_ns = 0
        self.is_line = self._heard = False
        self._live: deque[LineBytes] | None = None
        self._lost = 0

    def opened(self) -> None:
        """Begin anew: the line has just been opened."""
        self.is_line, self._heard = True, False
        self._opening = []
        self._opened_ns = time.monotonic_ns()

    @property
    def wanted(self) -> bool:
        """Return whether bytes are kept now."""
        return self._live is not None or self._opened_ns > 0

    def sent(self, data: bytes) -> None:
        """Add bytes that the driver wrote."""
        if self.wanted:
            self._take(data, sent=True)

    def came(self, data: bytes) -> None:
        """Add bytes that the driver read."""
        self._heard = True
        if self.wanted:
            self._take(data, sent=False)

    @property
    def heard(self) -> bool | None:
        """Return whether the device has sent anything since its line was opened; None without a line."""
        return self._heard if self.is_line else None

    @property
    def opening(self) -> tuple[LineBytes, ...]:
        """Return the bytes of the line's first seconds."""
        return tuple(self._opening)

    def listen(self, *, on: bool) -> None:
        """Keep bytes for `take`, or no longer."""
        self._live, self._lost = (deque(maxlen=MOST_PIECES) if on else None), 0

    def take(self) -> tuple[tuple[LineBytes, ...], int]:
        """Return the pieces since the last call, and the number of pieces that were dropped."""
        live, pieces = self._live, []
        while live:
            pieces.append(live.popleft())
        lost, self._lost = self._lost, 0
        return tuple(pieces), lost

    def _take(self, data: bytes, *, sent: bool) -> None:
        piece = LineBytes(time.monotonic_ns(), sent, data)
        if self._opened_ns:
            if piece.at_ns - self._opened_ns < OPENING_NS and len(self._opening) < OPENING_PIECES:
                self._opening.append(piece)
            else:
                self._opened_ns = 0
        live = self._live
        if live is not None:
            self._lost += len(live) == MOST_PIECES
            live.append(piece)
