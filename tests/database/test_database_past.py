"""The rows' past: who changed them, how they were, and the way back."""

import json
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import to_builtins

from lbr.database import changes, edits, past
from lbr.database.past import ChangeRow
from lbr.database.proposals import Proposed, command
from lbr.database.reading import Problem
from lbr.database.rows import RevisionRow
from lbr.database.store import Database
from lbr.errors import InputError, RowError
from lbr.messages.speech import Phrase
from tests.support import databases
from tests.support.waiting import HANG_S

FULL = "UPDATE capability SET settings = json_set(settings, '$.max_power', ?) WHERE robot = 'lbr' AND name = 'drive'"


def back(database: Database, number: int, robot: str | None = None, **options) -> Proposed:
    return command(
        database,
        lambda tables, schema: changes.between(tables, database.tables_at(number), schema, robot),
        options.pop("wrong", lambda _rows: ()),
        text=f"went back to revision {number}",
        **options,
    )


def at(database: Database, number: int):
    return database.tables_at(number)


@pytest.fixture
def edited(database, client):
    """Revision 3: drive has less power, a wire is slower, and a phrase is new."""
    client.execute(FULL, (0.5,))
    client.execute("UPDATE channel SET rate_hz = 5 WHERE target = 'drive.motors' AND robot = 'lbr'")
    client.execute("INSERT INTO phrase VALUES ('ouch', 'en', 'Ouch.')")
    return database


def test_the_rows_of_every_revision_can_be_told(edited, client):
    now, schema = edited.tables()
    assert at(edited, 3) == now
    assert [str(one) for one in changes.differences(changes.between(at(edited, 1), at(edited, 3), schema))] == [
        "channel 'lbr/motors.state/drive.motors' changed: rate_hz: None -> 5.0",
        "phrase 'ouch/en' added",
    ]
    assert [one.table for one in changes.between(at(edited, 0), at(edited, 1), schema)] == ["capability"]


def test_going_back_is_a_change_forward_and_is_taken_back_by_going_to_where_it_was(edited):
    there = at(edited, 3)
    became = back(edited, 0)
    assert (became.before, became.revision, len(became.changes)) == (3, 6, 3)
    assert edited.tables()[0] == at(edited, 0)
    back(edited, 3)
    assert edited.tables()[0] == there


def test_what_is_as_it_was_is_not_written(edited):
    assert back(edited, 3).revision == 3
    assert edited.changes(3) == ()


def test_a_dry_run_changes_nothing(edited):
    assert len(back(edited, 0, dry_run=True).changes) == 3
    assert edited.revision() == 3


def test_rows_of_one_robot_alone_go_back(edited):
    assert [one.table for one in back(edited, 0, "lbr").changes] == ["capability", "channel"]
    assert any(row["name"] == "ouch" for row in edited.tables()[0]["phrase"])


def test_who_did_it_stands_beside_the_revisions(edited, path):
    with Database.open(path, program="lbr db rollback") as other:
        back(other, 1)
    client, ours = edited.changes()
    assert (client.first, client.last, client.program, client.text) == (1, 3, "", "another SQLite client")
    assert (ours.first, ours.last, ours.program, ours.text) == (4, 5, "lbr db rollback", "went back to revision 1")
    assert ours.source
    (entry,) = edited.audit()
    assert (entry.kind, entry.source) == ("edit", "lbr db rollback")
    assert entry.text == f"{ours.source} went back to revision 1"


def test_an_edit_on_request_is_told_with_who_asked(database):
    phrase = Phrase(name="ouch", language="en", text="Ouch.")
    edits.write_rows(database, "lbr", [phrase], lambda _rows: (), create=True, by="web for 192.168.1.2")
    (change,) = database.changes()
    assert (change.source, change.first) == ("web for 192.168.1.2", 1)


