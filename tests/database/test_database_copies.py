"""The last good copies: kept when rows have run, put back on demand, and nothing is lost by either."""

import os
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from lbr import cli
from lbr.bus import tokens
from lbr.database import copies, identity
from lbr.database.restore import restore
from lbr.database.rows import AuditRow
from lbr.database.store import Database
from lbr.errors import InputError, LbrError, RowError
from tests.support import databases, programs

HASH = "h" * 64


def digest(path: Path) -> str:
    with Database.open(path) as database:
        return database.load("lbr").digest


def edit(path: Path, owner: str) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE robot SET owner = ? WHERE name = 'lbr'", (owner,))
        connection.commit()


def owner(path: Path) -> str:
    with Database.open(path) as database:
        return database.load("lbr").robot.owner


@pytest.fixture
def damaged(path) -> Path:
    """A database with a kept copy, cut in the middle."""
    edit(path, "somebody")
    copies.keep(path, digest(path))
    with path.open("r+b") as file:
        file.truncate(path.stat().st_size // 2)
    return path


def test_a_copy_is_whole_private_and_newest_first(path):
    edit(path, "first")
    assert copies.keep(path, digest(path)) == path.with_name("robot.db.good-1")
    edit(path, "second")
    copies.keep(path, digest(path))
    found = copies.stored(path)
    assert [(copy.number, copy.revision, copy.fault) for copy in found] == [(1, 2, ""), (2, 1, "")]
    assert [owner(Path(copy.path)) for copy in found] == ["second", "first"]
    assert path.with_name("robot.db.good-1").stat().st_mode & 0o777 == 0o600


def test_two_robots_of_one_database_keep_copies_at_the_same_moment(path):
    edit(path, "first")
    now = digest(path)
    with ThreadPoolExecutor(4) as robots:
        found = list(robots.map(lambda _one: copies.keep(path, now), range(8)))
    assert [one for one in found if one] == [path.with_name("robot.db.good-1")]
    assert [copy.fault for copy in copies.stored(path)] == [""]


def test_the_same_rows_are_copied_once(path):
    copies.keep(path, digest(path))
    with Database.open(path) as database:
        database.append_events((), [AuditRow(wall_ns=1, kind="k", subject="", source="", text="")])
        database.set_estop("lbr", engaged=True, reason="x")
    assert copies.keep(path, digest(path)) is None
    with Database.open(path) as database:
        database.add_token(databases.token("phone", "view", HASH))
    assert copies.keep(path, digest(path)) is not None


def test_a_copy_that_was_damaged_is_not_taken_for_the_rows_that_run(path):
    newest = copies.keep(path, digest(path))
    newest.write_bytes(newest.read_bytes()[:2048])
    assert copies.keep(path, digest(path)) == newest
    assert copies.stored(path)[0].fault == ""


def test_only_a_few_generations_are_kept(path):
    for n in range(6):
        edit(path, str(n))
        copies.keep(path, digest(path))
    assert [owner(Path(copy.path)) for copy in copies.stored(path)] == ["5", "4", "3"]


def test_what_is_not_what_runs_is_not_copied(path):
    before = digest(path)
    edit(path, "nobody has tried this yet")
    with pytest.raises(RowError, match="its rows differ"):
        copies.keep(path, before)
    assert copies.stored(path) == ()
    assert [file.name for file in path.parent.iterdir()] == ["robot.db"]


def test_a_damaged_database_names_the_way_out_and_restoring_keeps_it(damaged, wording):
    with pytest.raises(LbrError, match="`lbr db restore`"):
        Database.open(damaged)
    broken = damaged.read_bytes()
    chosen, aside = restore(damaged)
    assert chosen == damaged.with_name("robot.db.good-1")
    assert owner(damaged) == "somebody"
    assert aside is not None
    assert aside.read_bytes() == broken
    assert restore(damaged)[1] == damaged.with_name("robot.db.before-restore-2")
    with Database.open(damaged) as database:
        (event,) = database.audit()
        assert event.kind == "restored"
        wording(event.text)
        assert database.audit_fault() == ""


def test_who_restores_is_told_which_tokens_are_valid_in_it(damaged, capsys, wording):
    with Database.open(damaged.with_name("robot.db.good-1")) as database:
        for name in ("phone", "gone"):
            database.add_token(databases.token(name, "operate", tokens.hashed("secret")))
        database.revoke_token("gone")
    assert cli.main(["db", "restore", "--db", str(damaged)]) == 0
    wording(capsys.readouterr().out)


def test_the_newest_copy_that_is_good_is_taken(damaged):
    damaged.with_name("robot.db.good-1").replace(damaged.with_name("robot.db.good-2"))
    damaged.with_name("robot.db.good-1").write_bytes(b"SQLite format 3\0 and nothing else")
    assert copies.stored(damaged)[0].fault
    assert restore(damaged)[0] == damaged.with_name("robot.db.good-2")
    assert owner(damaged) == "somebody"


def test_a_pipe_in_a_copys_place_keeps_nobody_waiting(damaged):
    damaged.with_name("robot.db.good-1").replace(damaged.with_name("robot.db.good-2"))
    os.mkfifo(damaged.with_name("robot.db.good-1"))
    assert "is not a file" in copies.stored(damaged)[0].fault
    assert restore(damaged)[0] == damaged.with_name("robot.db.good-2")


def test_a_named_backup_is_put_back(path, tmp_path):
    edit(path, "kept")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("VACUUM INTO ?", (str(tmp_path / "mine.db"),))
    edit(path, "later")
    restore(path, tmp_path / "mine.db")
    assert owner(path) == "kept"
    assert owner(path.with_name("robot.db.before-restore-1")) == "later"


def test_what_sqlite_dumped_is_read_back_though_it_has_no_application_id(path, tmp_path):
    edit(path, "kept")
    back = tmp_path / "back.db"
    with closing(sqlite3.connect(path)) as source, closing(sqlite3.connect(back)) as target:
        target.executescript("\n".join(source.iterdump()))
        assert target.execute("PRAGMA application_id").fetchone() == (0,)
    back.chmod(0o600)
    edit(path, "later")
    restore(path, back)
    assert owner(path) == "kept"
    assert owner(back) == "kept"
    with closing(sqlite3.connect(path)) as connection:
        assert connection.execute("PRAGMA application_id").fetchone() == (identity.APPLICATION_ID,)


def test_a_source_that_is_refused_is_named_itself(path, tmp_path):
    dump, other = tmp_path / "dump.sql", tmp_path / "other.db"
    with closing(sqlite3.connect(path)) as connection:
        dump.write_text("\n".join(connection.iterdump()), "utf-8")
    with closing(sqlite3.connect(other)) as connection:
        connection.execute("CREATE TABLE robot (name)")
    before = path.read_bytes()
    with pytest.raises(InputError, match=rf"{dump} .*lbr db init --sql {dump}"):
        restore(path, dump)
    with pytest.raises(RowError, match=str(other)):
        restore(path, other)
    assert path.read_bytes() == before


def test_without_a_copy_nothing_is_touched(path):
    before = path.read_bytes()
    with pytest.raises(InputError, match="no copy of it is kept"):
        restore(path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == ["robot.db"]


def test_a_database_that_a_program_has_open_is_not_replaced(path):
    copies.keep(path, digest(path))
    with opened_elsewhere(path), pytest.raises(InputError, match="in use"):
        restore(path)
    restore(path)


def test_a_log_of_the_old_database_is_never_read_into_the_restored_one(path):
    copies.keep(path, digest(path))
    with opened_elsewhere(path, "c.execute(\"UPDATE robot SET owner = 'in the log'\"); c.commit()"):
        pass
    assert path.with_name("robot.db-wal").stat().st_size > 0
    restore(path)
    assert owner(path) == ""
    assert owner(path.with_name("robot.db.before-restore-1")) == "in the log"


def test_what_was_revoked_stays_revoked(path):
    with Database.open(path) as database:
        database.add_token(databases.token("lost", "operate", HASH))
        database.add_token(databases.token("good", "view", "i" * 64))
    copies.keep(path, digest(path))
    with Database.open(path) as database:
        database.revoke_token("lost")
    restore(path)
    with Database.open(path) as database:
        assert {token.name: token.revoked_at is None for token in database.tokens()} == {"lost": False, "good": True}


def test_a_database_that_is_gone_is_not_built_anew_while_copies_are_there(path):
    copies.refuse_if_lost(path.with_name("other.db"))
    copies.keep(path, digest(path))
    path.unlink()
    with pytest.raises(InputError, match="`lbr db restore`"):
        copies.refuse_if_lost(path)
    restore(path)
    assert owner(path) == ""


@contextmanager
def opened_elsewhere(path: Path, then: str = "pass") -> Iterator[None]:
    """Another process has it open, and is killed in the end."""
    program = (
        f"import sqlite3, sys; c = sqlite3.connect({str(path)!r}); c.execute('SELECT count(*) FROM robot').fetchone();"
        f" {then}; print('open', flush=True); sys.stdin.read()"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with programs.start([sys.executable, "-c", program], text=True, **pipes) as held:
        try:
            assert held.stdout is not None
            assert held.stdout.readline() == "open\n"
            yield
        finally:
            held.kill()


def test_a_database_without_its_newest_edits_is_told_from_one_that_was_restored(path):
    edit(path, "one")
    copies.keep(path, digest(path))
    older = path.read_bytes()
    edit(path, "two")
    copies.keep(path, digest(path))
    path.write_bytes(older)
    (problem,) = copies.lost_edits(path, 1)
    assert "a copy that ran has revision 2" in str(problem)
    restore(path, path.with_name("robot.db.good-2"))
    with Database.open(path) as database:
        rows = database.load("lbr")
    assert (rows.robot.owner, rows.revision, rows.problems) == ("one", 3, ())
    assert copies.lost_edits(path, rows.revision) == ()
