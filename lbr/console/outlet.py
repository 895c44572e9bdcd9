"""Output that no caller waits for: a thread of its own writes it; unread output is dropped and counted."""

import contextlib
import os
import select
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import IO, cast

LIMIT_BYTES = 1_000_000
CHUNK_BYTES = 256
"""The size of one write, so that a terminal of 9600 baud shows progress every 0.3 s."""
ROOM_S = 0.1
ERROR_S = 0.1
LAST_OUTPUT_S = 0.3


class Outlet:
    """Writes bytes to file descriptors in order. `write` never blocks: beyond `limit` waiting bytes it refuses."""

    def __init__(self, *, limit: int = LIMIT_BYTES) -> None:
        self.taken: Callable[[], None] = lambda: None
        self._limit = limit
        self._changed = threading.Condition()
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._size = 0
        self._since: float | None = None
        self._own: dict[int, int] = {}
        self._errors: dict[int, OSError] = {}
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="outlet", daemon=True)

    @property
    def waiting(self) -> int:
        """Return the number of bytes that are not written yet."""
        return self._size

    @property
    def stuck_s(self) -> float:
        """Return how long no waiting byte has been written."""
        since = self._since
        return 0.0 if since is None else time.monotonic() - since

    def error(self, fd: int) -> OSError | None:
        """Return why the descriptor accepts no more, if so."""
        return self._errors.get(fd)

    def write(self, fd: int, data: bytes) -> bool:
        """Queue bytes for a descriptor; return whether there was room. A broken descriptor accepts them, too."""
        with self._changed:
            if not data or self._closed or fd in self._errors:
                return True
            if self._size and self._size + len(data) > self._limit:
                return False
            if fd not in self._own and not self._opened(fd):
                return True
            self._waiting.append((fd, data))
            self._size += len(data)
            if self._thread.ident is None:
                self._thread.start()
            self._changed.notify_all()
        return True

    def drain(self, within_s: float | None = None) -> bool:
        """Wait until all bytes are written; return whether they were."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._size, within_s)

    def close(self) -> None:
        """Accept no more; waiting bytes are dropped."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _opened(self, fd: int) -> bool:
        """Duplicate a descriptor, so that nobody closes it during a write."""
        try:
            self._own[fd] = os.dup(fd)
        except OSError as err:
            self._errors[fd] = err
            return False
        return True

    def _run(self) -> None:
        while self._next():
            self.taken()
        for own in self._own.values():
            os.close(own)

    def _next(self) -> bool:
        """Write one piece; return whether to go on."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._closed)
            if self._closed:
                self._waiting.clear()
                self._size = 0
                self._changed.notify_all()
                return False
            fd, data = self._waiting[0]
        for start in range(0, len(data), CHUNK_BYTES):
            if self._closed or not self._put(fd, data[start : start + CHUNK_BYTES]):
                break
        with self._changed:
            self._waiting.popleft()
            self._size -= len(data)
            self._changed.notify_all()
        return True

    def _put(self, fd: int, piece: bytes) -> bool:
        own = self._own[fd]
        self._since = time.monotonic()
        try:
            while piece and not self._closed:
                try:
                    piece = piece[os.write(own, piece) :]
                    self._since = time.monotonic()
                except BlockingIOError:  # another owner of the descriptor made it non-blocking
                    select.select([], [own], [], ROOM_S)
        except OSError as err:
            self._errors[fd] = err
            return False
        finally:
            self._since = None
        return True


class Stream:
    """A text file over an outlet. Lines without room are dropped, and their number is written with the next line.

    `strict` raises errors of writing; otherwise they are ignored.
    """

    encoding = "utf-8"

    def __init__(self, outlet: Outlet, fd: int, *, strict: bool = False) -> None:
        self.outlet = outlet
        self._strict = strict
        self._fd = fd
        self._lock = threading.Lock()
        self._rest = ""
        self._left_out = 0

    def write(self, text: str) -> int:
        """Accept text; whole lines are written at once."""
        with self._lock:
            self._rest += text
            if "\n" in text:
                self._send()
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Accept several texts."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Write the beginning of a line, without waiting."""
        with self._lock:
            self._send()

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._fd

    def isatty(self) -> bool:
        """Return whether it is a terminal."""
        return os.isatty(self._fd)

    def _send(self) -> None:
        if self._strict and (error := self.outlet.error(self._fd)) is not None:
            raise error
        text, self._rest = self._rest, ""
        told = f"{left_out(self._left_out)}\n" if self._left_out else ""
        if self.outlet.write(self._fd, (told + text).encode(errors="replace")):
            self._left_out = 0
        else:
            self._left_out += max(1, text.count("\n"))


@contextlib.contextmanager
def unhurried() -> Iterator[Outlet]:
    """Let no output of this process wait for its reader, for the time of a `with`."""
    outlet = Outlet()
    out, err = (cast("IO[str]", Stream(outlet, stream.fileno())) for stream in (sys.stdout, sys.stderr))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            yield outlet
        finally:
            outlet.drain(LAST_OUTPUT_S)
            outlet.close()


def settle() -> None:
    """Give printed output a moment to be read."""
    if isinstance(out := sys.stdout, Stream):
        out.flush()
        out.outlet.drain(LAST_OUTPUT_S)


def say(line: str) -> str:
    """Print a line on standard output, and return the fault of the output, if any; an unread line is not a fault."""
    stream = sys.stdout
    try:
        print(line, flush=True)
    except OSError as err:
        return str(err.strerror)
    if not isinstance(stream, Stream):
        return ""
    stream.outlet.drain(ERROR_S)
    error = stream.outlet.error(stream.fileno())
    return str(error.strerror) if error is not None else ""


def left_out(lines: int) -> str:
    """Return the report for a reader who missed lines."""
    return f"({lines} {'line was' if lines == 1 else 'lines were'} not read in time and left out)"
