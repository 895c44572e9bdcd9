"""Stand-ins of what a capability is handed, for tests without a bus: commands, questions, the emergency stop."""

from dataclasses import dataclass, field
from math import nan
from typing import Any

from lbr.messages.codes import MEANINGS
from tests.support.replies import refusal


@dataclass
class FakeEstop:
    engaged: bool = False
    reason: str = ""
    acknowledged: list[bool] = field(default_factory=list)

    def acknowledge(self, *, stopped: bool, reason: str = "") -> None:
        self.acknowledged.append(stopped)


@dataclass
class FakeCall:
    """A command that waits for its answer, which it takes once."""

    name: str
    message: Any
    arrived: float = 0.0
    source: str = "console"
    remote: bool = False
    sender_s: float = nan
    waited_s: float = 0.0
    answerable: bool = True
    answer: Any = None

    def reply(self, answer, *, quiet=False):
        assert self.answer is None, "answered twice"
        assert getattr(answer, "accepted", True) or answer.code in MEANINGS, "a refusal has a code of the list"
        self.answer = answer

    def refuse(self, reason, code="refused"):
        self.reply(refusal(reason, code))


@dataclass
class FakeAsked:
    """A question that has been answered so, or waits for it."""

    message: Any = None
    given: Any = None

    def answers(self):
        return self.given
