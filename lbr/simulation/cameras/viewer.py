"""A viewer of a camera: its settings, and the picture under way to it."""

import fcntl
import socket
import struct
import termios
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from lbr.messages.unreadable import UNREADABLE
from lbr.simulation.cameras.renderers import LARGEST_PX

_RECORD = struct.Struct("<IQ")
_READ_BYTES = 4096
_LONGEST_LINE = 4096
_RESTING_PERIOD_S = 0.5


class Wanted(Struct, frozen=True):
    """A line from a client; left-out fields stay. A simulated camera ignores all controls."""

    width: Annotated[int, Meta(ge=16, le=LARGEST_PX[0])] | None = None
    height: Annotated[int, Meta(ge=16, le=LARGEST_PX[1])] | None = None
    fps: Annotated[float, Meta(gt=0.0, le=60.0)] | None = None
    controls: dict[str, float] = {}


class Viewer:
    """A connection. Pictures are sent one at a time: while one is under way, the next are skipped."""

    def __init__(self, device: str, mount: str, connection: socket.socket) -> None:
        self.device, self.mount, self.connection = device, mount, connection
        self.width_px, self.height_px, self.period_s = 640, 360, 1 / 15
        self.due: float | None = None
        self.seen_ns = 0
        self.closed = False
        self._inbox = bytearray()
        self._outgoing = memoryview(b"")
        connection.setblocking(False)

    def receive(self, now: float) -> None:
        """Read its orders; an invalid one or an end closes it."""
        try:
            data = self.connection.recv(_READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self._inbox += data
        if not data or len(self._inbox) > _LONGEST_LINE:
            self.closed = True
        while not self.closed and b"\n" in self._inbox:
            line, _, rest = self._inbox.partition(b"\n")
            self._inbox = rest
            self._obey(bytes(line), now)

    @property
    def looks(self) -> bool:
        """Return whether it wants more than the pictures for a driver whose camera rests."""
        return self.due is not None and self.period_s < _RESTING_PERIOD_S

    def busy(self) -> bool:
        """Return whether it has not read the last picture yet."""
        if self._outgoing:
            return True
        unread = bytearray(4)
        fcntl.ioctl(self.connection, termios.TIOCOUTQ, unread)
        return any(unread)

    def send(self, jpeg: bytes, taken_ns: int) -> None:
        """Begin to send a picture."""
        self._outgoing = memoryview(_RECORD.pack(len(jpeg), taken_ns) + jpeg)
        self.seen_ns = taken_ns
        self.go_on()

    def go_on(self) -> bool:
        """Send as much as possible now; return whether some is left."""
        try:
            while self._outgoing:
                self._outgoing = self._outgoing[self.connection.send(self._outgoing) :]
        except BlockingIOError:
            return True
        except OSError:
            self.closed = True
        return False

    def _obey(self, line: bytes, now: float) -> None:
        try:
            wanted = msgspec.json.decode(line, type=Wanted)
        except UNREADABLE:
            self.closed = True
            return
        self.width_px = wanted.width or self.width_px
        self.height_px = wanted.height or self.height_px
        self.period_s = 1 / wanted.fps if wanted.fps else self.period_s
        self.due = now if self.due is None else self.due
