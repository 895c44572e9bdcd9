"""Addresses of unix sockets whose path is longer than the kernel takes at once."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LONGEST = 107
"""Bytes of `sun_path` but for the zero at its end (unix(7))."""


@contextmanager
def address_of(path: str | Path) -> Iterator[str]:
    """Yield what bind and connect take for a path of any length, for as long as they need it; OSError: its folder is
    not there."""
    path = Path(path)
    if len(os.fsencode(path)) <= LONGEST:
        yield str(path)
        return
    folder = os.open(path.parent, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)
