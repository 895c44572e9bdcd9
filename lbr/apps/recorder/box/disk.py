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
    """Writes one file, at the path from `place`. Any thread may read its reports.

    `trouble` is the problem in one line. After a failure (`broken`) chunks are lost until one begins a file.
    """

    def __init__(self, place: Callable[[], Path], library: str) -> None:
        self.messages = self.lost = self.size = 0
        self.trouble = ""
        self.broken = True
        self.path: Path | None = None
        self._place = place
        self._library = library
        self._segment: Segment | None = None
        self._waiting_bytes = 0
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
                why = f"the disk takes nothing ({err.strerror}): nothing is recorded until it does"
                self.lost, self.trouble, self.broken = self.lost + job.messages, why, True
                self._failed(err.errno)
        self._finish()

    def _write(self, job: Chunk) -> None:
        began = time.monotonic()
        if job.begin is not None:
            self._begin(job.begin)
            self.broken = False
        if self._segment is None:
            self.lost += job.messages
            return
        self._segment.write(chunks.chunk(job.parts, job.start_ns, job.end_ns))
        self.messages += job.messages
        self.size = self._segment.size
        late = time.monotonic() - began > SLOW_S
        self.trouble = "the disk is slow: it took a second's worth for more than two" if late else ""
        self._written()

    def _begin(self, about: dict[str, str]) -> None:
        if self._segment is None:
            self.path, self.size = self._place(), 0
            self._segment = Segment(self.path, self._library, about)

    def _finish(self) -> None:
        if self._segment is not None:
            self._segment.finish()
            self._segment = None

    def _written(self) -> None:
        """Look after the files, after each chunk."""

    def _failed(self, code: int | None) -> None:
        """React to a failure of the disk."""

    def _keep(self, keep: Keep) -> None:
        """Keep the files around an incident, if there are several."""


class BoxDisk(Disk):
    """Writes the files of the box one after the other, deletes old ones, and links the kept ones.

    `steady`: ages can be judged by the clock.
    """

    def __init__(self, shelf: Shelf, bounds: Bounds, library: str) -> None:
        self.steady = False
        self.used_bytes = self.kept_bytes = self.kept_count = 0
        self._shelf = shelf
        self._bounds = bounds
        self._keeps: dict[str, Keep] = {}
        self._prune_at = 0.0
        super().__init__(shelf.next_file, library)

    def keep(self, one: Keep) -> None:
        """Keep the files around an incident."""
        self._jobs.put(one)

    def _begin(self, about: dict[str, str]) -> None:
        self._finish()
        self._shelf.make()
        self._leave_room()
        super()._begin(about)
        now = time.monotonic()
        self._keeps = {name: one for name, one in self._keeps.items() if now <= one.until + 1.0}
        for one in self._keeps.values():
            self._link(one, [self.path] if self.path is not None else [])

    def _leave_room(self) -> None:
        """Delete old files while the disk has too little room for others; raise OSError if that does not help."""
        while lacks := self._bounds.lacks_room(self._shelf.box):
            if len(self._shelf.files()) < 2 or not self._shelf.drop_oldest():
                raise OSError(errno.EIO, lacks)

    def _written(self) -> None:
        self.broken = self.broken or self.size > LARGEST_BYTES
        if time.monotonic() < self._prune_at:
            return
        self._prune_at = time.monotonic() + PRUNE_S
        now = time.time() if self.steady else 0.0
        self._shelf.prune(self._bounds.bytes, self._bounds.seconds, now)
        self._shelf.prune_kept(self._bounds.kept_bytes, self._bounds.kept_seconds, now)
        self._count()

    def _failed(self, code: int | None) -> None:
        if self._segment is not None:
            self._segment.close()
            self._segment = None
        if code in FULL and len(self._shelf.files()) > 1:
            self._shelf.drop_oldest()

    def _keep(self, keep: Keep) -> None:
        known = keep.name in self._keeps
        self._keeps[keep.name] = keep
        self._link(keep, [] if known else self._before(keep))

    def _before(self, keep: Keep) -> list[Path]:
        """Return the newest files that cover the time before an incident, in the order of their numbers."""
        files, chosen, seconds = self._shelf.files(), [], 0.0
        for path in reversed(files[-MOST_LINKED:]):
            chosen.append(path)
            if seconds >= keep.before_s:
                break
            seconds += _length_s(path)
        return chosen

    def _link(self, keep: Keep, files: list[Path]) -> None:
        try:
            self._shelf.keep(keep.name, keep.why, files)
            self._count()
        except OSError as err:
            self.trouble = f"what led to '{keep.why.kind}' cannot be kept: {err.strerror}"

    def _count(self) -> None:
        kept = self._shelf.incidents()
        self.used_bytes = size_of(self._shelf.files())
        self.kept_bytes = size_of({path for one in kept for path in one.files})
        self.kept_count = len(kept)


def _length_s(path: Path) -> float:
    """Return about how long a file is, from the time in its name to its last change."""
    try:
        begun = calendar.timegm(time.strptime(path.name[9:25], "%Y%m%dT%H%M%SZ"))
        return min(3600.0, max(0.0, path.stat().st_mtime - begun))
    except (OSError, ValueError):
        return 0.0
