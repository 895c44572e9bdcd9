"""Addresses of unix sockets whose path is longer than the kernel accepts."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LONGEST = 107
"""Bytes of `sun_path` without the zero at its end (unix(7))."""


@contextmanager
def address_of(path: str | Path) -> Iterator[str]:
    """Yield a short address for a path of any length, for bind and connect; raise OSError if its folder is missing."""
    path = Path(path)
    if len(os.fsencode(path)) <= LONGEST:
        yield str(path)
        return
    folder = os.open(path.parent, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)
