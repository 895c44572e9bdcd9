"""Emulated ends of lines that say what a recording has: to each question its answer of about that time, the rest by the clock."""

import heapq
import select
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from lbr.capability.kind import Emulation
from lbr.drivers.i2c_socket import Read, Write, encode_transaction
from lbr.errors import DeviceError
from lbr.recording.lines import RecordedLine
from lbr.simulation.i2c import FramingError, RequestReader, refusal
from lbr.simulation.port import PtyPort
from lbr.simulation.socket_port import SocketPort

ROUND_S = 0.005
EARLIER_NS = 300_000
"""What a driver measures of an answer's delay has its own and the kernel's share in it, which comes here once more."""
WHOLE_S = 0.003
"""So long the rest of a question may take."""
LEAD_NS = 1_000_000_000
"""Of what comes by itself, the first second is said again and again until the recording's time begins."""
KEPT = 20

Now = Callable[[], int]


class Clock:
    """Which time of the recording it is, in ns: its beginning until `start` is called."""

    def __init__(self, start_ns: int, end_ns: int) -> None:
        self.start_ns, self.end_ns = start_ns, end_ns
        self._made_ns = time.monotonic_ns()
        self._began_ns: int | None = None

    def start(self) -> None:
        """Have the recording's time go on from now."""
        self._began_ns = time.monotonic_ns()

    @property
    def began(self) -> bool:
        """Say whether the recording's time goes on."""
        return self._began_ns is not None

    def now_ns(self) -> int:
        """Return the time of the recording; it stands still at its end."""
        if self._began_ns is None:
            return self.start_ns
        return min(self.end_ns, self.start_ns + time.monotonic_ns() - self._began_ns)

    def waited_ns(self) -> int:
        """Return for how long it has been there before the recording's time began."""
        return (self._began_ns or time.monotonic_ns()) - self._made_ns


class End(Protocol):
    """One device's end."""

    unlike: list[bytes]
    asked: int

    def fileno(self) -> int:
        """Return what to wait for."""

    def service(self) -> None:
        """Do what is due."""

    def close(self) -> None:
        """Take the device away."""


class _Spoken:
    """What comes by itself, as time goes on; before the recording's time begins, its first second over and over."""

    def __init__(self, line: RecordedLine, clock: Clock) -> None:
        self._line, self._clock = line, clock
        self._at_ns = clock.start_ns

    def due(self) -> list[bytes]:
        """Return what has come since the last call."""
        clock = self._clock
        if clock.began:
            before, self._at_ns = max(self._at_ns, clock.start_ns) if self._began else clock.start_ns, clock.now_ns()
            self._began = True
            return self._line.came(before, self._at_ns)
        before, self._at_ns = self._at_ns, clock.start_ns + clock.waited_ns() % LEAD_NS
        if self._at_ns < before:
            return self._line.came(before, clock.start_ns + LEAD_NS) + self._line.came(clock.start_ns, self._at_ns)
        return self._line.came(before, self._at_ns)

    _began = False


class TtyEnd:
    """A device at a pseudo-terminal."""

    def __init__(self, line: RecordedLine, path: str, clock: Clock) -> None:
        self.unlike: list[bytes] = []
        self.asked = 0
        self._line, self._clock = line, clock
        self._spoken = _Spoken(line, clock)
        self._port = PtyPort(path)
        self._port.plug()
        self._waiting: list[tuple[int, int, bytes]] = []
        self._number = 0
        self._buffer = b""
        self._since = 0.0

    def fileno(self) -> int:
        """Return what to wait for."""
        return self._port.fileno()

    def service(self) -> None:
        """Take questions, and say what is due."""
        if data := self._port.read():
            self._buffer += data
            self._since = time.monotonic()
        while self._buffer and (question := self._next()):
            self._buffer = self._buffer[len(question) :]
            self._answer(question)
        for data in self._spoken.due():
            self._port.write(data)
        now_ns = time.monotonic_ns()
        while self._waiting and self._waiting[0][0] <= now_ns:
            self._port.write(heapq.heappop(self._waiting)[2])

    def close(self) -> None:
        """Take the device away."""
        with suppress(DeviceError, OSError):
            self._port.unplug()

    def _next(self) -> bytes:
        """Return the question that is there; nothing while it may not be whole yet."""
        if self._line.known(self._buffer):
            return self._buffer
        if first := self._line.first(self._buffer):
            return first
        if self._line.begins(self._buffer) and time.monotonic() - self._since < WHOLE_S:
            return b""
        return self._buffer

    def _answer(self, question: bytes) -> None:
        self.asked += 1
        if not self._line.known(question) and len(self.unlike) < KEPT:
            self.unlike.append(question)
        now_ns = time.monotonic_ns()
        for answer in self._line.answers(question, self._clock.now_ns()):
            self._number += 1
            heapq.heappush(self._waiting, (now_ns + answer.after_ns - EARLIER_NS, self._number, answer.data))


class I2cEnd:
    """Devices on an i2c bus at a socket."""

    def __init__(self, line: RecordedLine, path: str, clock: Clock) -> None:
        self.unlike: list[bytes] = []
        self.asked = 0
        self._line, self._clock = line, clock
        self._port = SocketPort(path)
        self._port.plug()
        self._requests: dict[int, RequestReader] = {}

    def fileno(self) -> int:
        """Return what to wait for."""
        return self._port.fileno()

    def service(self) -> None:
        """Answer every transaction that came."""
        for client, data in self._port.receive():
            if not data:
                self._requests.pop(client, None)
                continue
            try:
                transactions = self._requests.setdefault(client, RequestReader()).feed(data)
            except FramingError:
                self._port.drop(client)
                continue
            for messages in transactions:
                asked = [
                    Read(one.address, one.read) if one.read is not None else Write(one.address, one.write)
                    for one in messages
                ]
                answer = self._answered(encode_transaction(asked), sum(one.read or 0 for one in messages))
                if self._port.send(client, answer) < len(answer):
                    self._port.drop(client)

    def close(self) -> None:
        """Take the bus away."""
        with suppress(DeviceError, OSError):
            self._port.unplug()

    def _answered(self, question: bytes, due: int) -> bytes:
        self.asked += 1
        if not self._line.known(question) and len(self.unlike) < KEPT:
            self.unlike.append(question)
        answer = b"".join(one.data for one in self._line.answers(question, self._clock.now_ns()))
        if answer[:1] == b"\0" and len(answer) != due + 1:
            return refusal() if due else b"\0"
        return answer or refusal()


class Ends:
    """The devices of a robot, served by a thread of their own until they are closed."""

    def __init__(self, clock: Clock) -> None:
        self.by_device: dict[str, End] = {}
        self._clock = clock
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="recorded ends", daemon=True)

    def add(self, line: RecordedLine, path: str, emulated: Emulation) -> None:
        """Have a device at a path, before the ends are opened."""
        self.by_device[line.device] = (I2cEnd if emulated == "socket" else TtyEnd)(line, path, self._clock)

    def open(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def close(self) -> None:
        """Take all devices away."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join(1.0)
        for end in self.by_device.values():
            end.close()

    def _serve(self) -> None:
        ends = {end.fileno(): end for end in self.by_device.values()}
        poll = select.poll()
        for descriptor in ends:
            poll.register(descriptor, select.POLLIN)
        while not self._over.is_set():
            poll.poll(ROUND_S * 1000)
            for end in ends.values():
                end.service()
