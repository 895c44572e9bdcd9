"""robot.db.sql: it is what the tables' classes declare, its checks refuse bad rows, its triggers keep the revisions."""

import importlib
import json
import re
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from lbr.capability import registry
from lbr.database import edits
from lbr.database.books import BOOKS
from lbr.database.rows import CORE
from lbr.database.store import Database
from lbr.resources import launch_profiles, robot_db_sql
from tests.database.test_database_checks import BAD_VALUES, SHIPPED
from tests.support import databases, needs, programs

ROOT = Path(__file__).parents[2]
TABLE = re.compile(r"CREATE TABLE (\w+) \((.*?)\n\) STRICT", re.DOTALL)
_, SCHEMA = databases.tables()
READ = {row.TABLE: row for row in registry.tables()} | {row.TABLE: row for row in (*CORE, *BOOKS)}
OWN = {row.TABLE for row in BOOKS}
"""What lbr writes for itself: no rows that make a robot."""


@pytest.fixture(scope="module")
def schema():
    from lbr.database import schema  # it takes half a second, of each process that collects tests

    return schema


@pytest.fixture(scope="module")
def declared(schema):
    return schema.metadata(READ.values())


@pytest.mark.parametrize("name", sorted(READ))
def test_the_file_has_each_table_as_it_is_declared(schema, declared, name):
    assert f"\n{schema.text(declared.tables[name])}" in robot_db_sql().read_text()


@pytest.mark.parametrize("name", sorted(SCHEMA))
def test_the_file_has_the_triggers_of_each_table(schema, declared, name):
    assert schema.revision_triggers(declared.tables[name]) in robot_db_sql().read_text()


def test_alembic_finds_nothing_else_in_a_new_database(schema, declared):
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(robot_db_sql().read_text())
        assert schema.differences(connection, declared) == []
        connection.execute("ALTER TABLE joint ADD COLUMN colour TEXT")
        assert [found[0] for found in schema.differences(connection, declared)] == ["remove_column"]


def test_each_column_says_what_it_means(declared):
    tables = declared.tables.values()
    assert [table.name for table in tables if not table.comment] == []
    assert [(table.name, column.name) for table in tables for column in table.columns if not column.comment] == []


