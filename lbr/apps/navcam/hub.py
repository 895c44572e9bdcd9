"""The newest picture for each viewer: who is slow misses pictures, and keeps nobody else waiting.

Everything here runs on the event loop's thread; the bus library's thread only wakes it.
"""

import asyncio
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from lbr.apps.http.turns import Turns
from lbr.apps.navcam.cameras import name_in
from lbr.bus import pictures, wire
from lbr.bus.session import Session

MOST_VIEWERS, MOST_OF_ONE = 8, 4
DEPTH = 8
CURRENT_S = 1.0


class Viewer:
    """One open stream: a slot for the newest picture of a camera (empty: of the one that is on).

    `session` is the mark of the session by which its viewer came in; empty for the token.
    """

    def __init__(self, camera: str, session: str = "") -> None:
        self.camera = camera
        self.session = session
        self._slot: bytes | None = None
        self._over = False
        self._news = asyncio.Event()

    def show(self, picture: bytes) -> None:
        """Put a picture in the place of one that was not sent yet."""
        self._slot = picture
        self._news.set()

    def end(self) -> None:
        """Let there be no more pictures."""
        self._over = True
        self._news.set()

    async def next(self) -> bytes | None:
        """Return the next picture once there is one; None when there are no more."""
        while True:
            await self._news.wait()
            self._news.clear()
            if self._over:
                return None
            picture, self._slot = self._slot, None
            if picture is not None:
                return picture


class Hub:
    """Takes pictures from the bus while somebody watches, and deals them out."""

    def __init__(self, bus: Session, robot: str) -> None:
        self._bus = bus
        self._key = f"{robot}/camera_$*/frame"
        self._viewers: set[Viewer] = set()
        self._feed: wire.Subscription | None = None
        self._current = ("", 0.0)
        self._closed = False
        self._turns = Turns(MOST_OF_ONE, MOST_VIEWERS)

    def full(self, who: str) -> str:
        """Return how many watch already, where one more of an address would be too many; else nothing."""
        return "all" if self._closed else self._turns.why_not(who)

    @contextmanager
    def viewer(self, camera: str, who: str, session: str = "") -> Iterator[Viewer]:
        """Watch for the time of a `with`."""
        viewer = Viewer(camera, session)
        self._viewers.add(viewer)
        try:
            if self._feed is None:
                self._feed = self._listen()
            with self._turns.taken(who):
                yield viewer
        finally:
            self._viewers.discard(viewer)
            if not self._viewers and self._feed is not None:
                self._feed.close()
                self._feed = None

    def end(self, knows: Callable[[str], bool]) -> None:
        """End the streams of sessions that are not known any more."""
        for viewer in self._viewers:
            if viewer.session and not knows(viewer.session):
                viewer.end()

    def close(self) -> None:
        """End every stream, and begin none."""
        self._closed = True
        for viewer in self._viewers:
            viewer.end()

    def _listen(self) -> wire.Subscription:
        loop = asyncio.get_running_loop()

        def wake() -> None:
            with suppress(RuntimeError):  # the loop is closed already
                loop.call_soon_threadsafe(self._deal)

        return wire.Subscription(self._bus, self._key, depth=DEPTH, wake=wake)

    def _deal(self) -> None:
        for raw in self._feed.take() if self._feed is not None else ():
            if not pictures.is_whole(raw.payload):
                continue
            camera = name_in(raw.key)
            current, seen = self._current
            if camera == current or time.monotonic() - seen > CURRENT_S:
                self._current = (camera, time.monotonic())
            for viewer in self._viewers:
                if camera == (viewer.camera or self._current[0]):
                    viewer.show(raw.payload)
