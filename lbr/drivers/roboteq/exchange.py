"""One command on the line at a time, and the answer that belongs to it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from lbr.drivers.byte_line import ByteLine
from lbr.drivers.echoed_lines import Ack, Echo, Nak, Reply, ReplyParser, Value

Result = Literal["acknowledged", "value", "refused", "lost"]


class Line(ByteLine, Protocol):
    """The bytes to and from the controller."""

    def fileno(self) -> int:
        """Return its descriptor."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of an exchange."""

    command: bytes
    result: Result
    value: Value | None = None


class Exchange:
    """Sends a command and finds its answer, whether the controller echoes or not.

    Answers carry no number. With the echo on, an answer counts only after the echo of its own command. Without it, a
    late answer to a command given up as lost is never mistaken for the answer to the next.
    """

    def __init__(self, line: Line, clock: Callable[[], float]) -> None:
        self.babble_bytes = 0  # since the last valid answer
        self._line = line
        self._clock = clock
        self._parser = ReplyParser()
        self._echoes: bool | None = None
        self._owed = 0
        self._command = b""
        self._deadline = 0.0
        self._echoed = False

    @property
    def busy(self) -> bool:
        """Return whether an answer is due."""
        return bool(self._command)

    def learn_echo(self) -> None:
        """Find out by the next answered value whether the controller echoes."""
        self._echoes = None

    def send(self, command: bytes, timeout_s: float) -> None:
        """Write a command whose answer is lost after `timeout_s`; no other may be in progress."""
        assert not self.busy
        self._command = command
        self._echoed = False
        self._deadline = self._clock() + timeout_s
        self._line.write(command)  # a command that did not fit is answered with `-` or not at all

    def wait(self, budget_s: float) -> Outcome | None:
        """Return the outcome, waiting `budget_s` at most; None while the answer is still due.

        Input without a pause does not extend the wait.
        """
        until = self._clock() + budget_s
        while self.busy:
            now = self._clock()
            data = self._line.read(min(until, self._deadline) - now)
            self.babble_bytes += len(data)
            if (outcome := self._take(self._parser.feed(data))) is not None:
                return outcome
            if not now < self._deadline:
                return self._lose()
            if not now < until:
                break
        return None

    def finish(self, budget_s: float) -> Outcome:
        """Return the outcome of the exchange in progress; it is lost if not answered within `budget_s`."""
        assert self.busy
        return self.wait(budget_s) or self._lose()

    def _take(self, replies: list[Reply]) -> Outcome | None:
        found = [outcome for reply in replies if (outcome := self._match(reply)) is not None]
        return found[0] if found else None

    def _match(self, reply: Reply) -> Outcome | None:
        if not self.busy:
            return None
        match reply:
            case Echo(command):
                self._echoed = self._echoed or command == self._command.rstrip(b"\r")
            case Value(name):
                if self._is_query() and name == self._name():
                    return self._answered(reply)
            case Ack() | Nak():
                return self._signed(reply)
        return None

    def _answered(self, value: Value) -> Outcome:
        """End the exchange with a value; answers keep their order, so none older can follow."""
        if self._echoes is None:
            self._echoes = self._echoed
        self._owed = 0
        return self._end("value", value)

    def _signed(self, reply: Ack | Nak) -> Outcome | None:
        if not self._echoed:
            if self._echoes:
                return None
            if self._owed:
                self._owed -= 1
                return None
        if isinstance(reply, Nak):
            return self._end("refused")
        return None if self._is_query() else self._end("acknowledged")

    def _lose(self) -> Outcome:
        self._owed += not self._is_query()
        return self._end("lost")

    def _end(self, result: Result, value: Value | None = None) -> Outcome:
        if result != "lost":
            self.babble_bytes = 0
        outcome = Outcome(self._command, result, value)
        self._command = b""
        return outcome

    def _is_query(self) -> bool:
        return self._command[:1] in {b"?", b"~"}

    def _name(self) -> str:
        return self._command[1:].split()[0].decode("ascii")
