"""Commands as a capability sees them: decoded, with their sender, and answered exactly once."""

from collections.abc import Callable
from math import nan
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from lbr.bus import stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.transport import Question
from lbr.capability.kind import STOP
from lbr.capability.overtaken import Overtaken
from lbr.errors import MalformedError
from lbr.messages.codes import Code, Reason
from lbr.messages.leases import CommandReply, refused

UNSTAMPED = "a bus client"


class BusCall:
    """A command from the bus, a query or a `put`.

    `refused(source, reply)` also receives refusals, and `answered` every answer. `away`: the robot runs on another
    machine than this process, so its messages come from there. `overtaken` knows the earlier stops.
    """

    def __init__(
        self,
        name: str,
        message: object,
        request: wire.Request,
        owner: str,
        refused: Callable[[str, CommandReply], None],
        *,
        away: bool = False,
        overtaken: Overtaken | None = None,
        answered: Callable[["BusCall", Struct], None] | None = None,
    ) -> None:
        sent = stamp.read(request.attachment)
        self.name = name
        self.message = message
        self.source = sent.source[:80] if sent is not None and sent.source else UNSTAMPED
        self.arrived = stamp.sent_s(sent, request.arrived)
        if overtaken is not None and name == STOP:
            overtaken.stopped(sent, self.arrived)
        elif overtaken is not None:
            self.arrived = overtaken.dated(sent, self.arrived)
        boot = sent.boot if sent is not None else ""
        self.remote = (sent is not None and bool(sent.via)) or (away and boot != stamp.boot_id())
        self.sender_s = sent.mono_ns / 1e9 if sent is not None and sent.boot else nan
        self.waited_s = sent.waited_s if sent is not None else 0.0
        self.by = sent.by[:80] if sent is not None and not self.remote else ""
        self.answerable = request.answerable
        self.payload = request.payload
        self.open = True
        self._request = request
        self._owner = owner
        self._refused = refused
        self._answered = answered

    @property
    def origin(self) -> stamp.Origin:
        """Return the original sender, and when the command was typed or written."""
        return stamp.Origin(self.by or self.source, self.arrived - self.waited_s)

    def reply(self, answer: Struct, *, quiet: bool = False) -> None:
        """Answer, once. A refusal is also an event, unless it is `quiet` and the sender waits for the answer."""
        self.open = False
        if getattr(answer, "accepted", True) is False and not getattr(answer, "code", "refused"):
            answer = replace(answer, code="refused")
        if isinstance(answer, CommandReply) and not answer.accepted and not (quiet and self._request.answerable):
            self._refused(self.source, answer)
        self._request.reply(answer, self._owner)
        answered, self._answered = self._answered, None
        if answered is not None:
            answered(self, answer)

    def refuse(self, reason: str | Reason, code: Code = "refused") -> None:
        """Refuse the command, with the reason."""
        self.reply(refused(reason if isinstance(reason, Reason) else Reason(code, reason)))


class Answers:
    """A question to several capabilities; complete once all have answered or their time is over."""

    def __init__(self, questions: dict[str, Question], decoder: Decoder[object]) -> None:
        self._questions = questions
        self._decoder = decoder

    def answers(self) -> dict[str, Any] | None:
        """Return each capability's answer (None for one that gave none), or None while waiting."""
        if not all(question.done for question in self._questions.values()):
            return None
        return {name: self._decode(question) for name, question in self._questions.items()}

    def _decode(self, question: Question) -> object:
        try:
            return self._decoder.decode(question.replies[0].payload) if question.replies else None
        except MalformedError:
            return None
