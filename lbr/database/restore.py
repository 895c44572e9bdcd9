"""Replaces a damaged or unwanted database by a copy."""

import fcntl
import os
import shutil
import tempfile
import time
from contextlib import closing, suppress
from pathlib import Path

from lbr import disk
from lbr.database import adopted, copies, identity
from lbr.database.connection import connect, sentences, settle
from lbr.database.files import check_folder, check_side_files, log_files
from lbr.database.rows import AuditRow
from lbr.database.store import Database
from lbr.database.tokens import revoked
from lbr.errors import InputError, LbrError, RowError

SQLITE_SHARED_FIRST = 0x40000002
SQLITE_SHARED_SIZE = 510
SQL_BYTES = 16 << 20
"""Of SQL, which is searched for the tables of a robot."""


def restore(path: Path, source: Path | None = None) -> tuple[Path, Path | None]:
    """Replace the database by a copy (by default the newest good one); return that, and the old file's new place.

    Revoked tokens stay revoked, as far as the old file is readable. The audit trail records the change, and nothing is
    deleted. Raise InputError if the database is in use, or without a good copy.
    """
    check_folder(path.with_name(f"{path.name}.restoring"))
    if _in_use(path):
        raise InputError(f"database {path} is in use: shut the robot down (`lbr stop`), close other programs")
    chosen = source or _newest_good(path)
    _check(chosen)
    draft = path.with_name(f"{path.name}.restoring-{os.getpid()}")
    try:
        copies.copy_whole(chosen, draft)
        aside = _aside(path) if any(file.exists() for file in (path, *log_files(path))) else None
        _complete(draft, path, chosen, aside)
        if aside is not None:
            _set_aside(path, aside)
        draft.replace(path)
        disk.sync(path.parent)
    except OSError as err:
        raise InputError(f"database {path} cannot be restored ({err.strerror}): check the folder") from err
    finally:
        for name in (draft, *log_files(draft)):
            with suppress(OSError):
                name.unlink()
    return chosen, aside


def _newest_good(path: Path) -> Path:
    stored = copies.stored(path)
    for copy in stored:
        if not copy.fault:
            return Path(copy.path)
    what = "no copy of it is kept" if not stored else f"none of its {len(stored)} copies is good"
    raise InputError(f"database {path} cannot be restored, because {what}: name a backup, or `lbr db init` starts over")


def _check(source: Path) -> None:
    """Refuse a source that is not a good database of a robot, before anything is made of it."""
    if not source.is_file():
        raise InputError(f"there is no file {source} to copy from", "unknown_name")
    with source.open("rb") as opened:
        if why := identity.as_sql(source, opened.read(SQL_BYTES)):
            raise InputError(f"{source} is not a database: {why}")
    with sentences(source), closing(connect(source)) as connection:
        fault = identity.fault(connection)
    if fault:
        raise RowError((f"{source} {fault}: `lbr db restore --list` shows the copies that are kept",))


def _complete(draft: Path, path: Path, source: Path, aside: Path | None) -> None:
    """Upgrade the copy, revoke the tokens that were revoked, and record the change as the newest edit."""
    revoked, revision = _remains(path)
    revision = max([revision, *(copy.revision for copy in copies.stored(path))])
    with Database.open(draft) as database:
        for token in database.tokens():
            if token.name in revoked and token.revoked_at is None:
                database.revoke_token(token.name)
        text = f"restored from {source.name}" + (f"; what was there before is {aside.name}" if aside else "")
        entry = AuditRow(wall_ns=time.time_ns(), kind="restored", subject="database", source="lbr db", text=text)
        database.append_events((), (entry,))
        database.outdo(revision, text)
    with sentences(draft), closing(connect(draft)) as connection:
        settle(connection)


def _remains(path: Path) -> tuple[set[str], int]:
    """Return the names of revoked tokens and the revision, as far as the file is readable; it stays as it is."""
    with tempfile.TemporaryDirectory(prefix="lbr-restore-") as place:
        copy = Path(place) / path.name
        with suppress(LbrError, OSError):
            shutil.copyfile(path, copy)
            with suppress(LbrError, FileNotFoundError):
                check_side_files(path)  # a stranger's log could make a revoked token valid again
                shutil.copyfile(log_files(path)[0], log_files(copy)[0])
            with sentences(copy), closing(connect(copy)) as connection:
                return revoked(connection), adopted.revision(connection)
    return set(), 0


def _set_aside(path: Path, aside: Path) -> None:
    with suppress(FileNotFoundError):
        aside.hardlink_to(path)  # so that there is always a file in the database's place
    for companion, kept_as in zip(log_files(path), log_files(aside), strict=True):
        with suppress(FileNotFoundError):
            companion.replace(kept_as)


def _aside(path: Path) -> Path:
    number = 1
    while (found := path.with_name(f"{path.name}.before-restore-{number}")).exists():
        number += 1
    return found


def _in_use(path: Path) -> bool:
    """Return whether another process has the database open: in WAL mode each holds SQLite's shared lock."""
    try:
        fd = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.lockf(fd, fcntl.LOCK_EX | fcntl.LOCK_NB, SQLITE_SHARED_SIZE, SQLITE_SHARED_FIRST)
    except OSError:
        return True
    else:
        return False
    finally:
        os.close(fd)
