"""The newest picture for each viewer: a slow viewer misses pictures, and does not delay the others.

All but `close` runs on the thread of the server's event loop.
"""

import asyncio
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from lbr.apps.http.turns import Turns

MOST_VIEWERS, MOST_OF_ONE = 8, 4
CURRENT_S = 1.0
Deal = Callable[[str, bytes], None]


class Viewer:
    """One open stream: a slot for the newest picture of a camera (empty: of the active one), while its client is
    `known`."""

    def __init__(self, camera: str, known: Callable[[], bool]) -> None:
        self.camera = camera
        self._known = known
        self._slot: bytes | None = None
        self._over = False
        self._news = asyncio.Event()

    def show(self, picture: bytes) -> None:
        """Replace the unsent picture."""
        self._slot = picture
        self._news.set()

    def end(self) -> None:
        """End the stream."""
        self._over = True
        self._news.set()

    async def next(self) -> bytes | None:
        """Wait for the next picture; None at the end of the stream."""
        while True:
            with suppress(TimeoutError):
                async with asyncio.timeout(CURRENT_S):
                    await self._news.wait()
            self._news.clear()
            if self._over or not self._known():
                return None
            picture, self._slot = self._slot, None
            if picture is not None:
                return picture


class Hub:
    """Deals pictures to viewers.

    With the first viewer `begin` starts the pictures, each to `deal`, and returns their stop. `known` is whether the
    client of a mark is still known.
    """

    def __init__(self, begin: Callable[[Deal], Callable[[], None]], known: Callable[[str], bool]) -> None:
        self._begin = begin
        self._known = known
        self._end: Callable[[], None] | None = None
        self._viewers: set[Viewer] = set()
        self._current = ("", 0.0)
        self._closed = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._turns = Turns(MOST_OF_ONE, MOST_VIEWERS)

    def full(self, who: str) -> str:
        """Return why a client may not open one more stream; empty if it may."""
        return "all" if self._closed else self._turns.why_not(who)

    @contextmanager
    def viewer(self, camera: str, asker: str, mark: str = "") -> Iterator[Viewer]:
        """Watch during a `with`."""
        viewer = Viewer(camera, lambda: not mark or self._known(mark))
        self._viewers.add(viewer)
        try:
            if self._end is None:
                self._loop = asyncio.get_running_loop()
                self._end = self._begin(self.deal)
            with self._turns.turn(asker):
                yield viewer
        finally:
            self._viewers.discard(viewer)
            if not self._viewers and self._end is not None:
                self._end()
                self._end = None

    def deal(self, camera: str, picture: bytes) -> None:
        """Show a picture to the viewers of its camera, and of the active camera."""
        current, seen = self._current
        if camera == current or time.monotonic() - seen > CURRENT_S:
            self._current = (camera, time.monotonic())
        for viewer in self._viewers:
            if camera == (viewer.camera or self._current[0]):
                viewer.show(picture)

    def close(self) -> None:
        """End all streams, and refuse new ones; from any thread."""
        self._closed = True
        if self._loop is not None:
            with suppress(RuntimeError):  # the loop, and with it all streams, has ended
                self._loop.call_soon_threadsafe(self._close)

    def _close(self) -> None:
        for viewer in self._viewers:
            viewer.end()