def test_who_changed_nothing_does_not_stand_beside_the_next_revision(database, client):
    phrase = Phrase(name="ouch", language="en", text="Ouch.")
    known: dict = {}
    for source in ("speech", "ears"):
        edits.learn(database, "lbr", [phrase], known, by=source)
        known = {("phrase", ("ouch", "en")): to_builtins(phrase)}
    client.execute("UPDATE phrase SET text = 'Hm.' WHERE name = 'ouch'")
    assert [(one.source, one.first, one.last) for one in database.changes()] == [("speech", 1, 1), ("", 2, 2)]


def test_rows_that_were_changed_since_they_were_looked_at_are_refused(edited):
    with pytest.raises(InputError, match="have revision 3, not 2"):
        back(edited, 0, expected=2)
    assert edited.revision() == 3


@pytest.mark.parametrize("number", [-1, 4])
def test_a_revision_that_there_is_not_is_refused(edited, number):
    with pytest.raises(InputError, match=f"no revision {number} in .*: 0 to 3"):
        at(edited, number)


def test_new_problems_are_told_and_nothing_is_changed_but_old_ones_are_in_no_way(edited):
    bad = Problem("capability", "lbr/drive", "settings", "is bad")

    def wrong(rows):
        return [bad] if rows.robot.name == "lbr" and len(rows.of(Phrase)) == phrases else []

    phrases = len(edited.load("lbr").of(Phrase)) - 1
    assert back(edited, 2, wrong=wrong).problems == (bad,)
    assert edited.revision() == 3
    assert back(edited, 2, wrong=lambda rows: [bad] if rows.robot.name == "lbr" else []).problems == ()
    assert edited.revision() == 4


def test_a_robot_that_was_taken_out_comes_back_with_all_that_went_with_it(database, client):
    before, _ = database.tables()
    client.execute("DELETE FROM robot WHERE name = 'bioloid'")
    assert len(database.tables()[0]["joint"]) < len(before["joint"])
    back(database, 0)
    assert database.tables()[0] == before


def test_a_robot_that_got_another_name_gets_the_old_one_back(database, client):
    before, _ = database.tables()
    client.execute("UPDATE robot SET name = 'other' WHERE name = 'bioloid'")
    back(database, 0)
    assert database.tables()[0] == before


def test_a_robot_whose_stop_is_latched_is_not_taken_out(database, client, wording):
    client.execute("INSERT INTO robot (name) VALUES ('new')")
    database.set_estop("new", engaged=True, reason="x")
    (problem,) = back(database, 0).problems
    wording(problem)


def test_the_emergency_stop_and_tokens_stay_as_they_are(edited):
    edited.set_estop("lbr", engaged=True, reason="pressed")
    edited.add_token(databases.token("phone", "operate", "h" * 64))
    edited.revoke_token("phone")
    back(edited, 0)
    assert edited.load("lbr").robot.estop_engaged
    assert edited.tokens()[0].revoked_at is not None


def test_a_row_that_was_changed_with_the_triggers_off_is_in_the_way(edited, client, wording):
    client.execute("DROP TRIGGER phrase_update")
    client.execute("UPDATE phrase SET text = 'Oh.' WHERE name = 'ouch'")
    with wording.of(InputError):
        back(edited, 0)
    assert edited.revision() == 3


def test_a_copy_that_was_put_in_the_place_of_all_rows_is_in_the_way(edited, wording):
    edited.outdo(10, "restored from backup")
    with wording.of(InputError):
        back(edited, 3)
    assert [(one.first, one.text) for one in edited.changes(3)] == [(11, "restored from backup")]


def test_a_column_that_came_by_an_upgrade_has_its_default(database, client):
    before, _ = database.tables()
    client.execute("DELETE FROM channel WHERE robot = 'lbr' AND target = 'drive.motors'")
    old = json.loads(client.execute("SELECT old_row FROM revision WHERE id = 1").fetchone()[0])
    assert old.pop("rate_hz") is None
    client.execute("UPDATE revision SET old_row = ? WHERE id = 1", (json.dumps(old),))
    back(database, 0)
    assert database.tables()[0] == before


