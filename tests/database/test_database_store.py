"""The open database: reading, writing, and other programs that write at the same time."""

import math
import signal
import sqlite3
import sys
import threading
from contextlib import closing

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lbr.database import edits, history
from lbr.database.checks import RobotRows
from lbr.database.store import Database
from lbr.errors import RowError
from lbr.messages.calibration import CalibrationValue, measured
from lbr.messages.system import Event
from tests.support import databases, programs
from tests.support.waiting import HANG_S


def test_rows_come_as_they_stand(database, client):
    client.execute("UPDATE channel SET rate_hz = 12.5, history = 4 WHERE target = 'drive.motors'")
    client.execute("UPDATE device SET settings = '{\"faults\": {\"drop\": 0.1}}' WHERE name = 'motor_controller'")
    rows = database.load("lbr")
    channel = next(row for row in rows.channels if row.target == "drive.motors")
    device = next(row for row in rows.devices if row.name == "motor_controller")
    alias = next(row for row in rows.verbs if row.pattern == "b")
    assert (channel.rate_hz, channel.history, channel.target_end) == (12.5, 4, ("drive", "motors"))
    assert device.settings == {"faults": {"drop": 0.1}}
    assert (alias.target_end, alias.payload) == (("drive", "command"), {"power": 0.25, "angle_deg": 180})
    assert rows.revision == 2


def test_another_connection_s_commit_is_seen_and_our_own_is_not(database, client):
    before = database.data_version()
    database.append_events([Event(kind="k", subject="s", text="t")])
    database.set_estop("lbr", engaged=True, reason="")
    assert database.data_version() == before
    client.execute("BEGIN")
    client.execute("UPDATE robot SET owner = 'x'")
    assert database.data_version() == before
    client.execute("COMMIT")
    assert database.data_version() != before


def test_start_and_shutdown_are_written_down_in_utc(path):
    with Database.open(path, wall_ns=lambda: 1_700_000_000_123_000_000) as database:
        database.record_start("lbr")
        database.record_shutdown("lbr")
        robot = database.load("lbr").robot
    assert robot.last_start == robot.last_shutdown == "2023-11-14T22:13:20.123Z"


def test_the_latch_outlives_its_process_killed_right_after(path):
    program = (
        "import os, pathlib, signal, sys\n"
        "from lbr.database.store import Database\n"
        "Database.open(pathlib.Path(sys.argv[1])).set_estop('lbr', engaged=True, reason='smoke')\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = programs.run([sys.executable, "-c", program, str(path)], check=False)
    assert done.returncode == -signal.SIGKILL
    with Database.open(path) as database:
        robot = database.load("lbr").robot
        assert (robot.estop_engaged, robot.estop_reason) == (True, "smoke")
        database.set_estop("lbr", engaged=False, reason="")
        assert not database.load("lbr").robot.estop_engaged


def test_a_latch_for_no_robot_is_an_error(database):
    with pytest.raises(RowError, match="has no robot 'lbr9'"):
        database.set_estop("lbr9", engaged=True, reason="")


def test_events_come_back_in_order_and_the_oldest_go(database, monkeypatch):
    monkeypatch.setattr(history, "EVENTS_KEPT", 50)
    for batch in range(0, 120, 40):
        database.append_events(Event(kind="tick", subject="s", text=str(n)) for n in range(batch, batch + 40))
    assert [event.text for event in database.events(1000)] == [str(n) for n in range(70, 120)]
    assert [event.text for event in database.events(2)] == ["118", "119"]
    assert database.events(0) == ()


def test_an_event_keeps_all_it_says(database):
    event = Event(kind="k", subject="drive", text="t", level="warning", wall_ns=5, data={"a": [1, None, {"b": "ü"}]})
    database.append_events([event])
    assert database.events() == (event,)


def test_an_event_without_a_time_happened_now(path):
    with Database.open(path, wall_ns=lambda: 42) as database:
        database.append_events([Event(kind="k", subject="s", text="t")])
        assert database.events()[0].wall_ns == 42


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.builds(
        Event,
        kind=st.text(st.characters(), max_size=5),
        subject=st.text(st.characters(), max_size=5),
        text=st.text(st.characters()),
        level=st.sampled_from(["info", "warning", "error", "debug"]),
        wall_ns=st.integers(),
        data=st.dictionaries(st.text(), st.floats() | st.text() | st.integers(-(2**63), 2**63)),
    )
)
def test_no_event_is_lost_for_its_form(database, event):
    database.append_events([event])
    (kept,) = database.events(1)
    assert kept.text == event.text.encode(errors="replace").decode()
    assert set(kept.data) == set(event.data)


