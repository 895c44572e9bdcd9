"""A disk that is small, on a machine that lets us mount one."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support import programs


def can_mount() -> bool:
    """Say whether this machine lets us make a disk that is small."""
    if os.geteuid() != 0:
        return False
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        made = _mount(place, "1m")
        if made:
            programs.run(["umount", place], check=True)
        return made


@contextmanager
def small_disk(size: str) -> Iterator[Path]:
    """Mount a disk of that size, such as 6m, and take it away again."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        disk = Path(place) / "d"
        disk.mkdir()
        assert _mount(str(disk), size), "needs the right to mount"
        try:
            yield disk
        finally:
            programs.run(["umount", "-l", str(disk)], check=True)


def _mount(place: str, size: str) -> bool:
    made = programs.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size},mode=700", "tmpfs", place], check=False, capture_output=True
    )
    return made.returncode == 0
