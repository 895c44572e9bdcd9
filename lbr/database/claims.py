"""The robots that run from a database: each locks a byte of the file that SQLite does not use."""

import fcntl
import os
import struct
import zlib
from pathlib import Path

from lbr.errors import AlreadyRunningError

FIRST = 1 << 61
"""Far beyond all bytes that SQLite writes and locks."""
COUNT = 1 << 32
FLOCK = "hhqqi4x"
"""The kernel's `struct flock`."""


class Claim:
    """The right of one run to a robot's rows: another home may name the same file. The kernel frees it with the
    process."""

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._fd = -1

    def take(self, database: Path) -> None:
        """Claim this robot of an open database; raise AlreadyRunningError if it runs from there.

        The descriptor stays open until `release`, after the database: closing it would also drop SQLite's locks.
        """
        self._fd = os.open(database, os.O_RDWR | os.O_CLOEXEC)
        byte = FIRST + zlib.crc32(self._robot.encode())
        try:
            fcntl.fcntl(self._fd, fcntl.F_OFD_SETLK, struct.pack(FLOCK, fcntl.F_WRLCK, os.SEEK_SET, byte, 1, 0))
        except (BlockingIOError, PermissionError) as err:
            raise AlreadyRunningError(
                f"robot '{self._robot}' already runs from {database}, in another home: end it there, or run from a copy"
            ) from err
        except OSError:
            return  # a file system that cannot lock

    def release(self) -> None:
        """Release the claim."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1


def any_robot(database: Path) -> bool:
    """Return whether any robot runs from an open database, of this version of lbr or an older one.

    Its descriptor stays open for the same reason.
    """
    fd = os.open(database, os.O_RDWR | os.O_CLOEXEC)
    try:
        found = fcntl.fcntl(fd, fcntl.F_OFD_GETLK, struct.pack(FLOCK, fcntl.F_WRLCK, os.SEEK_SET, FIRST, COUNT, 0))
    except OSError:
        return False  # a file system that cannot lock
    return bool(struct.unpack(FLOCK, found)[0] != fcntl.F_UNLCK)