def test_calibration_is_written_and_overwritten_whole(database):
    known = {("calibration", ("range_board", name)): {"name": name} for name in ("offset_cm", "scale")}

    def keep(device, values, known=known):
        edits.learn(database, "lbr", list(measured(device, values)), known)

    def kept():
        return {(row.device, row.name): row.value for row in database.load("lbr").of(CalibrationValue)}

    keep("range_board", {"offset_cm": 1.0, "scale": 2.0}, {})
    keep("range_board", {"offset_cm": 3.0})
    found = kept()
    assert found == {("range_board", "offset_cm"): 3.0, ("range_board", "scale"): 2.0}
    with pytest.raises(RowError):
        keep("range_board", {"scale": 5.0, "offset_cm": math.inf})
    with pytest.raises(RowError):
        keep("gone", {"scale": 5.0}, {})
    assert kept() == found


def test_closing_twice_is_no_error(path):
    database = Database.open(path)
    database.close()
    database.close()


VALUES = st.none() | st.integers(-(2**63), 2**63 - 1) | st.floats() | st.binary(max_size=9) | st.text(max_size=9)
PLACES = [(table, column) for table, columns in databases.tables()[1].items() for column in columns]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.sampled_from(PLACES), VALUES, st.booleans()), max_size=5))
def test_a_file_with_bad_rows_loads_with_problems(database, client, edits):
    """Checks and foreign keys are off, as in any client that does not care for them."""
    client.execute("PRAGMA foreign_keys = OFF")
    client.execute("PRAGMA ignore_check_constraints = ON")
    client.execute("BEGIN")
    for (table, column), value, as_text in edits:
        raw = "CAST(CAST(? AS BLOB) AS TEXT)" if as_text and value is not None else "?"
        try:
            client.execute(f"UPDATE OR IGNORE {table} SET {column} = {raw}", (value,))
        except (sqlite3.IntegrityError, OverflowError):
            continue
    client.execute("COMMIT")
    rows = database.load("lbr")
    assert isinstance(rows, RobotRows)
    for problem in rows.problems:
        assert problem.column in {c for t, c in PLACES if t == problem.table}
        str(problem).encode()
    assert isinstance(database.revisions(), tuple)


def test_a_file_whose_rows_break_the_schema_opens_and_names_them(path, client):
    client.execute("PRAGMA ignore_check_constraints = ON")
    client.execute("UPDATE channel SET history = 99 WHERE source = 'motors.state'")
    client.execute("PRAGMA writable_schema = ON")
    client.execute(
        "UPDATE sqlite_schema SET sql = replace(sql, 'word    TEXT NOT NULL', 'word    ANY') WHERE name = 'verb'"
    )
    client.execute("PRAGMA writable_schema = RESET")
    client.execute("DROP TRIGGER verb_update")
    client.execute("UPDATE verb SET word = x'ff' WHERE pattern = 'b'")
    client.execute("PRAGMA writable_schema = ON")
    client.execute(
        "UPDATE sqlite_schema SET sql = replace(sql, 'word    ANY', 'word    TEXT NOT NULL') WHERE name = 'verb'"
    )
    with Database.open(path) as database:
        found = {(problem.table, problem.column) for problem in database.load("lbr").problems}
    assert {("channel", "history"), ("verb", "word")} <= found


@pytest.mark.parametrize(
    "edit",
    [
        "ALTER TABLE verb DROP COLUMN help",
        "ALTER TABLE verb RENAME COLUMN help TO hilfe",
        "ALTER TABLE verb ADD COLUMN colour TEXT",
    ],
)
def test_tables_that_were_altered_are_problems(database, client, edit, wording):
    for (name,) in client.execute("SELECT name FROM sqlite_schema WHERE type = 'trigger'").fetchall():
        client.execute(f"DROP TRIGGER {name}")
    client.execute(edit)
    wording(*database.load("lbr").problems)


