"""The database files that lbr opens: regular, ours, and not writable for others."""

import os
import stat
from collections.abc import Iterable
from pathlib import Path

from lbr import ownership
from lbr.errors import InputError, RowError
from lbr.ownership import Fault


def check_file(path: Path) -> None:
    """Raise InputError or RowError unless the file exists and only its owner, we or root, may change it."""
    try:
        status = path.stat()
    except FileNotFoundError:
        raise InputError(f"database {path} does not exist: `lbr db init` builds one, or name another") from None
    except OSError as err:
        raise InputError(f"database {path} cannot be reached ({err.strerror}): check the path") from err
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"database {path} is not a file: name another")
    check_owners(path)
    if fault := _unwritable(path, status):
        raise RowError((f"database {path} {fault}",))


def check_owners(path: Path) -> None:
    """Raise RowError if others could change a database: its file, its folders, or SQLite's files beside it."""
    _refuse(path, ownership.database_faults(path))


def check_owner(path: Path) -> None:
    """Raise RowError if others could change a database that is read without SQLite's files beside it."""
    _refuse(path, ownership.faults(path))


def check_side_files(path: Path) -> None:
    """Raise RowError if SQLite's files beside a database are not ours."""
    _refuse(path, ownership.side_file_faults(Path(os.path.realpath(path))))


def log_files(path: Path) -> tuple[Path, Path]:
    """Return the names of SQLite's files beside an open database: the log, and its index."""
    return path.with_name(f"{path.name}-wal"), path.with_name(f"{path.name}-shm")


def check_folder(path: Path) -> None:
    """Raise RowError if others could put their files in the place of a new database."""
    _refuse(path, (*ownership.faults(path), *ownership.side_file_faults(Path(os.path.realpath(path)))))


def _refuse(path: Path, faults: Iterable[Fault]) -> None:
    problems = tuple(
        f"database {path} {fault.text}: {fault.do}" if fault.path == path else f"database {path} is not safe: {fault}"
        for fault in faults
    )
    if problems:
        raise RowError(problems)


def _unwritable(path: Path, status: os.stat_result) -> str:
    if os.statvfs(path).f_flag & os.ST_RDONLY:  # Linux makes it so when the disk or card fails
        undo = "`mount -o remount,rw` undoes it on a sound disk"
        return f"is on a file system that is read-only: `dmesg` shows the reason, {undo}"
    if not status.st_mode & 0o200 or not os.access(path, os.R_OK | os.W_OK):
        return f"is read-only for you (mode {status.st_mode & 0o777:04o}): `chmod u+rw` it"
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        return "is in a folder that is read-only for you: SQLite keeps its log beside the database"
    return ""
