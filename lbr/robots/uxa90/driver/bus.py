"""Transactions on the line of a UXA-90: a question, and exactly the expected bytes or none. For one thread.

Answers carry neither id nor checksum: only their number of bytes, and the quiet around them, identify their servo.
Hence three rules. A question is sent only while the line is quiet. Answers count only if no surplus follows them. A
missing answer, or an unexpected byte, discards the answers before it. Then the line must be quiet until no late answer
can pass for another servo's.
"""

import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from math import inf
from random import uniform
from typing import NamedTuple

from lbr.drivers.serial_line import SerialLine
from lbr.drivers.servos.contract import Counts as LineCounts
from lbr.robots.uxa90.driver import frames, packets
from lbr.robots.uxa90.driver.frames import Frame, FrameParser
from lbr.robots.uxa90.driver.packets import ANSWER_BYTES, Answer

SLICE_S = 0.002
"""The longest wait for input while a stop waits."""
LATE_S, LATEST_S = 0.12, 1.0
"""The times for which the line must be quiet after a lost answer or unexpected bytes; the second where the first proved
too short."""
UNEVEN = 0.3
"""The random variation of that time, so that late answers do not always fall on the question to the same servo."""
CALMER = 0.98
STEPPING_ASIDE_S = 0.006
"""The time after which a waiting write gives up a missing answer."""
SERVO_S = 0.0025
"""The longest time from one answer to the next, of servos asked in one write."""
CHECK_S = 0.003
CHECK_SHARE = 1.5
"""The quiet that confirms answers: this time, or this multiple of a servo's own time."""
MUTE_MOVES = 5
"""The number of moves in a row without any answer, while questions get theirs: then moves are not answered here."""
FRAME_S = 0.25


class ServoAnswer(NamedTuple):
    """An answer, its servo, and its arrival."""

    servo: int
    answer: Answer
    at: float


@dataclass(slots=True)
class Counts(LineCounts):
    """The counts of every servo line, with the confirmed answers and the discarded ones."""

    replies: int = 0
    doubted: int = 0


@dataclass(slots=True)
class _Owed:
    """Expected bytes of unwanted answers, and the time by which they arrive."""

    until: float
    count: int


