"""`lbr record` against a box that is only its answers: what it began, it ends."""

import contextlib
import os
import signal

import pytest

from lbr import cli
from lbr.commands import record
from lbr.console import target
from lbr.messages.box import BoxReply


@pytest.fixture
def asked(monkeypatch):
    """Collect what is asked of the box; Ctrl-C is pressed while the first question is answered."""
    questions = []

    def ask(_bus, _found, command, _message):
        if not questions:
            os.kill(os.getpid(), signal.SIGINT)
        questions.append(command)
        return BoxReply(accepted=True, reason="records", path="/walk.mcap")

    monkeypatch.setattr(target, "find", lambda *_whom: None)
    monkeypatch.setattr(target, "need", lambda *_needed: None)
    monkeypatch.setattr(target, "connected", lambda _found: contextlib.nullcontext())
    monkeypatch.setattr(record, "_box_of", lambda *_there: "box")
    monkeypatch.setattr(record, "_wait", lambda *_there: pytest.fail("it was to end at once"))
    monkeypatch.setattr(record, "_ask", ask)
    return questions


def test_what_was_begun_while_ctrl_c_was_pressed_is_ended(asked, capfd):
    before = signal.getsignal(signal.SIGINT)
    assert cli.main(["record"]) == 0
    assert asked == ["box/record", "box/end"]
    assert signal.getsignal(signal.SIGINT) is before
    assert capfd.readouterr().out == "records\n"


def test_ctrl_c_while_a_refusal_is_told_is_no_traceback(monkeypatch):
    def told(_text, _code):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_complain", told)
    assert cli.main(["status", "--robot"]) == cli.INTERRUPTED
