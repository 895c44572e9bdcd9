"""The last good copies of a database, beside it."""

import time
from contextlib import closing, suppress
from pathlib import Path

from msgspec import Struct

from lbr import disk
from lbr.database import adopted, identity
from lbr.database.connection import connect, sentences, vacuum_into
from lbr.database.reading import Problem
from lbr.database.rows import TokenRow
from lbr.database.tables import read_tables
from lbr.database.tokens import tokens
from lbr.errors import InputError, LbrError, RowError

GENERATIONS = 3


class Copy(Struct, frozen=True, kw_only=True):
    """One kept copy: `number` 1 is the newest, `fault` why it is unusable."""

    number: int
    path: str
    kept_at: str
    revision: int = 0
    digest: str = ""
    fault: str = ""


class EditedError(RowError):
    """The rows differ from those that run: they have just been edited, or the edit is refused."""


def keep(path: Path, digest: str) -> Path | None:
    """Copy a database whose rows run; return None if the newest copy holds the same. Raise RowError, or EditedError if
    its rows differ by now."""
    try:
        with disk.locked(path.parent):  # two robots may run from one database
            return _keep(path, path.with_name(f"{path.name}.good-new"), digest)
    except OSError as err:
        raise RowError((f"database {path} cannot be copied ({err.strerror}): check the folder",)) from err


def stored(path: Path, *, digested: bool = True) -> tuple[Copy, ...]:
    """Return the copies of a database, newest first; their digests are optional."""
    names = {number: _name(path, number) for number in range(1, GENERATIONS + 1)}
    return tuple(look(name, number, digested=digested) for number, name in names.items() if name.exists())


def look(path: Path, number: int = 0, *, digested: bool = True) -> Copy:
    """Return the content of a copy, and whether it is good; its digest is optional."""
    at = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(path.stat().st_mtime))
    copy = Copy(number=number, path=str(path), kept_at=at)
    if not path.is_file():  # reading a pipe would block
        return Copy(number=number, path=str(path), kept_at=at, fault=f"{path} is not a file")
    try:
        with sentences(path), closing(connect(path, changing=False)) as connection:
            if fault := identity.fault(connection):
                raise RowError((f"{path} {fault}",))
            revision = adopted.revision(connection)
            digest = adopted.digest(read_tables(connection)[0]) if digested else ""
            return Copy(number=number, path=str(path), kept_at=at, revision=revision, digest=digest)
    except LbrError as err:
        return Copy(number=copy.number, path=copy.path, kept_at=copy.kept_at, fault=str(err))


def refuse_if_lost(path: Path) -> None:
    """Raise InputError if the database is gone but has copies: a new one would not be this robot."""
    if any(_name(path, number).exists() for number in range(1, GENERATIONS + 1)):
        text = "but copies of it are: `lbr db restore` puts the last good one in its place, `lbr db init` starts over"
        raise InputError(f"database {path} is not there any more, {text}")


def lost_edits(path: Path, revision: int) -> tuple[Problem, ...]:
    """Return the problem of a database that is older than its newest copy: it lacks edits that ran."""
    newest = max((copy.revision for copy in stored(path, digested=False) if not copy.fault), default=0)
    if newest <= revision:
        return ()
    text = (
        f"the newest edits are missing, because a copy that ran has revision {newest}: the file was replaced or "
        "damaged, or robot.db-wal was taken away; `lbr db restore` puts the last good copy in its place"
    )
    return (Problem("revision", str(revision), "", text),)


def copy_whole(source: Path, target: Path) -> None:
    """Write a complete copy to the disk, readable only by its owner."""
    with sentences(source), closing(connect(source)) as connection:
        vacuum_into(connection, target)


def _keep(path: Path, draft: Path, digest: str) -> Path | None:
    draft.unlink(missing_ok=True)
    try:
        copy_whole(path, draft)
        copy = look(draft)
        if copy.fault:
            raise RowError((f"database {path} is not as it runs ({copy.fault}): not copied",))
        if copy.digest != digest:
            raise EditedError((f"database {path} is not as it runs (its rows differ): not copied",))
        newest = _name(path, 1)
        if newest.exists() and _same(newest, draft):
            return None
        for number in range(GENERATIONS - 1, 0, -1):
            if _name(path, number).exists():
                _name(path, number).replace(_name(path, number + 1))
        draft.replace(newest)
        disk.sync(path.parent)
    finally:
        with suppress(OSError):
            draft.unlink()
    return newest


def _same(one: Path, other: Path) -> bool:
    """Return whether two copies have the same rows and tokens."""
    try:
        return _content(one) == _content(other)
    except LbrError:
        return False


def _content(path: Path) -> tuple[str, int, tuple[TokenRow, ...]]:
    with sentences(path), closing(connect(path, changing=False)) as connection:
        return adopted.digest(read_tables(connection)[0]), adopted.revision(connection), tokens(connection)


def _name(path: Path, number: int) -> Path:
    return path.with_name(f"{path.name}.good-{number}")
