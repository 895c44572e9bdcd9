"""Old data by chance: whatever stands in a file, it becomes good rows, a note or a sentence; nothing else happens."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.motions.commands import wanted_rows
from lbr.database import foreign_tables, given_files
from lbr.database.columns import columns, raw
from lbr.errors import InputError
from lbr.robot.old_data import Choice, Note, Source, Want
from lbr.robots.lbr.old_cameras import OldCameras
from lbr.robots.lbr.old_database import OldDatabase
from lbr.robots.uxa90 import old_tables
from tests.support import databases
from tests.support.old_data import ROWS, old_database, old_sql

CELLS = st.one_of(st.none(), st.integers(-(2**63), 2**63 - 1), st.floats(), st.text(max_size=12), st.binary(max_size=4))
JSON = st.recursive(st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8), lambda one: st.lists(one, max_size=3) | st.dictionaries(st.text(max_size=8), one, max_size=3), max_leaves=6)  # fmt: skip


def taken(robot, data):
    """What becomes of old data; the rows are such as their tables take."""
    rows, _ = databases.tables()
    here = wanted_rows.RowsOfRobot(rows, robot)
    wishes = list(data.wants(here, Choice("lbr6")))
    notes = [one for one in wishes if isinstance(one, Note)]
    wants = [one for one in wishes if isinstance(one, Want)]
    found = wanted_rows.take(wants, here, rows, replacing=False)
    for row in found.rows:
        for name, value in raw(row).items():
            columns(type(row))[name].read(value)
    assert all(note.text.isprintable() for note in (*notes, *found.notes))
    return found


@given(st.data())
def test_cells_by_chance_become_good_rows_or_notes(drawn):
    changed = {}
    for table in ("calibration", "move_config", "extcmd"):
        changed[table] = [
            tuple(
                drawn.draw(CELLS) if drawn.draw(st.integers(0, 3)) == 0 and at > 1 else cell
                for at, cell in enumerate(row)
            )
            for row in ROWS[table]
        ]
    taken("lbr", OldDatabase(foreign_tables.of_database(old_database(**changed)), "/nowhere"))


@given(st.dictionaries(st.sampled_from(["front", "rear", "x"]), st.fixed_dictionaries({"device": st.text(max_size=9), "status": JSON, "settings": JSON | st.fixed_dictionaries({"user": JSON, "camera": JSON})})))  # fmt: skip
def test_cameras_by_chance_become_good_rows_or_notes(cameras):
    taken("lbr", OldCameras(cameras))


@given(st.lists(st.fixed_dictionaries(dict.fromkeys(("id", "name", "min", "max", "default", "button", "position", "more"), JSON)), max_size=3))  # fmt: skip
def test_motors_and_buttons_by_chance_become_good_rows_or_notes(found):
    taken("uxa90", old_tables.OldTables(found, found))


@given(st.text(max_size=40))
def test_settings_by_chance_are_read_or_not(text):
    found = old_tables.read_settings(Source(name=".env", folder="/", content=b"", text=text))
    assert found is None or isinstance(found, old_tables.OldSettings)


WHOLE = old_database()


@given(st.integers(0, len(WHOLE) - 1), st.binary(max_size=40), st.integers(0, 60))
def test_a_damaged_database_is_rows_or_a_sentence(at, put, cut):
    with contextlib.suppress(InputError):
        foreign_tables.of_database(WHOLE[:at] + put + WHOLE[at + cut :])


@given(st.integers(0, 3000), st.text(max_size=12), st.integers(0, 40))
def test_a_damaged_dump_is_rows_or_a_sentence(at, put, cut):
    text = old_sql()
    with contextlib.suppress(InputError):
        foreign_tables.of_sql(text[:at] + put + text[at + cut :])


def test_a_database_with_a_log_beside_it_and_its_dump_are_the_same_rows():
    logged = bytearray(WHOLE)
    logged[18:20] = b"\2\2"
    assert (
        foreign_tables.of_database(bytes(logged))
        == foreign_tables.of_sql(old_sql())
        == foreign_tables.of_database(WHOLE)
    )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp949"])
def test_texts_are_read_in_the_encodings_that_such_files_have(encoding):
    assert given_files.decoded("인사, motion".encode(encoding)) == "인사, motion"


def test_western_texts_and_bytes_that_are_no_text():
    assert given_files.decoded("un café".encode("latin-1")) == "un café"
    assert given_files.decoded(b"a\0b") is None
    assert given_files.decoded(b"\xff\xfe\x00") is None


@pytest.mark.parametrize(
    "more",
    [
        "INSERT INTO a SELECT p.x FROM a p, a q, a r, a s, a t, a u, a v, a w;",
        "INSERT INTO a VALUES (randomblob(10000000));",
        "UPDATE a SET x = 1;",
        "CREATE TRIGGER t AFTER INSERT ON a BEGIN INSERT INTO a VALUES (1); END;",
        "CREATE VIEW v AS SELECT x FROM a;",
        "CREATE TABLE b AS WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i FROM n;",
    ],
)
def test_a_dump_only_makes_tables_and_fills_them_with_what_it_says(more):
    rows = ", ".join(f"({number})" for number in range(200))
    with pytest.raises(InputError, match=r"(authorized|prohibited)"):
        foreign_tables.of_sql(f"CREATE TABLE a (x); INSERT INTO a VALUES {rows}; {more}")


def test_a_dump_with_a_nul_in_it_is_refused():
    with pytest.raises(InputError, match="NUL"):
        foreign_tables.of_sql("CREATE TABLE a (x);\0")


def test_a_dump_has_no_more_than_a_moment_and_a_little_room(monkeypatch):
    begun = "CREATE TABLE a (x);"
    one = f"INSERT INTO a VALUES (replace('{'a' * 1000}', 'a', '{'b' * 900}'));"
    with pytest.raises(InputError, match="database or disk is full"):
        foreign_tables.of_sql(begun + one * 100)
    monkeypatch.setattr(foreign_tables, "COMPUTED_S", 0.0)
    with pytest.raises(InputError, match="interrupted"):
        foreign_tables.of_sql(begun + "INSERT INTO a VALUES (1);" * 2000)


def test_texts_of_several_lines_are_read_as_dumps_write_them():
    found = foreign_tables.of_sql("CREATE TABLE a (x); INSERT INTO a VALUES (replace('one\\ntwo', '\\n', char(10)));")
    assert found == {"a": [{"x": "one\ntwo"}]}


def test_a_dump_may_have_keys_checks_and_several_rows_at_once():
    found = foreign_tables.of_sql(
        "PRAGMA foreign_keys=OFF; BEGIN TRANSACTION;"
        "CREATE TABLE m (a INT PRIMARY KEY, b TEXT CHECK (length(b) > 0)) WITHOUT ROWID; INSERT INTO m VALUES (1, 'x'), (3, 'y');"
        "CREATE TABLE c (id INTEGER PRIMARY KEY AUTOINCREMENT); INSERT INTO c VALUES (4); DELETE FROM sqlite_sequence;"
        "INSERT INTO sqlite_sequence VALUES ('c', 9); CREATE UNIQUE INDEX i ON m (b); COMMIT;"
    )
    assert found == {"m": [{"a": 1, "b": "x"}, {"a": 3, "b": "y"}], "c": [{"id": 4}]}


def test_a_folder_is_no_file_to_read(tmp_path):
    with pytest.raises(InputError, match="name a regular file"):
        given_files.read(tmp_path, 10)
