"""The device bytes and commands of a recording with lines, and the answers for emulated devices. Pure.

A line is treated as questions and answers. Bytes received within `ANSWER_NS` of a question answer it, unless another
question came between. Other received bytes have only their time.
"""

import bisect
from collections.abc import Iterable
from typing import NamedTuple

from msgspec import Struct

from lbr.apps.recorder.recording.chunks import Message
from lbr.apps.recorder.recording.decoding import read_or_none
from lbr.messages.taped import LineBytes, Taped, TapedCommand

TAPED = "@taped/"
ANSWER_NS = 100_000_000
SHORTEST = 3
"""The common first bytes, up to a servo's number or command, for which questions count as similar."""
SURE = 3
"""The first bytes that mark the beginning of a known question within others."""
LATE_NS = 150_000_000
"""The time by which a single question may come earlier or later than recorded.

A question that was sent only once may change the answers after it.
"""
OFTEN_NS = 50_000_000


class Answer(NamedTuple):
    """Received bytes, and their delay after the question."""

    after_ns: int
    data: bytes


class Exchange(NamedTuple):
    """The bytes of one question, its time, and its answers."""

    at_ns: int
    sent: bytes
    answers: tuple[Answer, ...]


class Command(Struct, frozen=True, kw_only=True):
    """A recorded command: receiver, sender, the times of command and answer, and both contents."""

    at_ns: int
    answered_ns: int
    to: str
    name: str
    source: str
    payload: bytes
    reply: dict[str, object]
    answerable: bool


class RecordedLine:
    """The recorded line of a device; times are the recording's."""

    def __init__(self, device: str, pieces: Iterable[LineBytes], lost: int = 0) -> None:
        self.device = device
        self.lost = lost
        self.exchanges: list[Exchange] = []
        self.unasked: list[tuple[int, bytes]] = []
        self._by_question: dict[bytes, list[Exchange]] = {}
        self._last: dict[bytes, int] = {}
        self._passed = 0
        self._at_ns = 0
        self._take(pieces)
        self._single = sorted((all_[0].at_ns, sent) for sent, all_ in self._by_question.items() if len(all_) == 1)
        self._once = {sent for _, sent in self._single}
        self.longest = max((len(one) for one in self._by_question), default=0)

    def known(self, sent: bytes) -> bool:
        """Return whether exactly these bytes were sent."""
        return sent in self._by_question

    def question(self, data: bytes) -> tuple[bytes, bool]:
        """Return the first question in these bytes, and whether its end may be still to come.

        A question sent in two pieces may arrive as one; an unknown question ends where a known one begins.
        """
        if data in self._by_question:
            return data, False
        if first := self._first(data):
            return first, False
        if any(one.startswith(data) for one in self._by_question):
            return data, True
        for end in range(1, len(data) - SURE + 1):
            if len(self._first(data[end:])) >= SURE:
                return data[:end], False
        return data, False

    def _next(self, sent: bytes, at_ns: int) -> Exchange:
        """Return the recorded exchange nearest to a time, between the same single questions.

        A driver that asks often, but at other moments than recorded, receives each answer once, in sequence.
        """
        exchanges = self._by_question[sent]
        begin_ns, end_ns = self._between(sent, at_ns)
        first = bisect.bisect_left(exchanges, begin_ns, key=lambda exchange: exchange.at_ns)
        last = bisect.bisect_right(exchanges, end_ns, key=lambda exchange: exchange.at_ns)
        if first >= last:
            first, last = (first if first < len(exchanges) else 0), len(exchanges)
        at = min(max(bisect.bisect_left(exchanges, at_ns, key=lambda exchange: exchange.at_ns), first), last)
        near = min(range(max(first, at - 1), min(last, at + 1)), key=lambda index: abs(exchanges[index].at_ns - at_ns))
        following = self._last.get(sent, -2) + 1
        if (
            first <= following < last
            and abs(following - near) == 1
            and abs(exchanges[following].at_ns - exchanges[near].at_ns) < OFTEN_NS
        ):
            near = following
        self._last[sent] = near
        return exchanges[near]

    def _between(self, sent: bytes, at_ns: int) -> tuple[int, int]:
        """Return the time span of valid answers: from the last single question asked to the next one.

        A single question that is late by more than `LATE_NS` counts as asked.
        """
        if at_ns < self._at_ns:
            self._passed = 0  # the clock was set back
        self._at_ns = at_ns
        if sent in self._once:
            first = bisect.bisect_left(self._single, (at_ns - LATE_NS, b""))
            last = bisect.bisect_right(self._single, (at_ns + LATE_NS, b""))
            same = [one for one in range(first, last) if self._single[one][1] == sent]
            if same:
                here = min(same, key=lambda one: abs(self._single[one][0] - at_ns))
                self._passed = max(self._passed, here + 1)
        while self._passed < len(self._single) and self._single[self._passed][0] < at_ns - LATE_NS:
            self._passed += 1
        begin_ns = self._single[self._passed - 1][0] if self._passed else 0
        end_ns = self._single[self._passed][0] if self._passed < len(self._single) else 1 << 63
        return begin_ns, end_ns

    def _first(self, data: bytes) -> bytes:
        for length in range(min(len(data), self.longest), 0, -1):
            if data[:length] in self._by_question:
                return data[:length]
        return b""

    def answers(self, sent: bytes, at_ns: int) -> tuple[Answer, ...]:
        """Return the recorded answers to a question at about that time; an unknown question gets a similar one's."""
        if sent in self._by_question:
            return self._next(sent, at_ns).answers
        alike = max(self._by_question, key=lambda one: (_common(one, sent), -abs(len(one) - len(sent))), default=b"")
        if _common(alike, sent) < SHORTEST:
            return ()
        return self._next(alike, at_ns).answers

    def came(self, after_ns: int, until_ns: int) -> list[bytes]:
        """Return the unasked bytes of a time span."""
        first = bisect.bisect_right(self.unasked, after_ns, key=lambda one: one[0])
        last = bisect.bisect_right(self.unasked, until_ns, key=lambda one: one[0])
        return [data for _, data in self.unasked[first:last]]

    def next_ns(self, after_ns: int) -> int | None:
        """Return the time of the next unasked bytes."""
        at = bisect.bisect_right(self.unasked, after_ns, key=lambda one: one[0])
        return self.unasked[at][0] if at < len(self.unasked) else None

    def _take(self, pieces: Iterable[LineBytes]) -> None:
        sent: LineBytes | None = None
        answers: list[Answer] = []
        now_ns = 0
        for piece in pieces:
            now_ns = max(now_ns, piece.at_ns)  # messages with pieces may be dated slightly out of order
            if piece.sent:
                self._close(sent, answers)
                sent, answers = LineBytes(now_ns, piece.sent, piece.data), []
            elif sent is not None and now_ns - sent.at_ns <= ANSWER_NS:
                answers.append(Answer(now_ns - sent.at_ns, piece.data))
            else:
                self.unasked.append((now_ns, piece.data))
        self._close(sent, answers)

    def _close(self, sent: LineBytes | None, answers: list[Answer]) -> None:
        if sent is not None:
            exchange = Exchange(sent.at_ns, sent.data, tuple(answers))
            self.exchanges.append(exchange)
            self._by_question.setdefault(sent.data, []).append(exchange)


