"""The lines that the robot's processes write to their logs."""

import contextlib
import os
from collections.abc import Collection, Iterator
from pathlib import Path

MOST_BYTES = 256_000
"""The most bytes of one log in one round; the rest is left out, and a line marks the gap."""
LONGEST = 4000


class Logs:
    """Follows the logs of one robot, from their present ends."""

    def __init__(self, folder: Path, robot: str) -> None:
        self._folder = folder
        self._prefix = f"{robot}-"
        self._read: dict[str, int] = {}
        self._rest: dict[str, bytes] = {}
        for name, size in self._sizes(()):
            self._read[name] = size

    def take(self, programs: Collection[str]) -> Iterator[tuple[str, str]]:
        """Yield the writer and text of each new line; `programs` are external commands, whose logs name no robot."""
        for name, size in self._sizes(programs):
            begun = self._read.get(name, 0)
            if size == begun:
                continue
            if size < begun:
                begun, self._rest[name] = 0, b""
            who = name.removeprefix(self._prefix).removesuffix(".log")
            for line in self._lines(name, begun, size):
                yield who, line.decode(errors="replace")[:LONGEST]

    def _lines(self, name: str, begun: int, size: int) -> Iterator[bytes]:
        start = max(begun, size - MOST_BYTES)
        if start > begun:
            yield b"... %d bytes of this log came too fast and are in its file alone" % (start - begun)
            self._rest[name] = b""
        try:
            with (self._folder / name).open("rb") as log:
                log.seek(start)
                data = self._rest.get(name, b"") + log.read(size - start)
        except OSError:
            return
        self._read[name] = size
        *lines, rest = data.split(b"\n")
        self._rest[name] = rest if len(rest) <= LONGEST else b""
        yield from lines
        if len(rest) > LONGEST:
            yield rest

    def _sizes(self, programs: Collection[str]) -> Iterator[tuple[str, int]]:
        with contextlib.suppress(OSError), os.scandir(self._folder) as entries:
            for entry in entries:
                own = entry.name.startswith(self._prefix) or entry.name.removesuffix(".log") in programs
                if own and entry.name.endswith(".log") and not entry.name.endswith(".old.log"):
                    with contextlib.suppress(OSError):
                        yield entry.name, entry.stat().st_size
