"""Emulated devices that replay a recording: they answer each question as at about that time, and send the rest by the
clock.

A process of its own serves them, as some drivers wait for an answer for a millisecond only.
"""

import gc
import heapq
import multiprocessing
import select
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.sharedctypes import Synchronized
from typing import NamedTuple

from lbr.apps.recorder.recording.lines import Answer, RecordedLine
from lbr.drivers.i2c_bus import Read, Write, encode_transaction
from lbr.errors import BusError, DeviceError
from lbr.simulation.i2c import FramingError, RequestReader, refusal
from lbr.simulation.port import PtyPort
from lbr.simulation.socket_port import SocketPort

ROUND_S = 0.005
SHARE = 0.5
"""The share of a recorded delay that an answer waits here; the driver and the kernel add the rest again."""
WHOLE_S = 0.002
"""The longest wait for the rest of a question."""
LEAD_NS = 1_000_000_000
"""The first part of the recording, which repeats until all processes are up, so that they know the values at rest."""
KEPT = 20
UP_S = 10.0


class Questions(NamedTuple):
    """The number of questions to a device, and the first ones that the recording does not have."""

    times: int
    unlike: tuple[bytes, ...]


class Clock:
    """The present time of the recording in ns, the same in every process; it advances after `start`."""

    def __init__(self, start_ns: int, end_ns: int) -> None:
        self.start_ns, self.end_ns = start_ns, end_ns
        self._made_ns = time.monotonic_ns()
        self._began_ns: Synchronized[int] = multiprocessing.get_context("fork").Value("q", 0)

    def start(self) -> None:
        """Start the recording's time."""
        self._began_ns.value = time.monotonic_ns()

    @property
    def began_ns(self) -> int:
        """The monotonic time of `start`; 0 before it."""
        return self._began_ns.value

    def now_ns(self) -> int:
        """Return the time of the recording: its first second over and over before `start`, its end after the end."""
        began_ns = self._began_ns.value
        if not began_ns:
            return self.start_ns + (time.monotonic_ns() - self._made_ns) % LEAD_NS
        return min(self.end_ns, self.start_ns + time.monotonic_ns() - began_ns)


class _End(ABC):
    """One device at a port: how many questions it received, and those that the recording does not have."""

    def __init__(self, line: RecordedLine, port: PtyPort | SocketPort, clock: Clock) -> None:
        self.unlike: list[bytes] = []
        self.asked = 0
        self._line, self._port, self._clock = line, port, clock
        self._at_ns = clock.now_ns()
        port.plug()

    def fileno(self) -> int:
        """Return the descriptor to wait for."""
        return self._port.fileno()

    @abstractmethod
    def service(self) -> float:
        """Receive and send what is due; return the seconds until the next call."""

    def close(self) -> None:
        """Unplug the device."""
        with suppress(DeviceError, OSError):
            self._port.unplug()

    def _answers(self, question: bytes) -> tuple[Answer, ...]:
        """Count a question, and return its recorded answers at about now."""
        self.asked += 1
        if not self._line.known(question) and len(self.unlike) < KEPT:
            self.unlike.append(question)
        return self._line.answers(question, self._clock.now_ns())

    def _due(self) -> list[bytes]:
        """Return the unasked bytes since the last call; the clock may have gone back to the start."""
        before, self._at_ns = self._at_ns, self._clock.now_ns()
        if self._at_ns < before:
            before = self._clock.start_ns
        return self._line.came(before, self._at_ns)