class Bus:
    """The line. A lost answer is None; a lost line is a DeviceError.

    `answers` are confirmed answers and `board_frames` received frames, for others to take. `unasked` counts unexpected
    bytes. While it waits for input it calls `stop_waits` and `write_waits`: a stop ends the wait at once, a write after
    a moment.
    """

    def __init__(
        self,
        line: SerialLine,
        reply_s: float,
        *,
        clock: Callable[[], float] = time.monotonic,
        stop_waits: Callable[[], object] = lambda: False,
        write_waits: Callable[[], object] = lambda: False,
        unsummed: Collection[int] = (),
    ) -> None:
        self.counts = Counts()
        self.answers: deque[ServoAnswer] = deque()
        self.board_frames: deque[Frame] = deque(maxlen=16)
        self.moves_answer = True
        self.cut_short = False
        self.unasked = 0
        self.written_at = self.disturbed_at = -inf
        self._line = line
        self._reply_s = reply_s
        self._clock = clock
        self._stop_waits = stop_waits
        self._write_waits = write_waits
        self._parser = FrameParser(unsummed)
        self._doubtful: list[ServoAnswer] = []
        self._quiet_at = self._came_at = self._asked_at = clock()
        self._framed_at = -inf  # until then a frame may arrive that answers one, or nothing
        self._owed: deque[_Owed] = deque()
        self._frames: list[Frame] = []
        self._slowest_s = 0.0
        self._muted = 0
        self._late_s = LATE_S
        self._lost_at = -inf

    def read(self, servos: Sequence[int]) -> list[Answer] | None:
        """Ask servos in one write; None if an answer is missing, or the line is not quiet. See `answers`."""
        if not self.quiet():
            self.cut_short = True
            return None
        return self._answers(b"".join(packets.read(servo) for servo in servos), servos)

    def write(self, moves: Sequence[tuple[int, bytes]]) -> list[Answer] | None:
        """Write a packet for each servo at once, on any line; their answers count like those to questions."""
        data, self.written_at = b"".join(packet for _, packet in moves), self._clock()
        if not self.quiet() or not self.moves_answer:
            self.say(data, len(moves))
            return None
        answers = self._answers(data, [servo for servo, _ in moves])
        if answers is not None:
            self._muted = 0
        elif not self.cut_short and self._came_at < self._asked_at:
            self._muted += 1
            self.moves_answer = self._muted < MUTE_MOVES or self.counts.replies == 0
        return answers

    def say(self, data: bytes, answers: int = 0) -> None:
        """Write bytes whose answers are unwanted: these are discarded, with all unconfirmed answers."""
        self.drain()
        self._doubt()
        self._line.send(data)
        wire_s, now = self._line.wire_s(len(data) + ANSWER_BYTES * answers), self._clock()
        if not self.moves_answer:
            self._quiet_at = max(self._quiet_at, now + wire_s + CHECK_S)
        elif answers:
            self._owed.append(_Owed(now + wire_s + SERVO_S * answers + self._reply_s, ANSWER_BYTES * answers))
        else:
            self._framed_at = now + wire_s + LATE_S

    def ask(self, question: bytes, count: int, within_s: float) -> bytes | None:
        """Ask for this many bytes that are not a position, such as a register; tried once."""
        if not self.settle(LATE_S * 4.0):
            return None
        wire_s = self._line.wire_s(len(question) + count)
        return self._exactly(question, count, within_s + wire_s, wire_s + STEPPING_ASIDE_S)

    def inquire(self, question: bytes, frame_type: int, contents: int) -> Frame | None:
        """Ask the main board and return its frame, or None."""
        if not self.settle(LATE_S * 4.0):
            return None
        self._doubt()
        self._line.send(question)
        until = self._clock() + FRAME_S + self._line.wire_s(len(question) + frames.OVERHEAD_BYTES + contents)
        self._frames.clear()
        aside = until - FRAME_S + STEPPING_ASIDE_S
        while (left_s := until - self._clock()) > 0.0 and not self._wanted(aside):
            self._take(min(left_s, SLICE_S))
            for frame in self._frames:
                if frame.type == frame_type and len(frame.contents) == contents:
                    return frame
        self._disturbed()
        return None

    def quiet(self) -> bool:
        """Return whether a question may be sent now; read the input first, and confirm answers if possible."""
        self.drain()
        return not self._owed and self._clock() >= max(self._quiet_at, self._framed_at)

    def settle(self, within_s: float) -> bool:
        """Wait until the line is quiet; give up for a stop, and after a moment for a write."""
        begun = self._clock()
        until, aside = begun + within_s, begun + STEPPING_ASIDE_S
        while not self.quiet():
            if self._clock() >= until or self._wanted(aside):
                self.cut_short = True
                return False
            self._take_surplus(SLICE_S)
        return True

    def drain(self) -> None:
        """Read unexpected input."""
        self._take_surplus(0.0)
        if self._owed and self._owed[0].until < self._clock():
            self.counts.timeouts += self._owed.popleft().count // ANSWER_BYTES
            self._disturbed()
        if self._doubtful and self._clock() - self._came_at >= self.check_s:
            self.answers += self._doubtful
            self._late_s = max(LATE_S, self._late_s * CALMER)
            self.counts.replies += len(self._doubtful)
            self._doubtful.clear()
            self._slowest_s = 0.0

    @property
    def check_s(self) -> float:
        """Return the quiet that confirms answers."""
        return min(self._reply_s, CHECK_S + CHECK_SHARE * self._slowest_s)

    @property
    def wait_s(self) -> float:
        """Return the time until a question may be sent, without further input."""
        return max(0.0, max(self._quiet_at, self._framed_at) - self._clock()) or (SLICE_S if self._owed else 0.0)

    @property
    def silent_s(self) -> float:
        """Return for how long there had been no input at the last question."""
        return self._asked_at - self._came_at

    @property
    def doubtful(self) -> bool:
        """Return whether there are answers that may still prove to be another servo's."""
        return bool(self._doubtful)

    def close(self) -> None:
        """Close the line."""
        self._line.close()

    def _answers(self, data: bytes, servos: Sequence[int]) -> list[Answer] | None:
        wire_s = self._line.wire_s(len(data) + ANSWER_BYTES * len(servos))
        more_s = wire_s + SERVO_S * (len(servos) - 1)
        came = self._exactly(data, ANSWER_BYTES * len(servos), more_s + self._reply_s, more_s + STEPPING_ASIDE_S)
        if came is None:
            return None
        answers = [Answer(came[first], came[first + 1]) for first in range(0, len(came), ANSWER_BYTES)]
        self._slowest_s = max(self._slowest_s, (self._came_at - self._asked_at - wire_s) / len(servos))
        self._doubtful += [
            ServoAnswer(servo, answer, self._came_at) for servo, answer in zip(servos, answers, strict=True)
        ]
        return answers

    def _exactly(self, data: bytes, count: int, within_s: float, aside_s: float = inf) -> bytes | None:
        """Write, and return the input if it is exactly this many bytes."""
        self.cut_short = False
        self._asked_at = self._clock()
        self._line.send(data)
        until, aside = self._asked_at + within_s, self._asked_at + aside_s
        came = b""
        while len(came) < count and (left_s := until - self._clock()) > 0.0:
            came += self._take(min(left_s, SLICE_S))
            if self._wanted(aside):
                self.cut_short = len(came) < count
                break
        if len(came) == count and not self._parser.held:
            return came
        if self.cut_short:
            self._doubt()
            self._owed.append(_Owed(until, count - len(came)))
            return None
        if len(came) < count:
            self._lost_at = self._clock()
            self.counts.timeouts += (count - len(came) + ANSWER_BYTES - 1) // ANSWER_BYTES
        self.counts.babble += len(came)
        self._disturbed()
        return None

    def _wanted(self, aside: float) -> bool:
        """Return whether a stop wants the line, or, after a moment, a write."""
        return bool(self._stop_waits()) or (self._clock() > aside and bool(self._write_waits()))

    def _take(self, wait_s: float) -> bytes:
        """Return the input that belongs to no frame."""
        data = self._line.read(wait_s)
        if not data:
            return b""
        self._came_at = self._clock()
        parsed, plain = self._parser.feed(data)
        if parsed:
            self._framed_at = min(self._framed_at, self._came_at + CHECK_S)
        self.board_frames += parsed
        self._frames += parsed
        return plain

    def _take_surplus(self, wait_s: float) -> None:
        before = self._parser.held
        plain = self._take(wait_s)
        if not plain and before and before == self._parser.held and self._clock() - self._came_at > FRAME_S:
            plain = self._parser.flush()
        surplus = len(plain)
        while surplus and self._owed:
            paid = min(surplus, self._owed[0].count)
            surplus -= paid
            self._owed[0].count -= paid
            if not self._owed[0].count:
                self._owed.popleft()
        if surplus:
            self.counts.babble += surplus
            self.unasked += 1
            if self._clock() - self._lost_at < LATEST_S:
                self._late_s = min(LATEST_S, 2.0 * self._late_s)
            self._disturbed()

    def _disturbed(self) -> None:
        self._doubt()
        self._owed.clear()
        self.disturbed_at = self._clock()
        self._quiet_at = max(self._quiet_at, self._clock() + self._late_s * uniform(1.0, 1.0 + UNEVEN))

    def _doubt(self) -> None:
        self.counts.doubted += len(self._doubtful)
        self._doubtful.clear()
        self._slowest_s = 0.0
