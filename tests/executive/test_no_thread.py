"""A machine that gives no more threads is told of in one sentence at the start, and does not end a robot that runs."""

import os
import threading
from types import SimpleNamespace

import pytest

from lbr.bus import keys, stamp, wire
from lbr.database.store import Database
from lbr.errors import LbrError
from lbr.executive import start
from lbr.executive.planning.kinds import KindLoader
from lbr.executive.planning.last_good_copy import AGAIN_AFTER_S, LastGoodCopy
from lbr.executive.service.edits import Edits
from lbr.executive.service.pages import Pages
from lbr.executive.service.row_service import RowService
from lbr.executive.threads import NO_THREAD
from lbr.messages.faces import Motor
from tests.support import databases
from tests.support.waiting import until


class Asked(wire.Request):
    """A question whose answers are seen."""

    def __init__(self, payload: bytes, source: str = "") -> None:
        super().__init__("", payload, stamp.make(source, 0), None)
        self.replies = []

    def reply(self, message, source):
        self.replies.append(message)


@pytest.fixture
def no_thread(monkeypatch):
    """Let no thread begin from now on; what it returns lets them again."""

    def refuse(_thread):
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", refuse)
        yield patched.undo


def test_a_thread_that_cannot_be_started_is_one_sentence_with_its_cure(tmp_path, monkeypatch):
    def no_thread(*_values, **_named):
        raise RuntimeError("can't start new thread")

    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    tmp_path.chmod(0o700)
    monkeypatch.setattr(start.executive, "run", no_thread)
    for module, name in ((start.scheduling, "rank"), (start.machine, "raise_limits"), (os, "umask")):
        monkeypatch.setattr(module, name, lambda *_values: None)  # of the process of the tests
    with pytest.raises(LbrError, match="ulimit -u"):
        start.run("lbr-sim", console=False)


def test_the_last_good_rows_are_copied_once_there_is_a_thread_for_it(tmp_path, no_thread):
    databases.fresh(tmp_path / "robot.db")
    with Database.open(tmp_path / "robot.db") as opened:
        digest = opened.load("lbr").digest
    told = []
    copy = LastGoodCopy(tmp_path / "robot.db", lambda _what, why: told.append(why))
    copy.touched(0.0)
    copy.step(10.0, digest)
    copy.step(10.1, digest)
    assert told == [NO_THREAD]
    no_thread()
    copy.step(10.0 + AGAIN_AFTER_S, digest)
    until(lambda: copy.step(11.0 + AGAIN_AFTER_S, digest) or told == [NO_THREAD, ""], what="it is copied, and said so")


def test_a_kind_in_a_file_is_known_once_there_is_a_thread_to_try_it(tmp_path, no_thread):
    kinds = KindLoader(tmp_path)
    assert not kinds.ready({"mine": "new"})
    no_thread()
    until(lambda: kinds.ready({"mine": "new"}), what="it was tried")


def test_what_is_asked_by_pages_and_capabilities_is_refused_until_there_is_a_thread_for_it(tmp_path, no_thread):
    requests = {"edit": {"executive": keys.edit("lbr")}}
    unit, kind = (
        SimpleNamespace(config=SimpleNamespace(requests=requests)),
        SimpleNamespace(rights=SimpleNamespace(edits=(Motor,))),
    )
    plan = SimpleNamespace(robot="lbr", rows=SimpleNamespace(revision=7), units={"face": unit}, kinds={"face": kind})
    looked, woken = [], []
    rows = SimpleNamespace(plan=plan, held=False, soon=lambda: looked.append(True))
    edit, look = Asked(b'{"rows": {}}', "face"), Asked(b'{"ask": "tokens"}')
    waiting = {"edits": [edit], "pages": [look]}
    path, named = tmp_path / "robot.db", {"happened": lambda *_, **__: None}
    service = RowService(
        rows,
        Edits(
            SimpleNamespace(take=lambda: waiting.pop("edits", [])),
            path,
            rows,
            lambda _rows: (),
            process=lambda _name: None,
            **named,
        ),
        Pages(
            SimpleNamespace(take=lambda: waiting.pop("pages", [])),
            path,
            plan=lambda: plan,
            make=lambda _rows: (None, ()),
            **named,
        ),
        wake=lambda: woken.append(True),
    )
    for _ in range(3):
        service.step(0.0)
    assert [(one.code, one.reason) for asked in (edit, look) for one in asked.replies] == [("busy", NO_THREAD)] * 2
    assert len(woken) == 2
    assert not rows.held
    assert not looked
