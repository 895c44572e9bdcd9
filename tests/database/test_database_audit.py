"""The audit trail takes entries at its end, and tells when anything in it was changed or taken out."""

import sqlite3

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database import audit
from lbr.database.rows import AuditRow
from lbr.database.store import Database
from tests.support import databases

TRIGGERS = ("audit_insert", "audit_update", "audit_delete")


def entry(text: str = "t") -> AuditRow:
    return AuditRow(wall_ns=1, kind="estop", subject="executive", source="lbr/executive", text=text)


def write(database: Database, *texts: str) -> None:
    database.append_events((), [entry(text) for text in texts])


@pytest.fixture
def free(client: sqlite3.Connection) -> sqlite3.Connection:
    """A client of somebody who has switched the trail's guards off."""
    for trigger in TRIGGERS:
        client.execute(f"DROP TRIGGER {trigger}")
    return client


def test_entries_are_chained_and_told_oldest_first(database):
    write(database, "one", "two")
    write(database, "three")
    entries = database.audit()
    assert [(e.id, e.text) for e in entries] == [(1, "one"), (2, "two"), (3, "three")]
    assert [e.previous for e in entries] == ["", entries[0].hash, entries[1].hash]
    assert database.audit(1) == entries[-1:]
    assert database.audit_fault() == ""


def test_words_of_strangers_forge_no_line_and_reach_no_terminal(database):
    told = AuditRow(
        wall_ns=1, kind="estop\r", subject="web\x00", source="a\u202eb", text="\x1b[2J\x9b\n2026-01-01 x\u2028y"
    )
    database.append_events((), [told])
    (found,) = database.audit()
    assert (found.kind, found.subject, found.source) == ("estop ", "web ", "a b")
    assert found.text == " [2J  2026-01-01 x y"
    assert database.audit_fault() == ""


@given(texts=st.lists(st.text(st.characters(codec=None)), max_size=5))
def test_any_text_is_written_and_verified(tmp_path_factory, texts):
    path = databases.fresh(tmp_path_factory.mktemp("audit") / "robot.db")
    with Database.open(path) as database:
        write(database, *texts)
        assert database.audit_fault() == ""
        assert len(database.audit()) == len(texts)


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE audit SET text = 'nothing happened'",
        "DELETE FROM audit",
        "DELETE FROM audit WHERE id = 2",
        "INSERT INTO audit (wall_ns, kind, subject, source, text, previous, hash) VALUES (1, 'k', '', '', '', 'x', 'y')",
    ],
)
def test_a_client_cannot_change_the_trail(database, client, statement):
    write(database, "one", "two")
    with pytest.raises(sqlite3.IntegrityError, match="the audit trail"):
        client.execute(statement)
    assert database.audit_fault() == ""


@pytest.mark.parametrize(
    "tampering",
    [
        "UPDATE audit SET text = 'nothing' WHERE id = 2",
        "UPDATE audit SET wall_ns = 5 WHERE id = 3",
        "UPDATE audit SET id = 9 WHERE id = 4",
        "DELETE FROM audit WHERE id = 2",
        "DELETE FROM audit WHERE id = 4",
        "DELETE FROM audit",
        "DELETE FROM audit WHERE id = 1",
        "UPDATE audit SET previous = '' WHERE id = 3",
    ],
)
def test_tampering_is_found(database, free, tampering, wording):
    write(database, "one", "two", "three", "four")
    free.execute(tampering)
    wording(database.audit_fault())


def test_an_end_that_was_cut_off_is_found_after_more_was_written(database, free):
    write(database, "one", "two")
    free.execute("DELETE FROM audit WHERE id = 2")
    write(database, "three")
    assert "after 1 rows are missing" in database.audit_fault()


def test_only_the_newest_are_kept_and_the_chain_begins_with_the_first_of_them(database, monkeypatch, client):
    assert (
        f"- {audit.KEPT}" in client.execute("SELECT sql FROM sqlite_schema WHERE name = 'audit_delete'").fetchone()[0]
    )
    client.execute("DROP TRIGGER audit_delete")
    monkeypatch.setattr(audit, "KEPT", 10)
    for number in range(5):
        write(database, *(f"{number}.{n}" for n in range(4)))
    assert [e.id for e in database.audit()] == list(range(11, 21))
    assert database.audit_fault() == ""


def test_two_programs_write_one_chain(database, path):
    with Database.open(path) as other:
        for n in range(5):
            write(database, f"a{n}")
            write(other, f"b{n}")
    assert len(database.audit()) == 10
    assert database.audit_fault() == ""


def test_a_rolled_back_entry_leaves_no_gap(database, client):
    write(database, "one")
    client.execute("BEGIN IMMEDIATE")
    client.execute(
        "INSERT INTO audit (wall_ns, kind, subject, source, text, previous, hash) SELECT 1, 'k', '', '', '', hash, 'x'"
        " FROM audit"
    )
    client.execute("ROLLBACK")
    write(database, "two")
    assert [e.id for e in database.audit()] == [1, 2]
    assert database.audit_fault() == ""
