"""Takes pictures in a thread of its own: opens the camera, keeps the newest picture, reopens a lost camera."""

import os
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Literal

from lbr.drivers.camera.picture import Picture, Source, usable
from lbr.errors import DeviceError

SILENT_S = 1.0
FIRST_S = 3.0
OLDEST_S = 1.0
RETRY_FIRST_S = 0.2
RETRY_MOST_S = 2.0
STEADY_S = 5.0
REST_FPS = 2.0
"""The rate of pictures of a camera without a viewer: a snapshot is never older than half a second."""

Phase = Literal["opening", "streaming", "lost"]


class Capture:
    """The thread of one camera, and its newest picture. It calls `wake` when there is something new.

    It closes a camera that is silent for 1 s (or 2.5 pictures, if longer), and retries after 0.2 s, growing to 2 s.
    While it `rests`, only `REST_FPS` pictures a second are kept.
    """

    def __init__(self, open_source: Callable[[], Source], wake: Callable[[], None], *, fps: float) -> None:
        self.phase: Phase = "opening"
        self.reason = ""
        self.dropped = 0
        self.ended = False  # the camera is closed for good
        self._open_source = open_source
        self._wake = wake
        self._fps = fps
        self.rests = self._pace_is_rest = False
        self._kept_at = 0.0
        self._slot: deque[Picture] = deque(maxlen=1)
        self._over = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self.stopping = False
        self._thread = threading.Thread(target=self._run, name="capture", daemon=True)
        self._thread.start()

    def take(self) -> Picture | None:
        """Return the newest picture, or None if it was already taken."""
        with suppress(IndexError):
            return self._slot.popleft()
        return None

    def stop(self) -> None:
        """Ask the thread to close the camera; `ended` is true afterwards."""
        if not self.stopping:
            self.stopping = True
            os.eventfd_write(self._over, 1)

    def rest(self, *, rests: bool) -> None:
        """Reduce the rate of pictures, or restore it."""
        if rests != self.rests and not self.stopping:
            self.rests = rests
            os.eventfd_write(self._over, 1)

    def join(self, timeout_s: float) -> None:
        """Wait for the thread to end, then free its resources."""
        self._thread.join(timeout_s)
        if not self._thread.is_alive() and self._over >= 0:
            os.close(self._over)
            self._over = -1

    def _run(self) -> None:
        retry_s = RETRY_FIRST_S
        while not self.stopping:
            began = time.monotonic()
            try:
                self._stream(self._open_source())
            except DeviceError as err:
                self._tell("lost", str(err))
            if time.monotonic() - began > STEADY_S:
                retry_s = RETRY_FIRST_S
            if select.select([self._over], [], [], 0.0 if self.stopping else retry_s)[0]:
                os.eventfd_read(self._over)
            retry_s = min(retry_s * 2, RETRY_MOST_S)
        self.ended = True
        self._wake()

    def _stream(self, source: Source) -> None:
        self._pace_is_rest = False
        try:
            arrived_s, allowed_s = time.monotonic(), FIRST_S
            while not self.stopping:
                self._set_pace(source)
                left_s = allowed_s - (time.monotonic() - arrived_s)
                readable, _, _ = select.select([source.fileno(), self._over], [], [], max(0.0, left_s))
                if self._over in readable:
                    os.eventfd_read(self._over)
                    continue
                if self._keep(source.take() if source.fileno() in readable else []):
                    arrived_s, allowed_s = time.monotonic(), max(SILENT_S, 2.5 / self._pace())
                elif left_s <= 0.0:
                    raise DeviceError(f"no picture has come for {allowed_s:.1f} s; check the camera's cable")
        finally:
            source.close()

    def _pace(self) -> float:
        return min(self._fps, REST_FPS) if self.rests else self._fps

    def _set_pace(self, source: Source) -> None:
        if self._pace_is_rest != self.rests:
            self._pace_is_rest = self.rests
            source.pace(self._pace())

    def _keep(self, pictures: list[Picture]) -> bool:
        """Keep the newest picture unless it is old; return whether there was a usable one."""
        good = [whole for picture in pictures if (whole := usable(picture))]
        now = time.monotonic()
        if good and self.rests and self.phase == "streaming" and now - self._kept_at < 0.9 / REST_FPS:
            return True
        fresh = [picture for picture in good[-1:] if now - picture.taken_s <= OLDEST_S]
        self.dropped += len(pictures) - len(fresh)
        if fresh and not self.stopping:
            self._kept_at = now
            self.dropped += len(self._slot)
            self._slot.append(fresh[0])
            self._tell("streaming")
        return bool(good)

    def _tell(self, phase: Phase, reason: str = "") -> None:
        self.phase, self.reason = phase, reason
        self._wake()