class RecordedLines(Struct, kw_only=True):
    """The contents of a recording with lines: lines by device, and commands in order."""

    lines: dict[str, RecordedLine] = {}
    commands: tuple[Command, ...] = ()


def recorded_lines(messages: Iterable[Message]) -> RecordedLines:
    """Return the lines and commands in the messages of a recording; malformed messages are skipped."""
    pieces: dict[str, list[LineBytes]] = {}
    lost: dict[str, int] = {}
    commands = []
    for message in messages:
        if not message.topic.startswith(TAPED) or (taped := message.read(Taped)) is None:
            continue
        later_ns = message.log_ns - taped.now_ns
        for line in taped.lines:
            own = pieces.setdefault(line.device, [])
            own += [LineBytes(piece.at_ns + later_ns, piece.sent, piece.data) for piece in line.pieces]
            lost[line.device] = lost.get(line.device, 0) + line.lost
        commands += [
            command
            for each in taped.commands
            if (command := _command(message.topic.removeprefix(TAPED), each, later_ns)) is not None
        ]
    return RecordedLines(
        lines={device: RecordedLine(device, exchanged, lost[device]) for device, exchanged in pieces.items()},
        commands=tuple(sorted(commands, key=lambda command: command.at_ns)),
    )


def is_opening(message: Message) -> bool:
    """Return whether a message holds the opening of a line, from before the recording."""
    return any(line.opening for line in found.lines) if (found := message.read(Taped)) is not None else False


def _command(to: str, taped: TapedCommand, later_ns: int) -> Command | None:
    reply = read_or_none(taped.reply, dict[str, object])
    if reply is None:
        return None
    return Command(
        at_ns=taped.at_ns + later_ns,
        answered_ns=taped.answered_ns + later_ns,
        to=to,
        name=taped.name,
        source=taped.source,
        payload=taped.payload,
        reply=reply,
        answerable=taped.answerable,
    )


def _common(first: bytes, second: bytes) -> int:
    """Return the length of the common prefix."""
    shorter = min(len(first), len(second))
    return next((at for at in range(shorter) if first[at] != second[at]), shorter)
