"""Writes a recording to the disk in whole, synced chunks; a chunk that fails halfway is truncated."""

import contextlib
import fcntl
import os
from collections.abc import Mapping
from pathlib import Path

from lbr import disk
from lbr.apps.recorder.recording import chunks


class Segment:
    """A file under way, locked so that other processes know it is in use.

    Each method but `finish` and `close` raises OSError if the disk is full or gone.
    """

    def __init__(self, path: Path, library: str, about: Mapping[str, str]) -> None:
        self.path = path
        self.size = 0
        self._fd = disk.create(path)
        try:
            with contextlib.suppress(OSError):  # a file system without locks
                fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._append(chunks.beginning(library, about))
            os.fsync(self._fd)
            disk.sync(path.parent)
        except OSError:
            self.close()
            with contextlib.suppress(OSError):
                path.unlink()  # a file without its beginning would block the next try
            raise

    def write(self, chunk: bytes) -> None:
        """Write a chunk and sync it; raise OSError if that fails."""
        self._append(chunk)
        os.fdatasync(self._fd)

    def finish(self) -> None:
        """Write the ending, if the disk allows it, and close the file."""
        with contextlib.suppress(OSError):
            self._append(chunks.ending())
            os.fdatasync(self._fd)
        self.close()

    def close(self) -> None:
        """Close the file without an ending."""
        fd, self._fd = self._fd, -1
        if fd >= 0:
            with contextlib.suppress(OSError):
                os.close(fd)

    def _append(self, data: bytes) -> None:
        begun, rest = self.size, memoryview(data)
        try:
            while rest:
                rest = rest[os.pwrite(self._fd, rest, self.size) :]
                self.size = begun + len(data) - len(rest)
        except OSError:
            self.size = begun
            with contextlib.suppress(OSError):
                os.ftruncate(self._fd, begun)
            raise