def test_a_column_that_came_by_an_upgrade_stays_where_a_row_was_only_changed(edited, client):
    for column in ("old_row", "new_row"):
        values = json.loads(client.execute(f"SELECT {column} FROM revision WHERE id = 2").fetchone()[0])
        del values["enabled"]
        client.execute(f"UPDATE revision SET {column} = ? WHERE id = 2", (json.dumps(values),))
    back(edited, 1)
    rows = edited.tables()[0]["channel"]
    assert next(row for row in rows if (row["robot"], row["target"]) == ("lbr", "drive.motors"))["rate_hz"] is None


@pytest.mark.parametrize(("column", "said"), [("gone", "has taken the column 'gone' from phrase since"), ("text", "")])
def test_a_column_that_an_upgrade_took_away_is_in_the_way(edited, client, column, said):
    new = json.loads(client.execute("SELECT new_row FROM revision WHERE id = 3").fetchone()[0])
    client.execute("UPDATE revision SET new_row = ? WHERE id = 3", (json.dumps({**new, column: new["text"]}),))
    if said:
        with pytest.raises(InputError, match=said):
            back(edited, 0)
    else:
        back(edited, 0)


def test_a_row_of_a_table_that_an_upgrade_took_away_is_in_the_way(database, client):
    client.execute(
        "INSERT INTO revision (table_name, row_key, operation, new_row) VALUES ('gone', '[\"a\"]', 'insert', '{}')"
    )
    with pytest.raises(InputError, match="there is no table 'gone' any more"):
        back(database, 0)


def test_numbers_that_no_change_touched_keep_their_last_digit(database, client):
    exact = 1 / 3
    client.execute("UPDATE channel SET rate_hz = ? WHERE target = 'drive.motors' AND robot = 'lbr'", (exact,))
    client.execute("UPDATE channel SET enabled = 0 WHERE target = 'drive.motors' AND robot = 'lbr'")
    back(database, 1)
    rows = database.tables()[0]["channel"]
    assert next(row for row in rows if (row["robot"], row["target"]) == ("lbr", "drive.motors"))["rate_hz"] == exact


def test_a_row_that_would_go_with_another_is_refused_whole(database, client):
    client.execute("INSERT INTO motion (robot, name) VALUES ('bioloid', 'nod')")
    client.execute(
        "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('bioloid', 'nod', 1, 1, '{}')"
    )

    def only_the_motion(tables, schema):
        return tuple(one for one in changes.between(tables, at(database, 0), schema) if one.table == "motion")

    with pytest.raises(InputError, match="motion_step 'bioloid/nod/1' would change with them"):
        command(database, only_the_motion, lambda _rows: (), text="")
    assert database.revision() == 2


def test_a_row_that_refers_to_none_is_refused_whole(database, client):
    client.execute("DELETE FROM motion_step WHERE robot = 'bioloid' AND motion = 'wave'")
    client.execute("DELETE FROM motion WHERE robot = 'bioloid' AND name = 'wave'")
    newest = database.revision()

    def only_steps(tables, schema):
        return tuple(one for one in changes.between(tables, at(database, 0), schema) if one.table == "motion_step")

    with pytest.raises(RowError, match="would refer to a row of motion that is not there"):
        command(database, only_steps, lambda _rows: (), text="")
    assert database.revision() == newest


def revision(number: int, at: str) -> RevisionRow:
    return RevisionRow(
        id=number, table="phrase", row_key=("a",), operation="insert", before=None, after={}, changed_at=at
    )


def test_revisions_are_told_by_who_made_them_and_else_by_their_moments():
    revisions = [
        revision(1, "2026-01-01T00:00:00.000Z"),
        revision(2, "2026-01-01T00:00:00.400Z"),
        revision(3, "2026-01-01T00:00:01.400Z"),
        revision(4, "2026-01-01T00:00:01.500Z"),
        revision(5, "2026-01-01T00:00:09.000Z"),
        revision(6, "not a time"),
    ]
    known = [ChangeRow(first_revision=4, last_revision=5, source="me", program="lbr")]
    found = past.entries(revisions, known)
    assert [(one.first, one.last, one.program) for one in found] == [(1, 2, ""), (3, 3, ""), (4, 5, "lbr"), (6, 6, "")]