def test_a_new_table_is_a_class_and_the_kind_that_reads_it(schema, client, path, monkeypatch):
    """The example's table, as its class declares it: with its checks, its triggers, and read as any other."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "examples")
    (row,) = (read.row for read in importlib.import_module("greetings").KIND.reads)
    client.executescript(schema.script(row))
    insert(client, "greeting", {"robot": "lbr", "name": "ann", "text": "Good day, Ann."})
    for wrong in ({"name": "Ann", "text": "t"}, {"name": "bob", "text": ""}, {"name": "c", "text": "t", "said": -1}):
        with pytest.raises(sqlite3.IntegrityError):
            insert(client, "greeting", {"robot": "lbr", **wrong})
    with Database.open(path) as database:
        edits.learn(database, "lbr", [row(name="dan", text="Hello.")])
        assert [one.name for one in database.load("lbr").of(row)] == ["ann", "dan"]
        assert [(one.table, one.operation) for one in database.revisions()] == [("greeting", "insert")] * 2


def test_every_table_that_makes_a_robot_keeps_its_changes(client):
    tables = {name for (name,) in client.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
    assert tables - OWN - {"sqlite_sequence"} == set(SCHEMA)


def test_every_table_is_strict(client):
    rows = client.execute(
        "SELECT name, strict FROM pragma_table_list WHERE schema = 'main' AND name NOT LIKE 'sqlite%'"
    )
    assert {name for name, strict in rows if not strict} == set()


def test_the_shipped_rows_have_no_problem(database: Database):
    rows = database.load("lbr")
    assert rows.problems == ()
    assert {row.name for row in rows.capabilities} >= {"motors", "ranges", "drive", "lan", "world"}
    assert {row.word for row in rows.verbs} >= {"f", "b", "snapshot"}
    assert all(row.help for row in (*rows.capabilities, *rows.verbs))
    assert rows.revision == 0
    assert not rows.robot.estop_engaged


def test_launch_profiles_are_found():
    assert launch_profiles().is_dir()


@needs.program("sqlite3", "sqlite3")
def test_the_sqlite3_program_builds_the_same(tmp_path):
    file = tmp_path / "robot.db"
    programs.run(["sqlite3", file], input=robot_db_sql().read_bytes(), check=True, capture_output=True)
    file.chmod(0o600)
    with Database.open(file) as database:
        assert database.load("lbr").problems == ()


WHEEL = {"name": "front_left", "motor": "left", "x_m": 0.1, "y_m": 0.2, "diameter_m": 0.15}
SENSOR = {"name": "bow", "kind": "ultrasonic"}
MOTOR = {"layer": "safe", "id": 23, "name": "neck", "initial": 127, "lowest": 1, "highest": 254, "rest": 127}
LINE = {"behaviour": "watch", "step": 1}
JOINT = {"name": "j", "device_id": 1, "lower_rad": 0, "upper_rad": 1, "speed_rps": 1}
STEP = {"motion": "bow", "step": 1, "duration_s": 1.0, "positions": "{}"}
BAD_ROWS = [
    ("robot", {"name": "Robby"}),
    ("capability", {"name": "c", "kind": "k", "enabled": 2}),
    ("capability", {"name": "c", "kind": None}),
    ("capability", {"name": "c", "kind": "k", "robot": "nobody"}),
    ("channel", {"source": "drive.x", "target": "motors.setpoint.x"}),
    ("channel", {"source": "a.b", "target": "c.d", "enabled": -1}),
    ("device", {"name": "d", "type": "t", "address": ""}),
    ("external_command", {"name": "x y", "argv": '["/bin/true"]'}),
    ("external_command", {"name": "x", "argv": '["/bin/true"]', "enabled": 3}),
    ("phrase", {"name": "Hi", "language": "en", "text": "t"}),
    ("calibration", {"device": "nothing", "name": "n", "value": 1.0}),
    ("calibration", {"device": "range_board", "name": "N", "value": 1.0}),
    ("joint", {**JOINT, "name": "J"}),
    ("joint", {**JOINT, "bus": "Arm"}),
    ("joint", {**JOINT, "lower_rad": -99}),
    ("joint", {**JOINT, "lower_rad": 1}),
    ("motion", {"name": "Bow"}),
    ("motion", {"name": "b", "lead_in": "Bow"}),
    ("motion", {"name": "b", "slot": 7}),
    ("motion", {"name": "b", "slot_s": 1.0}),
    ("motion_step", {**STEP, "motion": "none"}),
    ("motion_step", {**STEP, "positions": "[]"}),
    ("motor", {**MOTOR, "lowest": 254}),
    ("button", {"id": 1, "name": ""}),
    ("button", {"id": 1, "name": "n", "motion": "Bow"}),
    ("range_sensor", {**SENSOR, "name": "Bow"}),
    ("range_sensor", {**SENSOR, "x_m": 5.1}),
    ("range_sensor", {**SENSOR, "min_m": 4}),
    ("wheel", {**WHEEL, "x_m": 5.1}),
    ("behaviour", {"name": "Patrol"}),
    ("behaviour_row", {**LINE, "conditions": "[]"}),
    ("behaviour_row", {**LINE, "behaviour": "unknown"}),
    ("user_token", {"name": "", "role": "view", "hash": "h" * 32}),
    ("user_token", {"name": "n", "role": "god", "hash": "h" * 32}),
    ("user_token", {"name": "n", "role": "view", "hash": "plain"}),
    ("user_token", {"name": "n", "role": "view", "hash": "h" * 32, "good_for": "all"}),
    ("user_token", {"name": "n", "role": "view", "hash": "h" * 32, "paired_from": ""}),
    ("user_token", {"name": "n", "role": "view", "hash": "h" * 32, "called": ""}),
    ("revision", {"table_name": "t", "row_key": "x", "operation": "insert"}),
    ("revision", {"table_name": "t", "row_key": "[]", "operation": "replace"}),
    ("revision", {"table_name": "t", "row_key": "[]", "operation": "insert", "new_row": "{"}),
    ("revision", {"table_name": "t", "row_key": "[]", "operation": "insert", "old_row": "{"}),
    ("change", {"first_revision": 2, "last_revision": 1, "source": "", "program": ""}),
    ("trial", {"revision": 1, "back": -1, "robot": "lbr", "within_s": 1}),
    ("trial", {"revision": 1, "back": 0, "robot": "lbr", "within_s": 601}),
    ("trial", {"revision": 1, "back": 0, "robot": "lbr", "within_s": 1, "state": "perhaps"}),
    ("event", {"wall_ns": -1, "kind": "k"}),
    ("event", {"wall_ns": 1, "kind": "k", "level": "debug"}),
    ("event", {"wall_ns": 1, "kind": "k", "data": "[]"}),
    ("event", {"wall_ns": "now", "kind": "k"}),
    ("audit", {"wall_ns": -1, "kind": "k", "subject": "", "source": "", "text": "", "previous": "", "hash": "h"}),
    ("adopted", {"revision": 1, "hash": "h", "wall_ns": -1}),
]
"""What none of the bad values has that lbr's own reading of a row refuses: see `refused`."""
GOOD_ROWS = [
    ("robot", {"name": "x"}),
    ("capability", {"name": "c", "kind": "k"}),
    ("channel", {"source": "a.b", "target": "c.d", "rate_hz": 0.5, "history": 64}),
    ("device", {"name": "d", "type": "t", "address": "sim:"}),
    ("verb", {"word": "x", "pattern": "/x/{text...}", "target": "a.b", "payload": '{"a": 1}'}),
    ("external_command", {"name": "x", "argv": '["/bin/true"]'}),
    ("phrase", {"name": "hi", "language": "pt-br", "text": "t"}),
    ("choreography", {"dance": "waltz", "step": 3, "power": 0.5, "angle_deg": -90, "beats": 2}),
    ("calibration", {"device": "range_board", "name": "n", "value": -1.5}),
    ("joint", {"name": "j", "device_id": 1, "lower_rad": -1, "upper_rad": 1, "speed_rps": 1}),
    ("motion", {"name": "b", "slot": 7, "slot_s": 600.0, "limp": 1, "builtin": 1}),
    ("motion_step", {"motion": "bow", "step": 1, "duration_s": 1.0, "positions": '{"j": 0.5}'}),
    ("motor", MOTOR),
    ("button", {"id": 4, "name": "walk", "button": "U", "motion": "bow"}),
    ("range_sensor", {**SENSOR, "kind": "lidar", "rays": 360, "fov_rad": 6.2832, "stop_m": None}),
    ("kinematics", {"name": "base", "kind": "skid", "track_factor": 1.5}),
    ("wheel", {**WHEEL, "yaw_rad": 1.5708, "roller_rad": -0.7854}),
    ("behaviour", {"name": "b", "max_s": 0}),
    ("behaviour_row", {**LINE, "conditions": '{"Forward": "< 40"}', "deadline_s": 0.5}),
    ("user_token", {"name": "n", "role": "view", "hash": "h" * 32}),
    ("event", {"wall_ns": 1, "kind": "k"}),
]


