"""`lbr record` against a box that is only its answers: what it began, it ends."""

import contextlib
import errno
import signal

import click
import pytest

from lbr import cli
from lbr.apps.recorder.commands import record
from lbr.apps.recorder.messages import BoxReply
from lbr.bus import latest
from lbr.console import target


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def number(request):
    """A signal that ends it."""
    return request.param


@pytest.fixture
def asked(monkeypatch, number):
    """Collect what is asked of the box; the signal comes while the first question is answered."""
    questions = []

    def ask(_bus, _found, command, _message):
        if not questions:
            signal.raise_signal(number)
        questions.append(command)
        return BoxReply(accepted=True, reason="records", path="/walk.mcap")

    monkeypatch.setattr(target, "find", lambda *_whom: None)
    monkeypatch.setattr(target, "need", lambda *_needed: None)
    monkeypatch.setattr(target, "connected", lambda _found: contextlib.nullcontext())
    monkeypatch.setattr(record, "_box_of", lambda *_there: "box")
    monkeypatch.setattr(latest, "ask", lambda *_there, **_how: pytest.fail("it was to end at once"))
    monkeypatch.setattr(record, "_ask", ask)
    return questions


def test_what_was_begun_while_a_signal_came_is_ended(asked, number, capfd):
    before = signal.getsignal(number)
    assert cli.main(["record"]) == 0
    assert asked == ["box/record", "box/end"]
    assert signal.getsignal(number) is before
    assert capfd.readouterr().out == "records\n"


def test_what_was_begun_is_ended_where_nobody_is_left_to_read_what_it_says(asked, monkeypatch):
    def gone(*_text, **_how):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(click, "echo", gone)
    with pytest.raises(OSError, match="Input/output"):
        record.command.main([], standalone_mode=False)
    assert asked == ["box/record", "box/end"]


def test_ctrl_c_while_a_refusal_is_told_is_no_traceback(monkeypatch):
    def told(_text, _code):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_complain", told)
    assert cli.main(["status", "--robot"]) == cli.INTERRUPTED
