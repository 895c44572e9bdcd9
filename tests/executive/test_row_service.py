"""The row service answers one question after the other, slow ones beside; rows that are being written are held."""

from threading import Event
from types import SimpleNamespace

import pytest

from lbr.bus import stamp, wire
from lbr.errors import InputError
from lbr.executive.service.row_service import MOST_WAITING, Job, RowService
from lbr.messages.manage import ManageReply
from tests.support.waiting import until

LIMIT_S = 5.0


class Question(wire.Request):
    """A question that is answered once `go` is set."""

    def __init__(self, name, *, slow=False, holds=False, writes=False):
        super().__init__("", b"", stamp.make(name, 0), None)
        self.name, self.slow, self.holds, self.writes = name, slow, holds, writes
        self.begun, self.go, self.replies = Event(), Event(), []

    def reply(self, message, source):
        self.replies.append(message)

    def work(self):
        self.begun.set()
        assert self.go.wait(LIMIT_S)
        if self.name == "bad":
            raise InputError("not so", "bad_value")
        return ManageReply(accepted=True, reason=self.name)


class Bench:
    """A service whose only key is asked by hand."""

    def __init__(self):
        self.written = Event()
        self.rows = SimpleNamespace(held=False, soon=self.written.set)
        self.asked = []
        self.served = SimpleNamespace(take=self._take, close=lambda: None)
        self.woken = Event()
        self.service = RowService(self.rows, self, wake=self.woken.set)

    def _take(self):
        asked, self.asked = self.asked, []
        return asked

    def read(self, question):
        if question.name == "denied":
            raise InputError("not for you", "denied")
        end = lambda reply: reply.accepted and question.writes  # noqa: E731
        return Job(question, self, question.work, end, slow=question.slow, holds=question.holds)

    def refused(self, reason, code):
        return ManageReply(accepted=False, reason=reason, code=code)

    def ask(self, *questions):
        self.asked += questions
        self.step()

    def step(self):
        """Say whether rows were written."""
        self.written.clear()
        self.service.step(0.0)
        return self.written.is_set()

    def ended(self, question):
        question.go.set()
        until(lambda: self.woken.wait(LIMIT_S))
        self.woken.clear()
        return self.step()


@pytest.fixture
def bench():
    return Bench()


def test_one_question_is_answered_after_the_other_and_a_slow_one_beside(bench):
    first, second, slow = Question("first"), Question("second"), Question("slow", slow=True)
    bench.ask(slow, first, second)
    assert slow.begun.wait(LIMIT_S)
    assert first.begun.wait(LIMIT_S)
    assert not bench.ended(first)
    assert second.begun.wait(LIMIT_S)
    bench.ended(second)
    assert [question.replies for question in (first, second, slow)] == [
        [ManageReply(accepted=True, reason="first")],
        [ManageReply(accepted=True, reason="second")],
        [],
    ]
    bench.ended(slow)
    assert slow.replies


def test_the_next_question_waits_until_what_was_written_is_in_force(bench):
    edit, after = Question("edit", holds=True, writes=True), Question("after")
    bench.ask(edit, after)
    assert bench.rows.held
    assert bench.ended(edit)
    assert not bench.rows.held
    assert not after.begun.is_set()
    assert not bench.step()
    assert after.begun.wait(LIMIT_S)
    bench.ended(after)


def test_a_refusal_has_its_code_and_too_many_questions_are_refused_as_busy(bench):
    bad = Question("bad")
    denied, *others = Question("denied"), *(Question("more") for _ in range(MOST_WAITING + 1))
    bench.ask(bad)
    bench.ask(denied, *others)
    assert [reply.code for question in (denied, others[-1]) for reply in question.replies] == ["denied", "busy"]
    assert not bench.ended(bad)
    assert [(reply.code, reply.reason) for reply in bad.replies] == [("bad_value", "not so")]
    for question in others[:-1]:
        bench.ended(question)
