"""Writes chunks in its own thread, so that a slow disk delays nothing.

Chunks that the disk cannot take in time are dropped and counted.
"""

import calendar
import errno
import os
import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from lbr.apps.recorder.box.keeping import Keep
from lbr.apps.recorder.recording import chunks
from lbr.apps.recorder.recording.segments import Segment
from lbr.apps.recorder.recording.shelf import Shelf, size_of

MOST_WAITING_BYTES = 16_000_000
LARGEST_BYTES = 64_000_000
"""The largest file of the box; with cameras a file may be full before its time is over."""
PRUNE_S = 10.0
MOST_LINKED = 40
SLOW_S = 2.0
CLOSE_S = 0.4
FULL = frozenset([errno.ENOSPC, errno.EDQUOT])
"""The errors after which an old file is deleted for room; after any other failure old files stay."""


class Chunk(Struct):
    """The records of one round. With `begin`, the head of a new file, the chunk begins that file."""

    parts: list[bytes]
    messages: int
    bytes: int
    start_ns: int
    end_ns: int
    begin: dict[str, str] | None = None


class Bounds(Struct, frozen=True, kw_only=True):
    """The bounds on size and age of the box's files."""

    bytes: int
    seconds: float
    kept_bytes: int
    kept_seconds: float
    free_bytes: int

    def lacks_room(self, folder: Path) -> str:
        """Return why a folder's disk has too little room for others, or cannot be read; empty if it has room."""
        try:
            status = os.statvfs(folder)
        except OSError as err:
            return f"{folder} cannot be looked at ({err.strerror})"
        free = status.f_bavail * status.f_frsize
        wanted = min(self.free_bytes, status.f_blocks * status.f_frsize // 20)
        return (
            "" if free >= wanted else f"{free // 1_000_000} MB are free, and {wanted // 1_000_000} are left to others"
        )


class Disk:
    """Writes one file after the other, at the paths from `place`. Any thread may read its reports.

    With `shelf` and `bounds` it is the box: it deletes old files and links the kept ones. Without them it writes one
    file.
    `trouble` is the problem in one line. After a failure (`broken`) the box drops chunks until one begins another file.
    """

    def __init__(
        self, place: Callable[[], Path], library: str, *, shelf: Shelf | None = None, bounds: Bounds | None = None
    ) -> None:
        self.messages = self.lost = self.size = 0
        self.trouble = ""
        self.broken = True
        self.steady = False
        self.path: Path | None = None
        self.used_bytes = self.kept_bytes = self.kept_count = 0
        self._place = place
        self._library = library
        self._shelf = shelf
        self._bounds = bounds
        self._segment: Segment | None = None
        self._keeps: dict[str, Keep] = {}
        self._waiting_bytes = 0
        self._prune_at = 0.0
        self._jobs: queue.SimpleQueue[Chunk | Keep | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="disk", daemon=True)
        self._thread.start()

    def put(self, chunk: Chunk) -> bool:
        """Queue a chunk to be written; False if it was dropped because the disk is too slow."""
        if self._waiting_bytes + chunk.bytes > MOST_WAITING_BYTES and self._waiting_bytes:
            self.lost += chunk.messages
            self.trouble = "the disk is too slow: what it does not take in time is not recorded"
            return False
        self._waiting_bytes += chunk.bytes
        self._jobs.put(chunk)
        return True

    def keep(self, one: Keep) -> None:
        """Keep the files around an incident."""
        self._jobs.put(one)

    def close(self, within_s: float = CLOSE_S) -> None:
        """Write the queue, finish the file, and stop; what is not written within `within_s` is lost."""
        self._jobs.put(None)
        self._thread.join(within_s)

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            if isinstance(job, Keep):
                self._keep(job)
                continue
            self._waiting_bytes -= job.bytes
            try:
                self._write(job)
            except OSError as err:
                self._fail(
                    job, f"the disk takes nothing ({err.strerror}): nothing is recorded until it does", err.errno
                )
        if self._segment is not None:
            self._segment.finish()
            self._segment = None

    def _write(self, job: Chunk) -> None:
        began = time.monotonic()
        if job.begin is not None:
            self._begin(job.begin)
        if self._segment is None:
            self.lost += job.messages
            return
        self._segment.write(chunks.chunk(job.parts, job.start_ns, job.end_ns))
        self.messages += job.messages
        self.size = self._segment.size
        if self.size > LARGEST_BYTES and self._shelf is not None:
            self.broken = True
        late = time.monotonic() - began > SLOW_S
        self.trouble = "the disk is slow: it took a second's worth for more than two" if late else ""
        if self._shelf is not None and time.monotonic() >= self._prune_at:
            self._prune_at = time.monotonic() + PRUNE_S
            self._prune()

    def _begin(self, about: dict[str, str]) -> None:
        if self._segment is not None and self._shelf is None:
            self.broken = False
            return
        if self._segment is not None:
            self._segment.finish()
            self._segment = None
        if self._shelf is not None:
            self._shelf.make()
            self._leave_room()
        self.path, self.size = self._place(), 0
        self._segment = Segment(self.path, self._library, about)
        self.broken = False
        now = time.monotonic()
        self._keeps = {name: one for name, one in self._keeps.items() if now <= one.until + 1.0}
        for one in self._keeps.values():
            self._link(one, [self.path])

    def _leave_room(self) -> None:
        """Delete old files while the disk has too little room for others; raise OSError if that does not help."""
        assert self._shelf is not None
        assert self._bounds is not None
        while lacks := self._bounds.lacks_room(self._shelf.box):
            if len(self._shelf.files()) < 2 or not self._shelf.drop_oldest():
                raise OSError(errno.EIO, lacks)

    def _prune(self) -> None:
        assert self._shelf is not None
        assert self._bounds is not None
        now = time.time() if self.steady else 0.0
        self._shelf.prune(self._bounds.bytes, self._bounds.seconds, now)
        self._shelf.prune_kept(self._bounds.kept_bytes, self._bounds.kept_seconds, now)
        self._count()

    def _count(self) -> None:
        assert self._shelf is not None
        kept = self._shelf.incidents()
        self.used_bytes = size_of(self._shelf.files())
        self.kept_bytes = size_of({path for one in kept for path in one.files})
        self.kept_count = len(kept)

    def _keep(self, keep: Keep) -> None:
        if self._shelf is None:
            return
        known = keep.name in self._keeps
        self._keeps[keep.name] = keep
        self._link(keep, [] if known else self._before(keep))

    def _before(self, keep: Keep) -> list[Path]:
        """Return the newest files that cover the time before an incident, in the order of their numbers."""
        assert self._shelf is not None
        files, chosen, seconds = self._shelf.files(), [], 0.0
        for path in reversed(files[-MOST_LINKED:]):
            chosen.append(path)
            if seconds >= keep.before_s:
                break
            seconds += _length_s(path)
        return chosen

    def _link(self, keep: Keep, files: list[Path]) -> None:
        assert self._shelf is not None
        try:
            self._shelf.keep(keep.name, keep.why, files)
            self._count()
        except OSError as err:
            self.trouble = f"what led to '{keep.why.kind}' cannot be kept: {err.strerror}"

    def _fail(self, job: Chunk, why: str, code: int | None) -> None:
        self.lost += job.messages
        self.trouble = why
        self.broken = True
        if self._segment is not None and self._shelf is not None:
            self._segment.close()
            self._segment = None
        if code in FULL and self._shelf is not None and len(self._shelf.files()) > 1:
            self._shelf.drop_oldest()


def _length_s(path: Path) -> float:
    """Return about how long a file is, from the time in its name to its last change."""
    try:
        begun = calendar.timegm(time.strptime(path.name[9:25], "%Y%m%dT%H%M%SZ"))
        return min(3600.0, max(0.0, path.stat().st_mtime - begun))
    except (OSError, ValueError):
        return 0.0