class _TtyEnd(_End):
    """A device at a pseudo-terminal."""

    _port: PtyPort

    def __init__(self, line: RecordedLine, path: str, clock: Clock) -> None:
        super().__init__(line, PtyPort(path), clock)
        self._waiting: list[tuple[int, int, bytes]] = []
        self._number = 0
        self._buffer = b""
        self._since = 0.0

    def service(self) -> float:
        """Receive questions, and send what is due."""
        if data := self._port.read():
            self._buffer += data
            self._since = time.monotonic()
        while self._buffer:
            question, unfinished = self._line.question(self._buffer)
            if unfinished and time.monotonic() - self._since < WHOLE_S:
                break
            self._buffer = self._buffer[len(question) :]
            self._answer(question)
        for data in self._due():
            self._port.write(data)
        while self._waiting and self._waiting[0][0] <= time.monotonic_ns():
            self._port.write(heapq.heappop(self._waiting)[2])
        if self._waiting:
            return max(0.0, (self._waiting[0][0] - time.monotonic_ns()) / 1e9)
        return WHOLE_S if self._buffer else ROUND_S

    def _answer(self, question: bytes) -> None:
        now_ns = time.monotonic_ns()
        for answer in self._answers(question):
            self._number += 1
            heapq.heappush(self._waiting, (now_ns + int(SHARE * answer.after_ns), self._number, answer.data))


class _I2cEnd(_End):
    """Devices on an i2c bus at a socket."""

    _port: SocketPort

    def __init__(self, line: RecordedLine, path: str, clock: Clock) -> None:
        super().__init__(line, SocketPort(path), clock)
        self._requests: dict[int, RequestReader] = {}

    def service(self) -> float:
        """Answer every transaction received."""
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
        return ROUND_S

    def _answered(self, question: bytes, due: int) -> bytes:
        answer = b"".join(one.data for one in self._answers(question))
        if answer[:1] == b"\0" and len(answer) != due + 1:
            return refusal() if due else b"\0"
        return answer or refusal()


class _TalkingEnd(_End):
    """A device at a socket that sends by itself; received bytes change nothing."""

    _port: SocketPort

    def __init__(self, line: RecordedLine, path: str, clock: Clock) -> None:
        super().__init__(line, SocketPort(path), clock)

    def service(self) -> float:
        """Send what is due."""
        self._port.receive()
        for data in self._due():
            for client in self._port.clients:
                self._port.send(client, data)
        return ROUND_S


class Ends:
    """The devices of a robot: lines by the device's address. Open them before starting threads, as this forks a
    process."""

    def __init__(self, clock: Clock, lines: Mapping[str, RecordedLine]) -> None:
        context = multiprocessing.get_context("fork")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(clock, lines, theirs), daemon=True)
        self._process.start()
        theirs.close()
        said = self._ours.recv() if self._ours.poll(UP_S) else "no answer"
        if said:
            raise BusError(f"the recorded devices cannot be emulated: {said}")

    def close(self) -> dict[str, Questions]:
        """Unplug all devices; return the questions to each, by the device's address."""
        asked: dict[str, Questions] = {}
        with suppress(OSError, EOFError):
            self._ours.send(None)
            if self._ours.poll(UP_S):
                asked = self._ours.recv()
        self._process.join(1.0)
        self._process.kill()
        self._process.join()
        return asked


def _end(line: RecordedLine, address: str, clock: Clock) -> _End:
    path = address.removeprefix("unix:")
    if path == address:
        return _TtyEnd(line, path, clock)
    return _I2cEnd(line, path, clock) if line.exchanges else _TalkingEnd(line, path, clock)


def _serve(clock: Clock, lines: Mapping[str, RecordedLine], parent: Connection) -> None:
    ends: dict[str, _End] = {}
    try:
        for address, line in lines.items():
            ends[address] = _end(line, address, clock)
    except (DeviceError, OSError) as err:
        parent.send(str(err))
        return
    parent.send("")
    gc.freeze()
    gc.disable()  # a recording lasts minutes only
    waited_for = [parent.fileno(), *(end.fileno() for end in ends.values())]
    try:
        wait_s = 0.0
        while parent.fileno() not in select.select(waited_for, [], [], wait_s)[0]:
            wait_s = min((end.service() for end in ends.values()), default=ROUND_S)
        parent.send({address: Questions(end.asked, tuple(end.unlike)) for address, end in ends.items()})
    except (OSError, KeyboardInterrupt):
        pass
    finally:
        for end in ends.values():
            end.close()
