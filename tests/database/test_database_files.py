"""Files that are refused, each with one sentence that says what to do."""

import os
import sqlite3
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr import ownership
from lbr.database import connection, copies
from lbr.database.restore import restore
from lbr.database.store import Database, create
from lbr.errors import InputError, LbrError, RowError
from lbr.messages.system import Event
from tests.support import databases, needs
from tests.support.small_disk import can_mount, small_disk

AS_ROOT = needs.root("can give files away")


def refusal(path) -> str:
    with pytest.raises(LbrError) as err:
        Database.open(path)
    text = str(err.value)
    assert "\n" not in text
    assert str(path) in text
    return text


def plain(path, *statements):
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        for statement in statements:
            other.execute(statement)


def test_a_missing_file(tmp_path, wording):
    with wording.of(InputError):
        Database.open(tmp_path / "robot.db")
    assert list(tmp_path.iterdir()) == []


def test_a_folder(tmp_path):
    assert "is not a file" in refusal(tmp_path)


def test_a_path_through_a_file(path):
    assert "cannot be reached" in refusal(path / "robot.db")


@pytest.mark.parametrize("mode", [0o602, 0o620, 0o666])
def test_a_file_that_others_may_change(path, mode, wording):
    path.chmod(mode)
    wording(refusal(path))


def test_a_file_that_others_may_read_is_taken(path):
    path.chmod(0o644)
    with Database.open(path) as database:
        assert database.robots() == ("bioloid", "lbr", "uxa90")


def test_a_folder_where_others_may_replace_it(path, wording):
    path.parent.chmod(0o777)
    wording(refusal(path))


def test_a_shared_folder_with_the_sticky_bit_is_taken(path):
    path.parent.chmod(0o1777)
    Database.open(path).close()


@AS_ROOT
def test_a_file_of_somebody_else(path):
    os.chown(path, 4321, 4321)
    assert "belongs to user 4321 (mode 0600)" in refusal(path)


@AS_ROOT
@pytest.mark.parametrize("mode", [0o700, 0o755, 0o1777, 0o777])
@pytest.mark.parametrize("end", ownership.SIDE_FILES)
def test_a_strangers_log_beside_a_database_is_not_taken_in(path, mode, end):
    stranger = path.with_name(f"{path.name}{end}")
    stranger.write_bytes(with_a_token_of_mine(path) if end == "-wal" else b"whatever")
    os.chown(stranger, 4321, 4321)
    path.parent.chmod(mode)
    before = stranger.read_bytes()
    text = " ".join(refusals(path))
    assert f"{stranger} belongs to user 4321" in text
    assert f"`sudo rm {stranger}`" in text
    assert stranger.read_bytes() == before
    stranger.unlink()
    path.parent.chmod(0o700)
    with Database.open(path) as database:
        assert database.tokens() == ()


@pytest.mark.parametrize("how", ["link", "hard link", "others may change it", "fifo"])
def test_a_log_that_is_not_ours_alone(path, how):
    log, other = path.with_name(f"{path.name}-wal"), path.with_name("other")
    other.write_bytes(with_a_token_of_mine(path))
    if how == "link":
        log.symlink_to(other)
    elif how == "hard link":
        log.hardlink_to(other)
    elif how == "fifo":
        os.mkfifo(log, 0o600)
    else:
        log.write_bytes(other.read_bytes())
        log.chmod(0o620)
    assert f"{log} " in refusal(path)


def test_a_log_that_comes_between_the_check_and_the_opening_is_not_taken_in(path, monkeypatch):
    log, content = path.with_name(f"{path.name}-wal"), with_a_token_of_mine(path)
    looked = connection.check_owners

    def planted(database):
        looked(database)
        log.write_bytes(content)
        log.chmod(0o666)

    monkeypatch.setattr(connection, "check_owners", planted)
    assert f"{log} may be changed by others" in refusal(path)


def test_a_second_name_of_a_database(path):
    path.with_name("second.db").hardlink_to(path)
    assert f"`cp {path} {path}.own && mv {path}.own {path}`" in refusal(path)


