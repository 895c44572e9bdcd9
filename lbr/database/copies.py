"""The last good copies of a database beside it, and putting one back."""

import fcntl
import os
import shutil
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from msgspec import Struct

from lbr.database import adopted
from lbr.database.connection import connect, damage, run, sentences
from lbr.database.rows import AuditRow, TokenRow
from lbr.database.store import APPLICATION_ID, Database
from lbr.database.tables import read_tables
from lbr.database.tokens import tokens
from lbr.errors import InputError, LbrError, RowError

GENERATIONS = 3
SQLITE_SHARED_FIRST = 0x40000002
SQLITE_SHARED_SIZE = 510


class Copy(Struct, frozen=True, kw_only=True):
    """One kept copy: `number` 1 is the newest, `fault` says why it is no good."""

    number: int
    path: str
    kept_at: str
    revision: int = 0
    digest: str = ""
    fault: str = ""


def keep(path: Path, digest: str) -> Path | None:
    """Copy a database whose rows are known to run; None if the newest copy holds the same. Raises RowError."""
    new = path.with_name(f"{path.name}.good-new")
    new.unlink(missing_ok=True)
    try:
        _copy(path, new)
        found = look(new)
        if found.fault or found.digest != digest:
            raise RowError((f"database {path} is not as it runs ({found.fault or 'its rows differ'}): not copied",))
        newest = _name(path, 1)
        if newest.exists() and _same(newest, new):
            return None
        for number in range(GENERATIONS - 1, 0, -1):
            if _name(path, number).exists():
                _name(path, number).replace(_name(path, number + 1))
        new.replace(newest)
        _sync(path.parent)
    except OSError as err:
        raise RowError((f"database {path} cannot be copied ({err.strerror}): check the folder",)) from err
    finally:
        with suppress(OSError):
            new.unlink()
    return newest


def kept(path: Path) -> tuple[Copy, ...]:
    """Return the copies of a database, newest first."""
    return tuple(
        look(_name(path, number), number) for number in range(1, GENERATIONS + 1) if _name(path, number).exists()
    )


def look(path: Path, number: int = 0) -> Copy:
    """Return what a copy holds, and whether it is good."""
    at = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(path.stat().st_mtime))
    copy = Copy(number=number, path=str(path), kept_at=at)
    try:
        with sentences(path), connect(path, changing=False) as connection:
            if run(connection, "PRAGMA application_id") != APPLICATION_ID:
                raise RowError((f"{path} is no robot's database",))
            if fault := damage(connection):
                raise RowError((f"{path} is damaged ({fault[:100]})",))
            tables, _ = read_tables(connection)
            return Copy(
                number=number,
                path=str(path),
                kept_at=at,
                revision=adopted.revision(connection),
                digest=adopted.digest(tables),
            )
    except LbrError as err:
        return Copy(number=copy.number, path=copy.path, kept_at=copy.kept_at, fault=str(err))


def restore(path: Path, source: Path | None = None) -> tuple[Path, Path | None]:
    """Put a copy (the newest good one) in the database's place; return it, and where the file before it is now.

    What has been revoked stays revoked, the audit trail tells of it, and nothing is deleted. Raises InputError if the
    database is in use, or if there is no good copy.
    """
    if _in_use(path):
        raise InputError(f"database {path} is in use: shut the robot down (`lbr stop`), close other programs")
    chosen = source or _newest_good(path)
    new = path.with_name(f"{path.name}.restoring-{os.getpid()}")
    try:
        _copy(chosen, new)
        aside = _aside(path) if any(file.exists() for file in (path, *_companions(path))) else None
        _complete(new, path, chosen, aside)
        if aside is not None:
            _set_aside(path, aside)
        new.replace(path)
        _sync(path.parent)
    except OSError as err:
        raise InputError(f"database {path} cannot be restored ({err.strerror}): check the folder") from err
    finally:
        for name in (new, *_companions(new)):
            with suppress(OSError):
                name.unlink()
    return chosen, aside


def refuse_if_lost(path: Path) -> None:
    """Raise InputError if a database that is not there was there before: building another would be another robot."""
    if any(_name(path, number).exists() for number in range(1, GENERATIONS + 1)):
        text = "but copies of it are: `lbr db restore` puts the last good one in its place, `lbr db init` begins anew"
        raise InputError(f"database {path} is not there any more, {text}")


def _newest_good(path: Path) -> Path:
    copies = kept(path)
    for copy in copies:
        if not copy.fault:
            return Path(copy.path)
    what = "no copy of it is kept" if not copies else f"none of its {len(copies)} copies is good"
    raise InputError(f"database {path} cannot be restored, because {what}: name a backup, or `lbr db init` begins anew")


def _copy(source: Path, target: Path) -> None:
    """Write a whole copy, readable by its owner alone, that is on the disk on return."""
    if not source.exists():
        raise InputError(f"there is no {source} to copy from")
    os.close(os.open(target, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600))
    with sentences(source), connect(source) as connection:
        run(connection, "VACUUM INTO ?", str(target))
    with target.open("rb") as written:
        os.fsync(written.fileno())


def _same(one: Path, other: Path) -> bool:
    """Say whether two copies hold the same rows and tokens."""
    try:
        return _content(one) == _content(other)
    except LbrError:
        return False


def _content(path: Path) -> tuple[str, int, tuple[TokenRow, ...]]:
    with sentences(path), connect(path, changing=False) as connection:
        return adopted.digest(read_tables(connection)[0]), adopted.revision(connection), tokens(connection)


def _complete(new: Path, path: Path, source: Path, aside: Path | None) -> None:
    """Bring the copy up to date, keep revoked what was revoked, and write the restoring down."""
    revoked = _revoked(path)
    with Database.open(new) as database:
        for token in database.tokens():
            if token.name in revoked and token.revoked_at is None:
                database.revoke_token(token.name)
        text = f"restored from {source.name}" + (f"; what was there before is {aside.name}" if aside else "")
        entry = AuditRow(wall_ns=time.time_ns(), kind="restored", subject="database", source="lbr db", text=text)
        database.append_events((), (entry,))


def _revoked(path: Path) -> set[str]:
    """Return the names of revoked tokens, as far as the file can still be read; the file is left as it is."""
    with tempfile.TemporaryDirectory(prefix="lbr-restore-") as place:
        copy = Path(place) / path.name
        with suppress(LbrError, OSError):
            for file, target in zip((path, *_companions(path)[:1]), (copy, *_companions(copy)[:1]), strict=True):
                if file.exists():
                    shutil.copyfile(file, target)
            with sentences(copy), connect(copy) as connection:
                return {token.name for token in tokens(connection) if token.revoked_at is not None}
    return set()


def _set_aside(path: Path, aside: Path) -> None:
    with suppress(FileNotFoundError):
        aside.hardlink_to(path)  # so that there is always a file in the database's place
    for companion, kept_as in zip(_companions(path), _companions(aside), strict=True):
        with suppress(FileNotFoundError):
            companion.replace(kept_as)


def _aside(path: Path) -> Path:
    number = 1
    while (found := path.with_name(f"{path.name}.before-restore-{number}")).exists():
        number += 1
    return found


def _companions(path: Path) -> tuple[Path, Path]:
    return path.with_name(f"{path.name}-wal"), path.with_name(f"{path.name}-shm")


def _in_use(path: Path) -> bool:
    """Say whether another process has the database open; in WAL mode each keeps SQLite's shared lock."""
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


def _name(path: Path, number: int) -> Path:
    return path.with_name(f"{path.name}.good-{number}")


def _sync(folder: Path) -> None:
    fd = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)
