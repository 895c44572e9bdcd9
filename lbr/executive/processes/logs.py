"""Logs that processes append to. A log that is too large is cut; one older file keeps the end of the removed part."""

import contextlib
import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import IO

from lbr.errors import InputError
from lbr.messages.plain import one_line
from lbr.messages.system import Event

LIMIT_BYTES = 2_000_000
KEPT_BYTES = 256_000
CUT = b"... the beginning was cut; its end is in the file ending in .old.log\n"


def open_log(path: Path) -> IO[bytes]:
    """Open a log to append to; raise InputError unless it is a file: anything else could block until a reader comes."""
    trim(path)
    if path.exists() and not path.is_file():
        raise InputError(f"{path} is not a file, and a log is written there: move it away")
    return path.open("ab", buffering=0)


def add(directory: Path, events: Iterable[Event], log_of: Callable[[str], str]) -> None:
    """Add each part's events to its log, among its standard error; skip a log that cannot be written."""
    lines = defaultdict(list)
    for one in events:
        when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(one.wall_ns / 1e9))
        lines[log_of(one.subject)].append(one_line(f"{when} {one.subject} {one.kind}: {one.text}") + "\n")
    for name in filter(None, lines):
        with contextlib.suppress(OSError, InputError), open_log(directory / name) as log:
            log.write("".join(lines[name]).encode(errors="replace"))


def trim_all(directory: Path) -> None:
    """Trim every log in a directory; takes a millisecond at most, whatever their content."""
    for path in directory.glob("*.log"):
        if not path.name.endswith(".old.log"):
            trim(path)


def trim(path: Path) -> None:
    """Cut a log that has grown too large, while others append to it; on a full disk it is cut without a copy."""
    with contextlib.suppress(OSError):
        if path.stat().st_size <= LIMIT_BYTES:
            return
        with contextlib.suppress(OSError), path.open("rb") as log:
            log.seek(-KEPT_BYTES, os.SEEK_END)
            path.with_suffix(".old.log").write_bytes(log.read(KEPT_BYTES))
        os.truncate(path, 0)
        with path.open("ab") as log:
            log.write(CUT)