def test_the_name_under_which_it_was_built_is_no_second_one(path):
    path.with_name(f"{path.name}.new-17").hardlink_to(path)
    Database.open(path).close()


@AS_ROOT
@pytest.mark.parametrize("owner", [4321, 0])
def test_a_folder_further_up_where_somebody_could_swap_the_way(tmp_path, owner):
    folder = tmp_path / "shared" / "mine"
    folder.mkdir(parents=True)
    databases.fresh(folder / "robot.db")
    os.chown(tmp_path / "shared", owner, owner)
    (tmp_path / "shared").chmod(0o755 if owner else 0o777)
    assert f"{tmp_path / 'shared'} " in refusal(folder / "robot.db")


@AS_ROOT
def test_a_link_of_somebody_else_to_a_database_of_ours(path, tmp_path):
    link = tmp_path / "link.db"
    link.symlink_to(path)
    Database.open(link).close()
    os.chown(link, 4321, 4321, follow_symlinks=False)
    assert "is a link of user 4321" in refusal(link)


def test_no_database_is_built_where_others_may_replace_it(tmp_path, wording):
    tmp_path.chmod(0o775)
    with wording.of(RowError):
        create(tmp_path / "robot.db")
    assert list(tmp_path.iterdir()) == []


@AS_ROOT
def test_a_copy_of_somebody_else_is_no_good_copy(path):
    copies.keep(path, digest_of(path))
    good = path.with_name(f"{path.name}.good-1")
    os.chown(good, 4321, 4321)
    (kept,) = copies.stored(path)
    assert "belongs to user 4321" in kept.fault
    with pytest.raises(InputError, match="none of its 1 copies is good"):
        restore(path)


def with_a_token_of_mine(path) -> bytes:
    """A log that belongs to the database, and would let in whoever wrote it."""
    copy = path.with_name("copy.db")
    copy.write_bytes(path.read_bytes())
    row = ("mine", "admin", "x" * 40, "2026-01-01T00:00:00Z")
    with closing(sqlite3.connect(copy, isolation_level=None)) as other:
        other.execute("INSERT INTO user_token (name, role, hash, created_at) VALUES (?, ?, ?, ?)", row)
        return copy.with_name(f"{copy.name}-wal").read_bytes()


def refusals(path) -> tuple[str, ...]:
    with pytest.raises(RowError) as err:
        Database.open(path)
    return err.value.problems


def digest_of(path) -> str:
    with Database.open(path) as database:
        return database.load("lbr").digest


def test_a_file_that_is_read_only(path, wording):
    path.chmod(0o400)
    wording(refusal(path))


def test_a_file_on_a_disk_that_is_read_only_is_not_blamed_on_its_mode(path, monkeypatch, wording):
    mounted = os.statvfs(path)
    values = [*mounted]
    values[8] |= os.ST_RDONLY
    monkeypatch.setattr(os, "statvfs", lambda _path: os.statvfs_result(values))
    said = refusal(path)
    wording(said)
    assert "chmod" not in said


def test_an_empty_file(tmp_path, wording):
    path = tmp_path / "robot.db"
    path.touch(0o600)
    wording(refusal(path))


def test_a_text(tmp_path):
    path = tmp_path / "robot.db"
    path.write_text("This is not a database, although it is long enough to hold a header. " * 100)
    path.chmod(0o600)
    assert "is no database at all" in refusal(path)


def test_a_database_of_another_program(tmp_path):
    path = tmp_path / "robot.db"
    plain(path, "CREATE TABLE robot (name)", "CREATE TABLE alembic_version (version_num)")
    path.chmod(0o600)
    before = path.read_bytes()
    assert "is not a robot's" in refusal(path)
    assert path.read_bytes() == before


def test_a_robot_database_without_tables(tmp_path):
    path = tmp_path / "robot.db"
    plain(path, "PRAGMA application_id = 0x4C425231", "CREATE TABLE x (y)")
    path.chmod(0o600)
    assert "is not a robot's" in refusal(path)


