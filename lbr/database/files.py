"""Which database files lbr opens at all: regular, ours, and writable by nobody else."""

import os
import stat
from pathlib import Path

from lbr.errors import InputError, RowError


def check_file(path: Path) -> None:
    """Raise InputError or RowError unless the file exists and only its owner, we or root, may change it."""
    try:
        found = path.stat()
    except FileNotFoundError:
        raise InputError(f"database {path} does not exist: `lbr db init` builds one, or name another") from None
    except OSError as err:
        raise InputError(f"database {path} cannot be reached ({err.strerror}): check the path") from err
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"database {path} is not a file: name another")
    fault = _fault(path, found)
    if fault:
        raise RowError((f"database {path} {fault}",))


def _fault(path: Path, found: os.stat_result) -> str:
    if found.st_uid not in (os.geteuid(), 0):
        return f"belongs to user {found.st_uid}, who could put anything into it: copy it, or `chown` it to yourself"
    if found.st_mode & 0o022:
        return f"may be changed by others (mode {found.st_mode & 0o777:04o}): `chmod go-w` it, having checked its rows"
    folder = path.absolute().parent.stat()
    if folder.st_mode & 0o002 and not folder.st_mode & stat.S_ISVTX:
        return "is in a folder where anyone may replace it: `chmod o-w` the folder"
    if not found.st_mode & 0o200 or not os.access(path, os.R_OK | os.W_OK):
        return f"is read-only for you (mode {found.st_mode & 0o777:04o}): `chmod u+rw` it"
    if not os.access(path.absolute().parent, os.W_OK | os.X_OK):
        return "is in a folder that is read-only for you: SQLite keeps its log beside the database"
    return ""
