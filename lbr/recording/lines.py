"""What a recording with lines has of a robot's devices and commands, and what a device would answer by it. Pure.

A line is taken for questions and answers: what came within `ANSWER_NS` of what was sent answers it, unless more was sent
since. What came without a question has its time alone.
"""

import bisect
from collections.abc import Iterable
from typing import Any, NamedTuple

import msgspec
from msgspec import Struct

from lbr.messages.taped import LineBytes, Taped, TapedCommand
from lbr.recording.chunks import Message

TAPED = "@taped/"
ANSWER_NS = 100_000_000
SHORTEST = 2
"""Bytes that a question has at least in common with the one whose answer it gets."""
_taped = msgspec.json.Decoder(Taped)


class Answer(NamedTuple):
    """Bytes that came so long after what was sent."""

    after_ns: int
    data: bytes


class Exchange(NamedTuple):
    """What was sent at once, when, and what came back."""

    at_ns: int
    sent: bytes
    answers: tuple[Answer, ...]


class Command(Struct, frozen=True, kw_only=True):
    """A command of the recording: to whom, from whom, when it came, its message and its answer."""

    at_ns: int
    to: str
    name: str
    source: str
    message: dict[str, Any]
    reply: dict[str, Any]
    answerable: bool


class RecordedLine:
    """A device's line of a recording; times are the recording's."""

    def __init__(self, device: str, pieces: Iterable[LineBytes], lost: int = 0) -> None:
        self.device = device
        self.lost = lost
        self.exchanges: list[Exchange] = []
        self.unasked: list[tuple[int, bytes]] = []
        self._by_question: dict[bytes, list[Exchange]] = {}
        self._take(pieces)
        self.longest = max((len(one) for one in self._by_question), default=0)

    def known(self, sent: bytes) -> bool:
        """Say whether exactly this was sent."""
        return sent in self._by_question

    def begins(self, sent: bytes) -> bool:
        """Say whether these bytes are the beginning of what was sent."""
        return any(one.startswith(sent) for one in self._by_question)

    def first(self, data: bytes) -> bytes:
        """Return the longest question that was sent with which these bytes begin; empty: none."""
        for length in range(min(len(data), self.longest), 0, -1):
            if data[:length] in self._by_question:
                return data[:length]
        return b""

    def answers(self, sent: bytes, at_ns: int) -> tuple[Answer, ...]:
        """Return what was answered to this at about that time; to what was never sent, what its like was answered."""
        found = self._by_question.get(sent)
        if found is not None:
            return _nearest(found, at_ns).answers
        alike = max(self._by_question, key=lambda one: (_common(one, sent), -abs(len(one) - len(sent))), default=b"")
        if _common(alike, sent) < min(SHORTEST, len(sent)):
            return ()
        return _nearest(self._by_question[alike], at_ns).answers

    def came(self, after_ns: int, until_ns: int) -> list[bytes]:
        """Return what came by itself in that time."""
        first = bisect.bisect_right(self.unasked, after_ns, key=lambda one: one[0])
        last = bisect.bisect_right(self.unasked, until_ns, key=lambda one: one[0])
        return [data for _, data in self.unasked[first:last]]

    def next_ns(self, after_ns: int) -> int | None:
        """Return when the next thing came by itself."""
        at = bisect.bisect_right(self.unasked, after_ns, key=lambda one: one[0])
        return self.unasked[at][0] if at < len(self.unasked) else None

    def _take(self, pieces: Iterable[LineBytes]) -> None:
        sent: LineBytes | None = None
        answers: list[Answer] = []
        now_ns = 0
        for one in pieces:
            now_ns = max(now_ns, one.at_ns)  # the messages that brought them may be dated a hair apart
            if one.sent:
                self._close(sent, answers)
                sent, answers = LineBytes(now_ns, one.sent, one.data), []
            elif sent is not None and now_ns - sent.at_ns <= ANSWER_NS:
                answers.append(Answer(now_ns - sent.at_ns, one.data))
            else:
                self.unasked.append((now_ns, one.data))
        self._close(sent, answers)

    def _close(self, sent: LineBytes | None, answers: list[Answer]) -> None:
        if sent is not None:
            exchange = Exchange(sent.at_ns, sent.data, tuple(answers))
            self.exchanges.append(exchange)
            self._by_question.setdefault(sent.data, []).append(exchange)


class Taken(Struct, kw_only=True):
    """All that a recording with lines has: lines by device, and commands in order."""

    lines: dict[str, RecordedLine] = {}
    commands: tuple[Command, ...] = ()


def taken(messages: Iterable[Message]) -> Taken:
    """Return what the messages of a recording have of lines and commands; what is malformed is passed over."""
    pieces: dict[str, list[LineBytes]] = {}
    lost: dict[str, int] = {}
    commands = []
    for one in messages:
        if not one.topic.startswith(TAPED) or (taped := _decoded(one)) is None:
            continue
        later_ns = one.log_ns - taped.now_ns
        for line in taped.lines:
            own = pieces.setdefault(line.device, [])
            own += [LineBytes(piece.at_ns + later_ns, piece.sent, piece.data) for piece in line.pieces]
            lost[line.device] = lost.get(line.device, 0) + line.lost
        commands += [
            found
            for each in taped.commands
            if (found := _command(one.topic.removeprefix(TAPED), each, later_ns)) is not None
        ]
    return Taken(
        lines={device: RecordedLine(device, found, lost[device]) for device, found in pieces.items()},
        commands=tuple(sorted(commands, key=lambda one: one.at_ns)),
    )


def is_opening(message: Message) -> bool:
    """Say whether a message has how lines were opened, before the recording."""
    return any(line.opening for line in found.lines) if (found := _decoded(message)) is not None else False


def _decoded(message: Message) -> Taped | None:
    try:
        return _taped.decode(message.data)
    except (msgspec.DecodeError, UnicodeDecodeError):
        return None


def _command(to: str, one: TapedCommand, later_ns: int) -> Command | None:
    try:
        message, reply = msgspec.json.decode(one.message), msgspec.json.decode(one.reply)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
    if not isinstance(message, dict) or not isinstance(reply, dict):
        return None
    return Command(
        at_ns=one.at_ns + later_ns,
        to=to,
        name=one.name,
        source=one.source,
        message=message,
        reply=reply,
        answerable=one.answerable,
    )


def _nearest(exchanges: list[Exchange], at_ns: int) -> Exchange:
    at = bisect.bisect_left(exchanges, at_ns, key=lambda one: one.at_ns)
    return min(exchanges[max(0, at - 1) : at + 1], key=lambda one: abs(one.at_ns - at_ns))


def _common(one: bytes, other: bytes) -> int:
    """Return how many bytes two have in common from their beginning."""
    for at, (left, right) in enumerate(zip(one, other, strict=False)):
        if left != right:
            return at
    return min(len(one), len(other))
