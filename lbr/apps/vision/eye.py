"""Searches the newest picture, on a thread of its own: a slow detector searches few pictures, and delays nothing."""

import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from lbr.apps.vision.finding import Finder
from lbr.capability.context import Received
from lbr.errors import InputError
from lbr.messages.camera import CameraState
from lbr.messages.tracking import Seen

MOST_LOOKS = 8
NO_PICTURES = "no pictures come from the camera, or only old ones"


class Look(NamedTuple):
    """The result of one picture, which was taken then."""

    taken_s: float
    seen: Seen | None


class Eye:
    """The search. `trouble` is why it cannot run, or empty; `ready`: it can."""

    def __init__(self, make: Callable[[], Finder], wake: Callable[[], None]) -> None:
        self.trouble = ""
        self.ready = False
        self._make = make
        self._wake = wake
        self._next: tuple[bytes, float] | None = None
        self._looks: deque[Look] = deque(maxlen=MOST_LOOKS)
        self._news = threading.Condition()
        self._closed = False
        threading.Thread(target=self._run, name="eye", daemon=True).start()

    def look(self, picture: bytes, taken_s: float) -> None:
        """Search a picture soon, unless a newer one comes first."""
        with self._news:
            self._next = (picture, taken_s)
            self._news.notify()

    def looks(self) -> list[Look]:
        """Return the results since the last call, oldest first."""
        with self._news:
            found = list(self._looks)
            self._looks.clear()
        return found

    def close(self) -> None:
        """End the search."""
        with self._news:
            self._closed = True
            self._news.notify()

    def _run(self) -> None:
        try:
            find = self._make()
            self.ready = True
            self._wake()
            while (picture := self._wait()) is not None:
                self._see(Look(picture[1], find(picture[0])))
        except InputError as err:
            self.trouble = str(err)
            self._wake()

    def _see(self, look: Look) -> None:
        with self._news:
            self._looks.append(look)
        self._wake()

    def _wait(self) -> tuple[bytes, float] | None:
        with self._news:
            self._news.wait_for(lambda: self._next is not None or self._closed)
            picture, self._next = self._next, None
            return None if self._closed else picture


def camera_off(received: Received | None) -> str:
    """Return the camera's own reason why there are no pictures; empty without one."""
    if received is None:
        return ""
    state: CameraState = received.message
    if state.phase in {"off", "lost"}:
        return f"the camera is {state.phase}: {state.reason or f'switch {received.source} on'}"
    return ""
