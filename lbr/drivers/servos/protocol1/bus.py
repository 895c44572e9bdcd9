"""Transactions on a servo bus of protocol 1.0, one at a time: asked, answered or given up, counted. For one thread."""

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from types import TracebackType
from typing import Literal, Self

from lbr.drivers.servos.contract import Counts
from lbr.drivers.servos.line import ServoLine
from lbr.drivers.servos.protocol1 import packet
from lbr.drivers.servos.protocol1.packet import Status, StatusParser
from lbr.drivers.servos.protocol1.question import GOOD_SUM, Question, packet_in
from lbr.drivers.servos.protocol1.register import Register

MARGIN_S = 0.01
QUIET_S = 0.002
"""After this silence an answer has ended, if it is long enough. Chosen, not measured: several times the 0.5 ms that a
servo may be set to wait."""
LISTEN_SLICE_S = 0.002
WARY_S = 1.0
"""After a lost answer the line is emptied before each request for this long. Chosen, not measured."""
LATE_S = 0.01
"""The latest arrival of a lost answer: a repeated request waits for it, so that it is not taken for the next answer.
Chosen, not measured."""
MOST_BYTES = 4096


class ProtocolBus:
    """Transactions on a bus of servos with protocol 1.0, with any control table. A lost answer is None, `trouble` has
    the reason and `lost` the kind; a lost line is a DeviceError.

    `written_all` counts the writes to several servos at once. While the bus waits with the wire free, and between
    tries, it calls `urgent`; if that is true it skips the rest and sets `cut_short`.
    """

    refusals = 0
    """The error bits with which a servo refuses a write."""

    def error_names(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits, for people."""
        return tuple(f"bit {bit}" for bit in range(8) if error >> bit & 1)

    def __init__(
        self,
        line: ServoLine,
        *,
        retries: int = 1,
        clock: Callable[[], float] = time.monotonic,
        urgent: Callable[[], object] = lambda: False,
    ) -> None:
        self.counts = Counts()
        self.strays: Counter[int] = Counter()
        self.trouble = ""
        self.lost: Literal["", "silent", "garbled", "refused"] = ""
        self.refused = 0
        self.cut_short = False
        self.written_all = 0
        self.echo = False
        self._line = line
        self._tries = retries + 1
        self._clock = clock
        self._urgent = urgent
        self._wary_until = 0.0
        self._late: dict[bytes, float] = {}

    def ping(self, servo: int, *, tries: int | None = None) -> Status | None:
        """Check whether a servo answers; its error bits are in the answer."""
        question = self.question(servo, packet.ping(servo), 0)
        answer = self.ask(question, tries)
        if answer == question.request:  # an echo and the answer of a servo with a voltage error look alike
            return self.read(servo, 0, 1)
        return status_of(answer)

    def read(
        self, servo: int, address: int, count: int, *, tries: int | None = None, patience_s: float = inf
    ) -> Status | None:
        """Return `count` bytes of a servo's control table; a late answer gets `patience_s` beyond the time of wire and
        servo."""
        return status_of(self.ask(self.question(servo, packet.read(servo, address, count), count), tries, patience_s))

    def get(self, servo: int, register: Register) -> int | None:
        """Return the value of a register."""
        status = self.read(servo, register.address, register.size)
        return None if status is None else register.decode(status.params, register.address)

    def put(self, servo: int, register: Register, value: int) -> bool:
        """Write a register; return whether the servo acknowledged it. Raise ValueError for a value that it would
        refuse."""
        return self.write(servo, register.address, register.encode(value))

    def write(self, servo: int, address: int, data: bytes, *, tries: int | None = None) -> bool:
        """Write bytes; return whether the servo acknowledged them without a complaint."""
        status = status_of(self.ask(self.question(servo, packet.write(servo, address, data), 0), tries))
        return status is not None and not status.error & self.refusals

    def write_all(self, address: int, blocks: Mapping[int, bytes]) -> None:
        """Write each servo its block at the same time; servos do not answer that."""
        if blocks:
            for request in packet.sync_write(address, blocks):
                self._line.send(request)
            self.written_all += 1

    def scan(self, servos: Iterable[int] = range(packet.HIGHEST_ID + 1)) -> list[int]:
        """Return the servos that answer a PING; takes some ten milliseconds for each of the others."""
        return [servo for servo in servos if self.ping(servo) is not None]

    def leftover(self) -> list[Status]:
        """Return the packets that arrive unexpectedly within a moment, such as from a second servo with the same id."""
        data = self._line.read(QUIET_S)
        return StatusParser().feed(data) if data else []

    def ask(self, question: Question, tries: int | None = None, patience_s: float = inf) -> bytes | None:
        """Send a request, with retries, and return the whole packet that answers it."""
        line = self._line
        self.cut_short = False
        for attempt in range(tries or self._tries):
            self.counts.retries += attempt > 0
            if self._wary_until:
                self._settle(question)
            line.send(question.request)
            late_s = min(patience_s, question.within_s - question.busy_s)
            data = line.read(question.busy_s) or self._patience(late_s)
            if (
                len(data) == question.size
                and data.startswith(question.head)
                and sum(data) & 0xFF == GOOD_SUM
                and data[4] < 0x80
                and data != question.request
            ):
                return data
            found = self._sift(data, question, question.busy_s + late_s)
            if found is not None:
                return found
            if self._urgent():
                self.cut_short = True
                return None
        return None

    def ask_each(self, request: bytes, servos: Sequence[int], count: int) -> dict[int, Status]:
        """Send one request that each of these servos answers in its turn; return the answers that arrived in time."""
        answers: dict[int, Status] = {}
        parser, line = StatusParser(), self._line
        self.cut_short = False
        if self._wary_until:
            self._came_late(line.read(0.0))
        line.send(request)
        answers_bytes = (packet.OVERHEAD_BYTES + count) * len(servos)
        until = self._clock() + line.busy_s(len(request), answers_bytes, len(servos)) + line.margin_s
        while len(answers) < len(servos) and (left_s := until - self._clock()) > 0.0:
            data = line.read(min(LISTEN_SLICE_S, left_s))
            for status in parser.feed(data):
                if status.id in servos and status.id not in answers and len(status.params) == count:
                    answers[status.id] = status
                else:
                    self.counts.strays += 1
            if not data and self._urgent():
                self.cut_short = True
                break
        self.counts.babble += parser.noise - len(request) * self.echo
        self._miss([servo for servo in servos if servo not in answers], count)
        return answers

    def drain(self) -> None:
        """Discard unexpected input; a lost line raises."""
        self.leftover()

    def close(self) -> None:
        """Close the line."""
        self._line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, err: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def write_each(self, register: Register, values: Mapping[int, int]) -> None:
        """Write each servo its value of a register at the same time; servos do not answer that."""
        self.write_all(register.address, {servo: register.encode(value) for servo, value in values.items()})

    def question(self, servo: int, request: bytes, count: int) -> Question:
        """Prepare a request with an answer of `count` bytes, for repeated use."""
        size = packet.OVERHEAD_BYTES + count
        head = packet.HEADER + bytes((servo, count + 2))
        busy_s = self._line.busy_s(len(request), size)
        return Question(servo, request, head, size, busy_s, busy_s + self._line.margin_s)

    def _sift(self, data: bytes, question: Question, within_s: float) -> bytes | None:
        """Return the answer among the input until the time is over; count the other packets."""
        until = self._clock() + within_s
        while True:
            rest = self._without_echo(data, question)
            packet_bytes = packet_in(rest, question)
            if packet_bytes is not None:
                if len(rest) > question.size:
                    self._judge(rest.replace(packet_bytes, b"", 1), question)
                return packet_bytes
            left_s = until - self._clock() if data else 0.0
            if len(rest) >= question.size:
                left_s = min(left_s, QUIET_S)
            more = self._patience(left_s) if len(data) < MOST_BYTES else b""
            if not more:
                break
            data += more
        self._lose(rest, question)
        return None

    def _patience(self, wait_s: float) -> bytes:
        """Return the input that arrives in that time; stop at once when something is urgent."""
        until = self._clock() + wait_s
        while (left_s := until - self._clock()) > 0.0 and not self._urgent():
            data = self._line.read(min(LISTEN_SLICE_S, left_s))
            if data:
                return data
        return b""

    def _without_echo(self, data: bytes, question: Question) -> bytes:
        """Remove the request that some adapters echo before the answer."""
        request = question.request
        if not data.startswith(request):
            return data
        if not self.echo and len(data) == len(request) == question.size and request[4] == packet.PING:
            return data  # may be the answer
        self.echo = self.echo or request[4] != packet.PING
        return data[len(request) :]

    def _miss(self, servos: Sequence[int], count: int) -> None:
        """Count a lost answer; it may come late, and must not be taken for the answer to the next request."""
        if servos and not self.cut_short:
            self.counts.timeouts += len(servos)
            self.trouble, self.lost = "does not answer", "silent"
        now = self._clock()
        for servo in servos:
            self._late[packet.HEADER + bytes((servo, count + 2))] = now + LATE_S
            self._wary_until = now + WARY_S

    def _lose(self, data: bytes, question: Question) -> None:
        now = self._clock()
        if not data:
            self.counts.timeouts += 1
            self.trouble, self.lost = "does not answer", "silent"
        elif not self._judge(data, question):
            self.counts.corrupt += 1
            self.trouble, self.lost = "answers garbled", "garbled"
        self._late[question.head] = now + LATE_S
        self._wary_until = now + WARY_S

    def _judge(self, data: bytes, question: Question) -> bool:
        """Count a packet that is not the answer; return True if it explains why the answer is missing."""
        parser = StatusParser()
        explained = False
        for status in parser.feed(data):
            if status.id == question.servo and len(status.params) + packet.OVERHEAD_BYTES != question.size:
                self.refused = status.error
                named = ", ".join(self.error_names(status.error))
                self.trouble, self.lost = f"refuses: {named or 'answers too short'}", "refused"
                explained = True
            else:
                self.counts.strays += 1
                self.strays[status.id] += 1
        self.counts.babble += parser.noise + parser.held_bytes
        return explained

    def _settle(self, question: Question) -> None:
        """After a lost answer, discard late input, and wait until none can be taken for the next answer."""
        listen_until = self._late.pop(question.head, 0.0)
        late = b""
        while (now := self._clock()) < listen_until and not self._urgent():
            late += self._line.read(min(LISTEN_SLICE_S, listen_until - now))
        if now >= self._wary_until:
            self._wary_until = 0.0
            self._late.clear()
        else:
            late += self._line.read(0.0)
        self._came_late(late)

    def _came_late(self, data: bytes) -> None:
        """Count late input: whole packets are answers delayed by a busy machine, other bytes are babble."""
        if data:
            parser = StatusParser()
            self.counts.strays += len(parser.feed(data))
            self.counts.babble += parser.noise + parser.held_bytes


def status_of(answer: bytes | None) -> Status | None:
    """Return a whole packet as a Status, None as None."""
    return None if answer is None else Status(answer[2], answer[4], answer[5:-1])
