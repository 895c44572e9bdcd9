"""The emergency stop's latch beside the database: a file that is there while it is engaged.

A database that is locked, full, restored or damaged cannot lose the latch: it is engaged at a start if either says so.
"""

import errno
import os
from collections.abc import Callable
from pathlib import Path

from lbr.database.store import Database
from lbr.errors import InputError, LbrError
from lbr.messages.plain import one_line
from lbr.messages.system import EstopState

LONGEST_REASON = 1000
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
UNREADABLE = "latched, but why cannot be read"


class Latch:
    """The file of one robot's latch; `path` is in a folder that exists."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def reason(self) -> str | None:
        """Return why it is engaged, None if it is not; a file that cannot be read says engaged."""
        if self.path.exists() and not self.path.is_file():  # reading could wait for a writer
            return UNREADABLE
        try:
            with self.path.open("rb") as file:
                text = one_line(file.read(LONGEST_REASON * 4).decode(errors="replace"))[:LONGEST_REASON].strip()
        except FileNotFoundError:
            return None
        except OSError:
            return UNREADABLE
        return text or UNREADABLE

    def engage(self, reason: str) -> None:
        """Write it down; on return it is on the disk. A full disk still takes the file, if not the reason."""
        new = self.path.with_suffix(".new")
        try:
            fd = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
            try:
                self._write(fd, reason[:LONGEST_REASON].encode(errors="replace"))
            finally:
                os.close(fd)
            new.replace(self.path)
            self._sync_folder()
        except OSError as err:
            raise InputError(f"{self.path} cannot be written ({err.strerror}): check the disk") from err

    def release(self) -> None:
        """Take it away; on return that is on the disk."""
        try:
            self.path.unlink(missing_ok=True)
            self._sync_folder()
        except OSError as err:
            raise InputError(f"{self.path} cannot be removed ({err.strerror}): check the disk") from err

    @staticmethod
    def _write(fd: int, reason: bytes) -> None:
        try:
            os.write(fd, reason)
        except OSError as err:
            if err.errno not in FULL:
                raise
        os.fsync(fd)

    def _sync_folder(self) -> None:
        fd = os.open(self.path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)


class LatchKeeper:
    """Keeps a robot's latch in both places, its file and its row. `audit` writes the audit trail down."""

    def __init__(self, latch: Latch, database: Database, robot: str, audit: Callable[[], object]) -> None:
        self._latch = latch
        self._database = database
        self._robot = robot
        self._audit = audit

    def state(self, *, engaged: bool, reason: str) -> EstopState:
        """Return the latch to start with: engaged if the row, which is given, or the file says so."""
        filed = self._latch.reason()
        return EstopState(engaged=engaged or filed is not None, reason=reason if engaged else filed or "")

    def persist(self, engaged: bool, reason: str) -> None:
        """Write it down in both places; raise LbrError saying what did not work. A release is filed last."""
        if not engaged:
            self._audit()
            self._database.set_estop(self._robot, engaged=False, reason="")
            self._latch.release()
            return
        fault: LbrError | None = None
        for keep in (self._latch.engage, self._in_row):
            try:
                keep(reason)
            except LbrError as err:
                fault = err
        if fault is not None:
            raise fault

    def _in_row(self, reason: str) -> None:
        self._audit()
        self._database.set_estop(self._robot, engaged=True, reason=reason)
