"""Events that another writer keeps from the database: written later, and a trouble only if that lasts."""

import sqlite3
from contextlib import closing
from types import SimpleNamespace

import pytest

from lbr.database import store
from lbr.database.store import Database
from lbr.executive.service import journal
from lbr.executive.service.journal import AGAIN_AFTER_S, NOT_WRITTEN, TROUBLE_AFTER_S, Journal
from tests.support.robot import prepare


@pytest.fixture
def clock(monkeypatch):
    stepped = SimpleNamespace(now=100.0, monotonic=lambda: stepped.now, time_ns=lambda: round(stepped.now * 1e9))
    monkeypatch.setattr(journal, "time", stepped)
    monkeypatch.setattr(store, "PATIENCE_S", 0.001)
    return stepped


@pytest.fixture
def database(tmp_path):
    with Database.open(prepare(tmp_path / "home") / "robot.db") as opened:
        yield opened


@pytest.fixture
def kept(clock, monkeypatch, database):
    published = SimpleNamespace(put=lambda _event: b"")
    monkeypatch.setattr(journal.wire, "Publisher", lambda *_: published)
    monkeypatch.setattr(journal.wire, "Subscription", lambda *_, **__: SimpleNamespace(take=lambda: ()))
    return Journal(None, "lbr", database, lambda: None, lambda _events: None)


@pytest.fixture
def other(database):
    with closing(sqlite3.connect(database.path, isolation_level=None)) as connection:
        connection.execute("BEGIN IMMEDIATE")
        yield connection


def test_a_writer_that_is_there_for_a_moment_is_no_trouble_and_no_event_is_lost(clock, database, kept, other):
    kept.happened("ready", "drive", "it is ready")
    kept.step(clock.now)
    other.execute("ROLLBACK")
    clock.now += AGAIN_AFTER_S
    kept.step(clock.now)
    assert kept.troubles == {}
    assert [(event.kind, event.subject) for event in database.events()] == [("ready", "drive")]


def test_a_writer_that_stays_is_a_trouble_until_it_goes(clock, database, kept, other):
    kept.happened("ready", "drive", "it is ready")
    kept.step(clock.now)
    clock.now += max(AGAIN_AFTER_S, TROUBLE_AFTER_S)
    kept.step(clock.now)
    assert list(kept.troubles) == [NOT_WRITTEN]
    other.execute("ROLLBACK")
    clock.now += AGAIN_AFTER_S
    kept.step(clock.now)
    assert kept.troubles == {}
    assert {event.kind for event in database.events()} >= {"ready", "trouble"}
