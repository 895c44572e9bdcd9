"""The emergency stop's latch beside the database: a file that exists while the stop is engaged.

A database that is locked, full, restored or damaged cannot lose the latch: at a start, either of them engages it.
"""

import errno
from collections.abc import Callable
from pathlib import Path

from lbr import disk
from lbr.database.rows import RobotRow
from lbr.database.store import Database
from lbr.errors import InputError
from lbr.messages.plain import one_line
from lbr.messages.system import EstopState

LONGEST_REASON = 1000
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
UNREADABLE = "latched, but why cannot be read"


class Latch:
    """A robot's latch, in its row and in a file, whose folder exists. `audit` writes the audit trail."""

    def __init__(self, path: Path, database: Database, robot: str, audit: Callable[[], object]) -> None:
        self._path = path
        self._database = database
        self._robot = robot
        self._audit = audit

    def state(self, row: RobotRow) -> EstopState:
        """Return the latch to start with: engaged if the row or the file is."""
        filed, engaged = read(self._path), row.estop_engaged
        return EstopState(engaged=engaged or filed is not None, reason=row.estop_reason if engaged else filed or "")

    def persist(self, engaged: bool, reason: str) -> None:
        """Write row and file, the file last for a release; raise LbrError for the part that failed."""
        if not engaged:
            self._write_row(engaged=False, reason="")
            remove(self._path)
            return
        try:
            write(self._path, reason)
        finally:
            self._write_row(engaged=True, reason=reason)

    def _write_row(self, *, engaged: bool, reason: str) -> None:
        self._audit()
        self._database.set_estop(self._robot, engaged=engaged, reason=reason)


def read(path: Path) -> str | None:
    """Return the reason in the file, None if it is released. An unreadable file counts as engaged."""
    if path.exists() and not path.is_file():  # reading could block until a writer comes
        return UNREADABLE
    try:
        with path.open("rb") as file:
            text = one_line(file.read(LONGEST_REASON * 4).decode(errors="replace"))[:LONGEST_REASON].strip()
    except FileNotFoundError:
        return None
    except OSError:
        return UNREADABLE
    return text or UNREADABLE


def write(path: Path, reason: str) -> None:
    """Write the file to the disk. A full disk still accepts the file, though not the reason."""
    try:
        try:
            disk.write(path, reason[:LONGEST_REASON].encode(errors="replace"))
        except OSError as err:
            if err.errno not in FULL:
                raise
            disk.write(path, b"")
    except OSError as err:
        raise InputError(f"{path} cannot be written ({err.strerror}): check the disk") from err


def remove(path: Path) -> None:
    """Remove the file, also from the disk, before returning."""
    try:
        path.unlink(missing_ok=True)
        disk.sync(path.parent)
    except OSError as err:
        raise InputError(f"{path} cannot be removed ({err.strerror}): check the disk") from err