def test_another_program_edits_a_hundred_times_a_second_while_we_read_and_write(path, database):
    """Neither side ever hears that the database is locked, and every load is one moment. What can be written later waits a
    tenth of a second only: an edit that the disk or the processor holds up takes longer."""
    failed: list[BaseException] = []
    edits = 0
    enough = threading.Event()

    def edit() -> None:
        nonlocal edits
        try:
            with closing(sqlite3.connect(path, timeout=HANG_S, isolation_level=None)) as other:
                while not enough.wait(0.005):
                    other.execute("BEGIN IMMEDIATE")
                    other.execute("UPDATE capability SET help = ? WHERE name = 'drive'", (str(edits),))
                    other.execute("UPDATE device SET address = ? WHERE name = 'range_board'", (f"sim:{edits}",))
                    other.execute("COMMIT")
                    edits += 1
        except sqlite3.Error as err:
            failed.append(err)

    editor = threading.Thread(target=edit)
    editor.start()
    seen = set()
    while len(seen) < 20 and editor.is_alive():
        rows = database.load("lbr")
        words = next(row.help for row in rows.capabilities if row.name == "drive")
        address = next(row.address for row in rows.devices if row.name == "range_board")
        assert address == f"sim:{words}" or not words.isdigit()
        seen.add(words)
        database.record_start("lbr")
        database.record_shutdown("lbr")
    enough.set()
    editor.join()
    assert failed == []
    assert database.load("lbr").revision == 2 * edits


def test_several_threads_share_one_database(database):
    """As the executive does: the e-stop is latched while events are written."""
    failed: list[BaseException] = []

    def work(number: int) -> None:
        try:
            for _ in range(20):
                database.append_events([Event(kind="k", subject=str(number), text="t")])
                database.set_estop("lbr", engaged=True, reason=str(number))
                database.data_version()
                assert database.load("lbr").robot.estop_engaged
        except BaseException as err:  # noqa: BLE001 - shown by the assertion below
            failed.append(err)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
    assert len(database.events(1000)) == 60


def test_a_trigger_that_never_ends_holds_nobody_up_for_long(database, client):
    for_ever = "(WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT count(*) FROM n)"
    client.execute(
        f"CREATE TRIGGER odd AFTER INSERT ON event BEGIN UPDATE robot SET owner = owner WHERE {for_ever} < 0; END"
    )
    database.bound(0.05)
    for _ in range(2):
        with pytest.raises(RowError, match=r"take too long to read or write: .*`lbr db check` names those"):
            database.append_events([Event(kind="k", subject="s", text="t")])
    client.execute("DROP TRIGGER odd")
    database.append_events([Event(kind="k", subject="s", text="t")])
    assert len(database.events()) == 1


@pytest.mark.parametrize("spoilt", ["verb", "capability"])
def test_a_row_of_megabytes_is_not_read_and_nothing_is_lost_once_it_is_gone(database, client, spoilt):
    before = database.load("lbr")
    if spoilt == "verb":
        client.execute(
            "INSERT INTO verb (robot, word, pattern, target, payload, help)"
            " VALUES ('lbr', 'zz', 'zz', 'drive.command', '{}', hex(zeroblob(3000000)))"
        )
    else:
        client.execute(
            "UPDATE capability SET settings = json_object('zz', hex(zeroblob(3000000))) WHERE name = 'drive'"
        )
    with pytest.raises(RowError, match=rf"a row in '{spoilt}' of more than 4 MB"):
        database.load("lbr")
    client.execute("DELETE FROM verb WHERE word = 'zz'")
    client.execute("UPDATE capability SET settings = '{}' WHERE name = 'drive'")
    after = database.load("lbr")
    assert (after.verbs, after.problems) == (before.verbs, before.problems)
    touched = database.touched(before.revision)
    assert {one.table for one in touched} >= {spoilt}
    assert all(one.before is None and one.after is None for one in touched), "what stood there is not read to name it"
    assert [one.row_key for one in touched] == [one.row_key for one in database.revisions(before.revision)]
    with pytest.raises(RowError, match="a row in 'revision' of more than 4 MB"):
        database.tables_at(before.revision)