STATEMENTS = (
    "UPDATE robot SET owner = owner || 'x' WHERE name = 'lbr'",
    "DELETE FROM channel WHERE rowid = (SELECT min(rowid) FROM channel)",
    "UPDATE capability SET enabled = 1 - enabled WHERE name = 'drive'",
    "INSERT OR IGNORE INTO phrase VALUES ('ouch', 'en', 'Ouch.')",
    "DELETE FROM phrase WHERE name = 'ouch'",
    "UPDATE motion SET name = name || '_2' WHERE robot = 'bioloid' AND name IN (SELECT min(name) FROM motion)",
    "DELETE FROM robot WHERE name = 'uxa90'",
    "DELETE FROM motion_step WHERE step = 2",
)


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """A database with a few of the shipped rows in each table, as it was before its first change."""
    path = databases.fresh(tmp_path_factory.mktemp("few") / "robot.db")
    databases.edit(
        path,
        "DELETE FROM behaviour WHERE name NOT IN (SELECT min(name) FROM behaviour GROUP BY robot)",
        "DELETE FROM channel WHERE rowid NOT IN (SELECT rowid FROM channel GROUP BY robot, source)",
        "DELETE FROM motor WHERE id > 3",
        "DELETE FROM revision",
        "PRAGMA wal_checkpoint(TRUNCATE)",
    )
    return path.read_bytes()


@given(st.lists(st.sampled_from(STATEMENTS), min_size=1, max_size=6), st.data())
def test_every_revision_of_any_edits_is_reached_exactly(few, tmp_path_factory, statements, data):
    path = tmp_path_factory.mktemp("past") / "robot.db"
    path.touch(0o600)
    path.write_bytes(few)
    with Database.open(path) as database:
        seen = {0: database.tables()[0]}
        for statement in statements:
            with database.writing() as connection:
                connection.execute(statement)
            seen[database.revision()] = database.tables()[0]
        number = data.draw(st.sampled_from(sorted(seen)))
        back(database, number)
        assert database.tables()[0] == seen[number]


def test_an_edit_that_comes_between_is_kept_and_looked_at(database, client):
    asked = []

    def wanted(tables, schema):
        asked.append(next(row["model"] for row in tables["robot"] if row["name"] == "lbr"))
        if len(asked) == 1:
            client.execute("UPDATE robot SET model = 'between' WHERE name = 'lbr'")
        after = {**tables, "robot": [{**row, "owner": "me"} for row in tables["robot"]]}
        return changes.between(tables, after, schema, "lbr")

    became = command(database, wanted, lambda _rows: (), text="")
    assert (became.before, became.revision, asked[1]) == (1, 2, "between")
    (row,) = [row for row in database.tables()[0]["robot"] if row["name"] == "lbr"]
    assert (row["model"], row["owner"]) == ("between", "me")


def test_of_two_at_once_that_looked_at_the_same_rows_one_is_refused(path):
    begin = threading.Barrier(2)

    def apply(owner: str) -> str:
        def wanted(tables, schema):
            begin.wait(HANG_S)
            after = {**tables, "robot": [{**row, "owner": owner} for row in tables["robot"]]}
            return changes.between(tables, after, schema, "lbr")

        with Database.open(path) as database:
            try:
                command(database, wanted, lambda _rows: (), text="", expected=0)
            except InputError as err:
                return str(err)
            return owner

    with ThreadPoolExecutor(2) as pool:
        said = sorted(pool.map(apply, ("a", "b")))
    assert said[0] in {"a", "b"}
    assert "have revision 1, not 0: they were changed meanwhile" in said[1]
    with Database.open(path) as database:
        assert database.revision() == 1