def test_a_damaged_file(path):
    raw = bytearray(path.read_bytes())
    for offset in range(4096, len(raw), 4096):
        raw[offset : offset + 200] = b"\xa5" * 200
    path.write_bytes(raw)
    assert "is damaged" in refusal(path)


@pytest.mark.parametrize("kept", [0.05, 0.3, 0.6, 0.95])
def test_a_truncated_file(path, kept):
    raw = path.read_bytes()
    path.write_bytes(raw[: int(len(raw) * kept)])
    assert "`lbr db restore`" in refusal(path)


@pytest.fixture(scope="module")
def pristine(tmp_path_factory):
    return databases.fresh(tmp_path_factory.mktemp("pristine") / "robot.db").read_bytes()


@given(flips=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 7)), min_size=1, max_size=20))
def test_flipped_bits_are_refused_or_read(pristine, tmp_path_factory, flips):
    raw = bytearray(pristine)
    for where, bit in flips:
        raw[int(where * len(raw))] ^= 1 << bit
    path = tmp_path_factory.mktemp("flipped") / "robot.db"
    path.write_bytes(raw)
    path.chmod(0o600)
    refused = []
    try:
        with Database.open(path) as database:
            problems = database.load("lbr").problems
    except RowError as err:
        refused = list(err.problems)
        problems = ()
    assert all(str(path) in sentence and sentence.isprintable() for sentence in refused)
    assert all(problem.table for problem in problems)


def test_a_damaged_schema_whose_error_is_no_text(path):
    raw = path.read_bytes()
    path.write_bytes(raw.replace(b"kind     TEXT", b"kind\xa0    TEXT", 1))
    assert "is damaged: `lbr db restore`" in refusal(path)


def test_a_file_that_another_program_keeps_to_itself(path, monkeypatch, wording):
    monkeypatch.setattr(connection, "BUSY_TIMEOUT_S", 0.1)
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("PRAGMA locking_mode = EXCLUSIVE")
        other.execute("UPDATE robot SET owner = 'x'")
        wording(refusal(path))


def test_a_write_lock_that_is_never_released_is_an_error_not_a_hang(path, database, wording):
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        assert database.load("lbr").problems == ()
        with wording.of(RowError):
            database.record_start("lbr")
        with wording.of(RowError):
            database.append_events([Event(kind="k", subject="s", text="t")])
        other.execute("ROLLBACK")
    database.record_start("lbr")
    assert database.load("lbr").robot.last_start


def test_creating_never_overwrites(path):
    before = path.read_bytes()
    with pytest.raises(InputError, match="exists already"):
        create(path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == ["robot.db"]


def test_a_new_database_and_its_folder_are_for_their_owner_alone(tmp_path):
    path = tmp_path / "home" / "robot.db"
    create(path)
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700


def test_creating_in_a_place_that_cannot_be_is_an_input_error(path):
    with pytest.raises(InputError, match="cannot be built"):
        create(path / "robot.db")


def test_sql_with_a_mistake_leaves_nothing_behind(tmp_path):
    sql = tmp_path / "bad.sql"
    sql.write_text("CREATE TABLE robot (name TEXT) STRICT; CREATE TABEL x;")
    with pytest.raises(RowError, match="syntax error"):
        create(tmp_path / "robot.db", sql)
    assert [file.name for file in tmp_path.iterdir()] == ["bad.sql"]


@pytest.mark.parametrize("size_kb", range(256, 1537, 128))
def test_a_disk_too_small_for_a_new_database_gets_a_whole_one_or_none(size_kb):
    if not can_mount():
        pytest.skip("needs the right to mount a small disk")
    with small_disk(f"{size_kb}k") as disk:
        refused = ""
        try:
            create(disk / "robot.db")
        except RowError as err:
            refused = str(err)
        if refused:
            assert "disk is full" in refused
            assert list(disk.iterdir()) == []
        else:
            with closing(sqlite3.connect(f"file:{disk / 'robot.db'}?immutable=1", uri=True)) as reader:
                assert connection.damage(reader) == ""
                assert reader.execute("SELECT name FROM robot WHERE name = 'lbr'").fetchone()
