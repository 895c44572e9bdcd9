"""What happened and what was changed, asked for by part, level and row; on a real file."""

import sqlite3

from lbr.database import edits
from lbr.database.store import Database
from lbr.messages.speech import Phrase
from lbr.messages.system import Event


def test_events_are_told_of_one_subject_and_from_a_level_on(database: Database):
    told = [("drive", "info"), ("drive", "error"), ("motors", "warning"), ("drive", "info")]
    database.append_events([Event(kind="k", subject=subject, text=f"{n}", level=level) for n, (subject, level) in enumerate(told)])  # fmt: skip
    assert [one.text for one in database.events(10)] == ["0", "1", "2", "3"]
    assert [one.text for one in database.events(2, subject="drive")] == ["1", "3"]
    assert [one.text for one in database.events(10, levels=("warning", "error"))] == ["1", "2"]
    assert database.events(10, subject="drive' OR 1 --") == ()


def test_the_newest_change_of_a_row_is_found_also_of_one_that_is_gone(database: Database, client: sqlite3.Connection):
    assert database.last_change("lbr", "device", ("nonsense",)) is None
    client.execute("UPDATE device SET address = '/dev/x' WHERE robot = 'lbr' AND name = 'speaker'")
    (changed,) = database.revisions()
    assert database.last_change("lbr", "device", ("speaker",)) == (changed.changed_at, "")
    client.execute("DELETE FROM device WHERE robot = 'lbr' AND name = 'speaker'")
    gone = database.revisions()[-1]
    assert database.last_change("lbr", "device", ("speaker",)) == (gone.changed_at, "")
    assert database.last_change("another", "device", ("speaker",)) is None
    hello = Phrase(name="hello", language="en", text="Hi.")
    edits.write_rows(database, "lbr", [hello], lambda _rows: (), create=None, by="web for a phone")
    newest = database.revisions()[-1]
    assert database.last_change("lbr", "phrase", ("hello", "en")) == (newest.changed_at, "web for a phone")
    with Database.open(database.path, program="another") as other:
        assert other.last_change("lbr", "phrase", ("hello", "en")) == (newest.changed_at, "")
