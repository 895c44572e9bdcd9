"""Older databases are backed up and upgraded in one transaction; unknown ones are refused."""

import shutil
import signal
import sqlite3
import sys
import threading
from contextlib import closing

import pytest

from lbr.database import migrate
from lbr.database.claims import Claim
from lbr.database.store import Database, create
from lbr.errors import LbrError, RowError
from lbr.resources import robot_db_sql
from tests.support import programs

SHIPPED = migrate.MIGRATIONS
NOW = migrate.HEAD
AFTER, LATER = (f"{int(NOW) + more:04d}" for more in (1, 2))
"""The schema of this version, and what would be the next ones."""
NEXT = '''
"""Robots have colours."""

import sqlalchemy as sa
from alembic import op

revision = "{revision}"
down_revision = "{before}"


def upgrade() -> None:
    op.add_column("motion", sa.Column("colour", sa.Text))
    op.execute("ALTER TABLE device RENAME COLUMN address TO place")
    {last}


def downgrade() -> None:
    pass
'''


@pytest.fixture
def newer(tmp_path, monkeypatch):
    """Make this version one that knows a revision more; returns a way to say what its last line does."""

    def make(last: str = "pass") -> None:
        folder = tmp_path / "100% migrations"
        shutil.copytree(SHIPPED, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
        (folder / "versions" / f"v{AFTER}_colour.py").write_text(NEXT.format(revision=AFTER, before=NOW, last=last))
        monkeypatch.setattr(migrate, "MIGRATIONS", folder)
        monkeypatch.setattr(migrate, "HEAD", AFTER)

    return make


def look(path, query):
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute(query).fetchall()


def columns(path, table):
    return [row[0] for row in look(path, f"SELECT name FROM pragma_table_info('{table}')")]


def stamp(path):
    return look(path, "SELECT version_num FROM alembic_version")


def test_the_newest_revision_is_the_one_of_the_sql_file(path):
    from alembic.script import ScriptDirectory  # half a second, of each process that collects tests

    assert ScriptDirectory(str(migrate.MIGRATIONS)).get_heads() == [migrate.HEAD]
    assert stamp(path) == [(migrate.HEAD,)]
    assert f"VALUES ('{migrate.HEAD}')" in robot_db_sql().read_text()


@pytest.fixture
def before_names(tmp_path):
    """A database from before tokens had names for people."""
    lines = robot_db_sql().read_text().replace(f"VALUES ('{NOW}')", "VALUES ('0015')").splitlines()
    (at,) = [number for number, line in enumerate(lines) if line.lstrip().startswith("called ")]
    lines[at - 1] = lines[at - 1].rstrip(",")
    sql, path = tmp_path / "before.sql", tmp_path / "before.db"
    sql.write_text("\n".join(lines[:at] + lines[at + 2 :]))
    create(path, sql)
    return path


def test_a_token_of_before_names_for_people_goes_by_its_own_name(before_names):
    path = before_names
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("INSERT INTO user_token (name, role, hash) VALUES ('phone', 'view', ?)", ("h" * 64,))
    with Database.open(path) as database:
        assert database.backup is not None
        assert [(one.name, one.role, one.called) for one in database.tokens()] == [("phone", "view", None)]


def test_a_page_of_before_recordings_offers_them_after_an_upgrade_and_other_faces_stay(before_names):
    chosen = "UPDATE capability SET settings = json_set(settings, '$.faces', json('[\"page\", \"call\"]'))"
    with closing(sqlite3.connect(before_names)) as connection, connection:
        connection.execute(f"{chosen} WHERE name = 'web'")
    Database.open(before_names).close()
    shown = look(before_names, "SELECT name, settings ->> '$.faces' FROM capability WHERE kind = 'web'")
    assert sorted(shown) == [("web", '["page","call","recordings"]'), ("web_api", '["lbr_original"]')]


def test_a_database_of_this_version_is_left_alone(path):
    with Database.open(path) as database:
        assert database.backup is None
    assert [file.name for file in path.parent.iterdir()] == ["robot.db"]


def test_an_older_database_is_backed_up_and_upgraded(path, newer):
    newer()
    verbs = look(path, "SELECT * FROM verb ORDER BY pattern")
    devices = look(path, "SELECT count(*) FROM device")
    with Database.open(path) as database:
        assert database.backup == path.with_name(f"robot.db.backup-{NOW}")
    assert stamp(path) == [(AFTER,)]
    assert "colour" in columns(path, "motion")
    assert "place" in columns(path, "device")
    assert look(path, "SELECT * FROM verb ORDER BY pattern") == verbs
    assert look(path, "SELECT count(*) FROM device") == devices
    assert stamp(database.backup) == [(NOW,)]
    assert "address" in columns(database.backup, "device")
    assert database.backup.stat().st_mode & 0o777 == 0o600
    with Database.open(path) as database:
        assert database.backup is None


def test_a_database_that_a_robot_of_an_older_version_runs_from_stays_as_it_is(path, newer):
    claim = Claim("lbr")
    claim.take(path)
    newer()
    with pytest.raises(RowError, match="a robot of the older lbr that made it runs from it: end that first"):
        Database.open(path)
    assert stamp(path) == [(NOW,)]
    claim.release()
    with Database.open(path) as database:
        assert database.backup is not None


def test_a_backup_is_a_whole_database(path, newer, monkeypatch):
    with Database.open(path) as database:
        database.set_estop("lbr", engaged=True, reason="kept")
        before = database.load("lbr")
    newer()
    Database.open(path).close()
    monkeypatch.undo()
    with Database.open(path.with_name(f"robot.db.backup-{NOW}")) as backup:
        assert backup.load("lbr") == before


def test_backups_are_never_overwritten(path, newer):
    path.with_name(f"robot.db.backup-{NOW}").write_text("an older one")
    newer()
    with Database.open(path) as database:
        assert database.backup == path.with_name(f"robot.db.backup-{NOW}-2")
    assert path.with_name(f"robot.db.backup-{NOW}").read_text() == "an older one"


def test_a_migration_that_fails_changes_nothing(path, newer):
    newer('op.execute("UPDATE no_such_table SET x = 1")')
    with pytest.raises(LbrError, match="no such table: no_such_table"):
        Database.open(path)
    assert stamp(path) == [(NOW,)]
    assert columns(path, "motion") == [
        "robot",
        "name",
        "help",
        "lead_in",
        "lead_out",
        "slot",
        "slot_s",
        "limp",
        "builtin",
    ]
    assert "address" in columns(path, "device")


def test_a_migration_that_leaves_dangling_rows_changes_nothing(path, newer):
    newer('op.execute("DELETE FROM robot")')
    with pytest.raises(RowError, match="refer to none"):
        Database.open(path)
    assert stamp(path) == [(NOW,)]
    assert look(path, "SELECT name FROM robot") == [("bioloid",), ("lbr",), ("uxa90",)]


def test_a_process_killed_in_the_middle_leaves_the_old_schema(path, newer):
    newer("__import__('os').kill(__import__('os').getpid(), 9)")
    program = (
        "import pathlib, sys\n"
        "from lbr.database import migrate, store\n"
        f"migrate.MIGRATIONS, migrate.HEAD = pathlib.Path(sys.argv[2]), '{AFTER}'\n"
        "store.Database.open(pathlib.Path(sys.argv[1]))\n"
    )
    done = programs.run([sys.executable, "-c", program, path, migrate.MIGRATIONS], check=False)
    assert done.returncode == -signal.SIGKILL
    assert stamp(path) == [(NOW,)]
    assert columns(path, "motion") == [
        "robot",
        "name",
        "help",
        "lead_in",
        "lead_out",
        "slot",
        "slot_s",
        "limp",
        "builtin",
    ]
    newer()
    with Database.open(path) as database:
        assert database.backup == path.with_name(f"robot.db.backup-{NOW}-2")
    assert stamp(path) == [(AFTER,)]


def test_two_programs_may_upgrade_at_once(path, newer):
    newer()
    failed: list[BaseException] = []

    def upgrade() -> None:
        try:
            Database.open(path).close()
        except BaseException as err:  # noqa: BLE001 - shown by the assertion below
            failed.append(err)

    other = threading.Thread(target=upgrade)
    with closing(sqlite3.connect(path, isolation_level=None)) as holding:
        holding.execute("BEGIN IMMEDIATE")
        other.start()
        holding.execute(f"UPDATE alembic_version SET version_num = '{AFTER}'")
        holding.execute("COMMIT")
    other.join()
    assert failed == []
    assert stamp(path) == [(AFTER,)]


@pytest.mark.parametrize("unknown", [LATER, "", "abc"])
def test_a_newer_or_unknown_schema_is_refused_and_left_alone(path, unknown):
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = ?", (unknown,))
    with pytest.raises(RowError, match=f"has the schema '{unknown}', which this version of lbr .* does not know"):
        Database.open(path)
    assert [file.name for file in path.parent.iterdir()] == ["robot.db"]


def test_an_older_schema_than_the_first_is_refused_with_the_way_to_take_its_rows_along(path):
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '0014'")
    before = path.read_bytes()
    with pytest.raises(RowError, match=r"'0014'.*`lbr db export DIR` of the lbr that made it"):
        Database.open(path)
    assert path.read_bytes() == before


def test_a_database_without_a_stamp_is_refused(path):
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("DELETE FROM alembic_version")
    with pytest.raises(RowError, match="does not know"):
        Database.open(path)


def test_a_new_database_needs_no_upgrade(tmp_path):
    create(tmp_path / "robot.db")
    with Database.open(tmp_path / "robot.db") as database:
        assert database.backup is None
