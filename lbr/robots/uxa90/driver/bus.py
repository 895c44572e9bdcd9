"""Transactions on the line of a UXA-90: asked, answered with exactly the bytes expected, or given up. For one thread.

Answers carry neither id nor checksum, so that the number of bytes and the quiet around them is all that says whose they
are. Hence: a question is asked only while the line is quiet; answers count only once nothing surplus followed them; one
that is missing, or bytes that were not asked for, take the answers before with them, and the line must then be quiet
for so long that none of the late ones can pass for another's.
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
"""A stop waits no longer than this while the line is listened to."""
LATE_S, LATEST_S = 0.12, 1.0
"""After an answer was lost, or bytes came unasked, the line must be quiet for this long; longer where that was too
short."""
UNEVEN = 0.3
"""That time varies so much, so that late answers do not always come while the same other servo is asked."""
CALMER = 0.98
STEPPING_ASIDE_S = 0.006
"""A waiting write lets an answer be missed that has not come by then."""
SERVO_S = 0.0025
"""Several that are asked in one write answer one after another, each this long after the one before at most."""
CHECK_S = 0.003
CHECK_SHARE = 1.5
"""Nothing surplus within this, or this many times what a servo takes: the answers before are believed."""
MUTE_MOVES = 5
"""The moves without any answer in a row, while questions get theirs: moves are not answered here."""
FRAME_S = 0.25


class Heard(NamedTuple):
    """An answer, whose it is, and when it came."""

    servo: int
    answer: Answer
    at: float


@dataclass(slots=True)
class Counts(LineCounts):
    """Those of every line of servos, and the answers that count, and that others took with them."""

    replies: int = 0
    doubted: int = 0


@dataclass(slots=True)
class _Owed:
    """Bytes of answers that are not wanted, until when they may come."""

    until: float
    count: int


class Bus:
    """The line. Lost answers are None; a line that is gone is a DeviceError.

    `heard` are answers that count, for others to take; `told` are frames that came; `unasked` counts how often bytes
    came without a question. `stop_waits`, `write_waits` are asked while listening: a stop ends that at once, a write
    after a moment.
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
        self.heard: deque[Heard] = deque()
        self.told: deque[Frame] = deque(maxlen=16)
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
        self._doubtful: list[Heard] = []
        self._quiet_at = self._came_at = self._asked_at = clock()
        self._framed_at = -inf  # until then a frame may come that answers one, or nothing
        self._owed: deque[_Owed] = deque()
        self._frames: list[Frame] = []
        self._slowest_s = 0.0
        self._muted = 0
        self._late_s = LATE_S
        self._lost_at = -inf

    def read(self, servos: Sequence[int]) -> list[Answer] | None:
        """Ask servos in one write; None: not all of them answered, or the line is not quiet. See `heard`."""
        if not self.quiet():
            self.cut_short = True
            return None
        return self._answers(b"".join(packets.read(servo) for servo in servos), servos)

    def write(self, said: Sequence[tuple[int, bytes]]) -> list[Answer] | None:
        """Write a packet for each servo at once, whatever the line does; their answers count as those to questions."""
        data, self.written_at = b"".join(packet for _, packet in said), self._clock()
        if not self.quiet() or not self.moves_answer:
            self.say(data, len(said))
            return None
        answers = self._answers(data, [servo for servo, _ in said])
        if answers is not None:
            self._muted = 0
        elif not self.cut_short and self._came_at < self._asked_at:
            self._muted += 1
            self.moves_answer = self._muted < MUTE_MOVES or self.counts.replies == 0
        return answers

    def say(self, data: bytes, answers: int = 0) -> None:
        """Write bytes whose answers are not wanted: they are thrown away, with all that is still in doubt."""
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
        """Ask for this many bytes that are no position, such as a register; tried once."""
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
        """Return whether a question may be asked now; takes in what came, and believes the answers before if it may."""
        self.drain()
        return not self._owed and self._clock() >= max(self._quiet_at, self._framed_at)

    def settle(self, within_s: float) -> bool:
        """Wait until the line is quiet, unless a stop waits, or before long a write."""
        begun = self._clock()
        until, aside = begun + within_s, begun + STEPPING_ASIDE_S
        while not self.quiet():
            if self._clock() >= until or self._wanted(aside):
                self.cut_short = True
                return False
            self._take_surplus(SLICE_S)
        return True

    def drain(self) -> None:
        """Take in what came unasked."""
        self._take_surplus(0.0)
        if self._owed and self._owed[0].until < self._clock():
            self.counts.timeouts += self._owed.popleft().count // ANSWER_BYTES
            self._disturbed()
        if self._doubtful and self._clock() - self._came_at >= self.check_s:
            self.heard += self._doubtful
            self._late_s = max(LATE_S, self._late_s * CALMER)
            self.counts.replies += len(self._doubtful)
            self._doubtful.clear()
            self._slowest_s = 0.0

    @property
    def check_s(self) -> float:
        """Return how long nothing may follow the answers before they count."""
        return min(self._reply_s, CHECK_S + CHECK_SHARE * self._slowest_s)

    @property
    def wait_s(self) -> float:
        """Return how long until a question may be asked, if nothing comes."""
        return max(0.0, max(self._quiet_at, self._framed_at) - self._clock()) or (SLICE_S if self._owed else 0.0)

    @property
    def unheard_s(self) -> float:
        """Return for how long nothing at all had come when a servo was asked last."""
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
        self._doubtful += [Heard(servo, answer, self._came_at) for servo, answer in zip(servos, answers, strict=True)]
        return answers

    def _exactly(self, data: bytes, count: int, within_s: float, aside_s: float = inf) -> bytes | None:
        """Write, and return what comes if it is this many bytes and no more."""
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
        """Return whether the line is wanted for a stop, or, from then on, for a write."""
        return bool(self._stop_waits()) or (self._clock() > aside and bool(self._write_waits()))

    def _take(self, wait_s: float) -> bytes:
        """Return the bytes that came and belong to no frame."""
        data = self._line.read(wait_s)
        if not data:
            return b""
        self._came_at = self._clock()
        found, plain = self._parser.feed(data)
        if found:
            self._framed_at = min(self._framed_at, self._came_at + CHECK_S)
        self.told += found
        self._frames += found
        return plain

    def _take_surplus(self, wait_s: float) -> None:
        before = self._parser.held
        plain = self._take(wait_s)
        if not plain and before and before == self._parser.held and self._clock() - self._came_at > FRAME_S:
            plain = self._parser.flush()
        left = len(plain)
        while left and self._owed:
            paid = min(left, self._owed[0].count)
            left -= paid
            self._owed[0].count -= paid
            if not self._owed[0].count:
                self._owed.popleft()
        if left:
            self.counts.babble += left
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