def insert(client: sqlite3.Connection, table: str, columns: dict) -> None:
    if "robot" in SCHEMA.get(table, ()):
        columns = {"robot": "lbr", **columns}
    marks = ", ".join("?" * len(columns))
    client.execute(f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({marks})", tuple(columns.values()))


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    path = databases.fresh(tmp_path_factory.mktemp("schema") / "robot.db")
    with closing(sqlite3.connect(path, isolation_level=None)) as client:
        client.execute("PRAGMA foreign_keys = ON")
        yield client


@pytest.fixture
def tried(opened):
    """A new database with a motion and a behaviour, which takes back what a test has written."""
    opened.execute("BEGIN")
    insert(opened, "motion", {"name": "bow"})
    insert(opened, "behaviour", {"name": "watch"})
    yield opened
    opened.execute("ROLLBACK")


@pytest.mark.parametrize(("table", "columns"), BAD_ROWS)
def test_the_schema_refuses(tried, table, columns):
    with pytest.raises(sqlite3.IntegrityError):
        insert(tried, table, columns)


@pytest.mark.parametrize(("table", "columns"), GOOD_ROWS)
def test_the_schema_takes(tried, table, columns):
    insert(tried, table, columns)


def refused() -> set[tuple[str, str]]:
    """Return the columns with a bad value for lbr's own reading that a check of SQLite refuses as well."""
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as client:
        client.executescript(robot_db_sql().read_text())
        for table, rows in SHIPPED.items():
            client.execute(f"DELETE FROM {table}")
            for row in rows:
                insert(client, table, row)
        found = set()
        for table, number, column, value in BAD_VALUES:
            (rowid,) = client.execute(f"SELECT rowid FROM {table} ORDER BY rowid LIMIT 1 OFFSET {number}").fetchone()
            client.execute("BEGIN")
            try:
                client.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (value, rowid))
            except sqlite3.IntegrityError as err:
                found |= {(table, column)} if str(err).startswith("CHECK") else set()
            except UnicodeEncodeError:
                pass
            client.execute("ROLLBACK")
    return found


