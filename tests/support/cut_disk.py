"""A disk whose power can be cut: a file system of its own in a file, which is told to lose what was not synced."""

import fcntl
import os
import shutil
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support import programs
from tests.support.waiting import until

SIZE = "96M"
SHUTDOWN = 0x8004587D
"""EXT4_IOC_SHUTDOWN of the kernel's fs/ext4/ext4.h: nothing is written from now on, by whomever."""
WITHOUT_JOURNAL = 2
"""EXT4_GOING_FLAGS_NOLOGFLUSH: not even what waits for the journal's next commit."""
NEEDS = "root, loop devices and mke2fs (sudo apt install e2fsprogs)"


def possible() -> bool:
    """Say whether such a disk can be made here."""
    return os.geteuid() == 0 and Path("/dev/loop-control").exists() and shutil.which("mke2fs") is not None


class CutDisk:
    """A mounted disk; what runs on it gets errors once its power is cut."""

    def __init__(self, place: Path) -> None:
        self.image, self.at = place / "disk.img", place / "d"
        self.at.mkdir()
        programs.run(["mke2fs", "-q", "-t", "ext4", str(self.image), SIZE], check=True, capture_output=True)
        self._mount()

    def cut(self) -> None:
        """Lose what was not synced, and write nothing any more."""
        place = os.open(self.at, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.ioctl(place, SHUTDOWN, struct.pack("=I", WITHOUT_JOURNAL))
        finally:
            os.close(place)

    def back(self) -> None:
        """Mount it again, as the next start does: by its journal. Nothing may have a file open."""
        self.close()
        programs.run(["e2fsck", "-p", str(self.image)], check=True, capture_output=True)
        self._mount()

    def close(self) -> None:
        """Take it away, once what was killed on it is gone."""
        until(self._unmounted, what=f"nothing uses {self.at}")

    def _unmounted(self) -> bool:
        return programs.run(["umount", str(self.at)], check=False, capture_output=True).returncode == 0

    def _mount(self) -> None:
        programs.run(["mount", "-o", "loop", str(self.image), str(self.at)], check=True)


@contextmanager
def cut_disk(place: Path) -> Iterator[CutDisk]:
    """Have a disk for the time of a `with`."""
    disk = CutDisk(place)
    try:
        yield disk
    finally:
        disk.close()
