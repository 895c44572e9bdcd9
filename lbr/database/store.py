"""The database file: create, open with every check, and what the executive reads and writes while it runs."""

import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from lbr.database.rows import RevisionRow, RobotRows
from lbr.messages.system import Event


def create(path: Path, sql: Path | None = None) -> None:
    """Build a new database from `sql` (the shipped robot.db.sql); raise InputError if the file is there already."""
    raise NotImplementedError


class Database:
    """An open robot database: one connection, safe to use from several threads, short transactions."""

    def __init__(self, path: Path, *, wall_ns: Callable[[], int] = time.time_ns) -> None:
        self.path = path
        self._wall_ns = wall_ns

    @classmethod
    def open(cls, path: Path, *, wall_ns: Callable[[], int] = time.time_ns) -> Self:
        """Check, back up and upgrade if it is older, and open; raise RowError or InputError saying what to do."""
        raise NotImplementedError

    def data_version(self) -> int:
        """Return a number that changes when another connection has committed; our own writes leave it."""
        raise NotImplementedError

    def robots(self) -> tuple[str, ...]:
        """Return the names of all robots in the file."""
        raise NotImplementedError

    def load(self, robot: str) -> RobotRows:
        """Read a robot's rows in one transaction; bad rows become problems, only an unreadable file raises RowError."""
        raise NotImplementedError

    def append_events(self, events: Iterable[Event]) -> None:
        """Write events down in one transaction; a `wall_ns` of 0 becomes now."""
        raise NotImplementedError

    def events(self, limit: int = 100) -> tuple[Event, ...]:
        """Return the newest events, oldest first."""
        raise NotImplementedError

    def record_start(self, robot: str) -> None:
        """Write down that the robot started now."""
        raise NotImplementedError

    def record_shutdown(self, robot: str) -> None:
        """Write down that the robot shut down in order now."""
        raise NotImplementedError

    def set_estop(self, robot: str, *, engaged: bool, reason: str) -> None:
        """Latch or release the emergency stop; on return it is on the disk."""
        raise NotImplementedError

    def save_calibration(self, robot: str, device: str, values: dict[str, float]) -> None:
        """Write a device's calibration, all of it or none; on return it is on the disk."""
        raise NotImplementedError

    def revisions(self, since: int = 0) -> Sequence[RevisionRow]:
        """Return every change of rows after revision `since`, oldest first."""
        raise NotImplementedError

    def close(self) -> None:
        """Let go of the file; cheap to repeat."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