def test_every_check_refuses_a_bad_value():
    """Each column with a CHECK stands in a refused row, or has a value that is refused by itself."""
    known = refused() | {(name, column) for name, columns in BAD_ROWS for column in columns}
    for table in TABLE.finditer(robot_db_sql().read_text()):
        column = ""
        for line in table[2].splitlines():
            if found := re.match(r"    ([a-z_]+) ", line):
                column = found[1]
            if "CHECK" in line and not line.startswith("    CHECK"):
                assert (table[1], column) in known


CHANGES = {
    "robot": "owner = 'somebody'",
    "capability": "enabled = 0",
    "channel": "rate_hz = 5.0",
    "device": "address = 'sim:'",
    "verb": "payload = '{}'",
    "external_command": "enabled = 0",
    "phrase": "text = 'Hm.'",
    "choreography": "power = 0.25",
    "calibration": "value = 2.0",
    "joint": "speed_rps = 2.0",
    "motion": "help = 'another'",
    "motion_step": "duration_s = 9.0",
    "range_sensor": "z_m = 0.5",
    "kinematics": "kind = 'skid'",
    "wheel": "x_m = 0.25",
    "motor": "rest = 100",
    "button": "name = 'another'",
    "behaviour": "help = 'another'",
    "behaviour_row": "next_state = 'Another'",
}


@pytest.mark.parametrize("table", list(SCHEMA))
def test_every_change_of_a_row_is_a_revision(client, database, table):
    client.execute("DELETE FROM calibration")
    insert(client, "calibration", {"device": "range_board", "name": "n", "value": 1.0})
    insert(client, "motion", {"name": "bow"})
    insert(client, "motion_step", {"motion": "bow", "step": 1, "duration_s": 1.0, "positions": "{}"})
    insert(client, "motor", MOTOR)
    insert(client, "button", {"id": 4, "name": "walk"})
    insert(client, "kinematics", {"name": "base", "kind": "differential"})
    insert(client, "wheel", WHEEL)
    insert(client, "behaviour", {"name": "watch"})
    insert(client, "behaviour_row", LINE)
    since = database.load("lbr").revision
    keys = SCHEMA.keys_of[table]
    rowid, *key = client.execute(f"SELECT rowid, {', '.join(keys)} FROM {table}").fetchone()
    client.execute(f"UPDATE {table} SET {CHANGES[table]} WHERE rowid = {rowid}")
    client.execute(f"DELETE FROM {table} WHERE rowid = {rowid}")
    mine = [revision for revision in database.revisions(since) if revision.table == table]
    update, delete = mine[0], next(r for r in mine if r.operation == "delete" and r.row_key == tuple(map(str, key)))
    column, _, value = CHANGES[table].partition(" = ")
    assert (update.operation, update.row_key) == ("update", tuple(map(str, key)))
    assert update.before[column] != update.after[column]
    assert str(update.after[column]) == value.strip("'")
    assert delete.before == update.after
    assert set(delete.before) == set(SCHEMA[table]) - RUN_COLUMNS.get(table, set())


RUN_COLUMNS = {"robot": {"last_start", "last_shutdown", "estop_engaged", "estop_reason"}}


def test_a_new_row_is_a_revision_with_its_defaults(client, database):
    insert(client, "capability", {"name": "c", "kind": "k"})
    (revision,) = database.revisions()
    assert (revision.table, revision.row_key, revision.operation) == ("capability", ("lbr", "c"), "insert")
    assert revision.before is None
    assert json.loads(revision.after["settings"]) == {}


def test_deleting_a_robot_keeps_every_row_it_had(client, database):
    (verbs,) = client.execute("SELECT count(*) FROM verb").fetchone()
    client.execute("DELETE FROM robot")
    lost = [(r.table, r.operation) for r in database.revisions()]
    assert lost.count(("verb", "delete")) == verbs > 0
    assert ("robot", "delete") in lost


def test_what_lbr_writes_into_the_robot_is_no_revision(client, database):
    database.record_start("lbr")
    database.record_shutdown("lbr")
    database.set_estop("lbr", engaged=True, reason="test")
    client.execute("UPDATE robot SET owner = owner")
    client.execute("UPDATE verb SET help = help")
    assert database.revisions() == ()
