"""Logs that processes append to: bounded while they are written, with the end of what was cut kept in one older file."""

import contextlib
import os
from pathlib import Path
from typing import IO

from lbr.errors import InputError

LIMIT_BYTES = 2_000_000
KEPT_BYTES = 256_000
CUT = b"... the beginning was cut; its end is in the file ending in .old.log\n"


def open_log(path: Path) -> IO[bytes]:
    """Open a log to append to; InputError for what is no file, where opening or writing could wait for a reader."""
    trim(path)
    if path.exists() and not path.is_file():
        raise InputError(f"{path} is not a file, and a log is written there: move it away")
    return path.open("ab", buffering=0)


def trim_all(directory: Path) -> None:
    """Trim every log in a directory; takes a millisecond at most, whatever is written there."""
    for path in directory.glob("*.log"):
        if not path.name.endswith(".old.log"):
            trim(path)


def trim(path: Path) -> None:
    """Cut a log that has grown too large, while others go on appending to it; a full disk does not keep it long."""
    with contextlib.suppress(OSError):
        if path.stat().st_size <= LIMIT_BYTES:
            return
        with contextlib.suppress(OSError), path.open("rb") as log:
            log.seek(-KEPT_BYTES, os.SEEK_END)
            path.with_suffix(".old.log").write_bytes(log.read(KEPT_BYTES))
        os.truncate(path, 0)
        with path.open("ab") as log:
            log.write(CUT)
